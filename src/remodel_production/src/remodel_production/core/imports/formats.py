"""Which formats are read, and which one a file has by its content."""

from __future__ import annotations

import re
from collections.abc import Sequence
from enum import Enum

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.imports.kbl import import_kbl
from remodel_production.core.imports.qet import import_qet
from remodel_production.core.imports.shared.account import Imported
from remodel_production.core.imports.shared.text_encoding import decode
from remodel_production.core.imports.shared.xml_tree import local_name, parse_xml
from remodel_production.core.imports.terminal_access import with_access
from remodel_production.core.imports.wire_list import (
    fits,
    import_wire_list,
    similar_headings,
)
from remodel_production.core.imports.wire_list_mapping import WireListMapping
from remodel_production.core.imports.wireviz import import_wireviz
from remodel_production.errors import DesignError

_WIREVIZ = re.compile(r"^(connectors|cables|connections)\s*:", re.MULTILINE)


class DesignFormat(Enum):
    """A format of design files; the value is the word of the command line."""

    QET = "qet"
    KBL = "kbl"
    WIREVIZ = "wireviz"
    WIRE_LIST = "csv"


def format_of(data: bytes, mappings: Sequence[WireListMapping]) -> DesignFormat:
    """Return the format of a file by its content.

    Args:
        data: content of the file.
        mappings: of the wire lists that are known.

    Raises:
        DesignError: if it is none that is read, with what was found.
    """
    if not data.strip():
        raise DesignError("the file is empty")
    if data.startswith(b"PK\x03\x04"):
        raise DesignError(f"is a ZIP archive; unpack it, and import the file in it: {_known()}")
    text, _ = decode(data)
    if text.lstrip("\N{ZERO WIDTH NO-BREAK SPACE} \t\r\n").startswith("<"):
        return _format_of_xml(data)
    if _WIREVIZ.search(text):
        return DesignFormat.WIREVIZ
    if fits(data, mappings):
        return DesignFormat.WIRE_LIST
    first = next((line.strip() for line in text.splitlines() if line.strip()), "")
    similar = similar_headings(first)
    hint = f" (similar headings are known: {similar})" if similar else ""
    raise DesignError(
        f"line 1: {first[:80]!r} begins no format that is read: {_known()}; a CSV file with other "
        f"headings needs --mapping{hint}, and --print-mapping prints one to correct; "
        "--format forces a format"
    )


def import_design(
    data: bytes,
    form: DesignFormat,
    name: str,
    source: str,
    catalogue: Catalogue,
    mappings: Sequence[WireListMapping],
) -> Imported:
    """Read a design file, and fill in by the catalogue what it does not say of its terminals.

    Raises:
        DesignError: if it is refused, with the place, what was found, and what is needed.
    """
    if form is DesignFormat.WIRE_LIST:
        imported = import_wire_list(data, name, source, catalogue, mappings=mappings)
    else:
        imported = _IMPORTERS[form](data, name, source, catalogue)
    return with_access(imported, catalogue)


_IMPORTERS = {
    DesignFormat.QET: import_qet,
    DesignFormat.KBL: import_kbl,
    DesignFormat.WIREVIZ: import_wireviz,
}


def _format_of_xml(data: bytes) -> DesignFormat:
    root = local_name(parse_xml(data))
    if root == "project":
        return DesignFormat.QET
    if root.lower() == "kbl_container":
        return DesignFormat.KBL
    raise DesignError(f"the root element is <{root}>; what is read: {_known()}")


def _known() -> str:
    return (
        "QElectroTech projects (<project>), KBL harnesses (<KBL_container>), WireViz harnesses "
        "(YAML with `connections`), and wire lists (CSV with known headings)"
    )
