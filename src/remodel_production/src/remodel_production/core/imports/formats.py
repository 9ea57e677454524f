"""The design formats of this package, and which format a file has by its content."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.imports.assembly import with_access, with_mounts
from remodel_production.core.imports.design_format import DesignFile, DesignFormat
from remodel_production.core.imports.documents import (
    decode,
    is_spreadsheet,
    local_name,
    other_spreadsheet,
    parse_xml,
    sheets_of,
)
from remodel_production.core.imports.kbl import import_kbl
from remodel_production.core.imports.qet import import_qet
from remodel_production.core.imports.values import Imported
from remodel_production.core.imports.vec import ROOT, import_vec
from remodel_production.core.imports.wire_list import import_wire_list
from remodel_production.core.imports.wire_list_mapping import WireListMapping
from remodel_production.core.imports.wire_list_table import has_headings, without_ends
from remodel_production.core.imports.wireviz import import_wireviz, join_files
from remodel_production.errors import DesignError
from remodel_run.whole_task import counted
from remodel_states.core.wires import MaterialError


def with_wire_properties(imported: Imported, catalogue: Catalogue) -> Imported:
    """Return the import with a line for each section of which what wires are like is calculated."""
    sections = Counter(wire.section_mm2 for wire in imported.order.wires)
    lines = []
    for section, count in sorted(sections.items()):
        wires = f"{counted(count, 'wire')} of {section:g} mm2"
        try:
            origin = catalogue.materials.origin("", section)
        except MaterialError as error:
            lines.append(f"{wires}: {error}")
        else:
            lines += [f"{wires}: properties {origin}"] if origin else []
    return imported.assuming(lines)


WIRE_LIST = "csv"

_WIREVIZ = re.compile(r"^(connectors|cables|connections)\s*:", re.MULTILINE)


def built_in_formats(mappings: Sequence[WireListMapping]) -> tuple[DesignFormat, ...]:
    """Return the formats of this package, with the known mappings of wire lists."""

    def is_wireviz(file: DesignFile) -> bool:
        return not file.is_markup and _WIREVIZ.search(file.text) is not None

    def is_wire_list(file: DesignFile) -> bool:
        if not is_spreadsheet(file.data) and (not file.text or file.is_markup or is_wireviz(file)):
            return False
        return has_headings(file.data, mappings)

    def read_wire_list(data: bytes, name: str, source: str, catalogue: Catalogue) -> Imported:
        return import_wire_list(data, name, source, catalogue, mappings=mappings)

    return (
        DesignFormat(
            "qet",
            "QElectroTech projects (<project>)",
            lambda file: file.xml_root == "project",
            import_qet,
        ),
        DesignFormat(
            "kbl",
            "KBL harnesses (<KBL_container>)",
            lambda file: file.xml_root.lower() == "kbl_container",
            import_kbl,
            import_kbl,
        ),
        DesignFormat(
            "vec",
            "VEC harnesses (<VecContent>)",
            lambda file: file.xml_root == ROOT,
            import_vec,
            import_vec,
        ),
        DesignFormat(
            "wireviz",
            "WireViz harnesses (YAML with `connections`)",
            is_wireviz,
            import_wireviz,
            join=join_files,
        ),
        DesignFormat(
            WIRE_LIST, "wire lists (CSV or XLSX with known headings)", is_wire_list, read_wire_list
        ),
    )


def format_of(data: bytes, formats: Sequence[DesignFormat]) -> DesignFormat:
    """Return the format, of some, of a file with such content.

    Raises:
        DesignError: if it has none of them, with what was found, or several.
    """
    if not data.strip():
        raise DesignError("the file is empty")
    file = DesignFile(data)
    fitting = [form for form in formats if form.fits(file)]
    if not fitting:
        raise _unknown(file, formats)
    if len(fitting) > 1:
        names = " or ".join(f"--format {form.name}" for form in fitting)
        raise DesignError(f"several formats recognise the file; choose one: {names}")
    return fitting[0]


def import_design(
    data: bytes, form: DesignFormat, name: str, source: str, catalogue: Catalogue
) -> Imported:
    """Read a design file, and fill in by the catalogue what it does not say.

    A design without a title is called by its file.

    Raises:
        DesignError: if it is refused, with the place, what was found, and what is needed.
    """
    imported = form.read(data, name, source, catalogue)
    if not imported.order.title:
        imported = replace(imported, order=replace(imported.order, title=source))
    mounted = with_mounts(imported, catalogue)
    return with_wire_properties(with_access(mounted, catalogue), catalogue)


def _unknown(file: DesignFile, formats: Sequence[DesignFormat]) -> DesignError:
    *titles, last = (form.title for form in formats)
    known = f"{', '.join(titles)}, and {last}" if titles else last
    if is_spreadsheet(file.data):
        sheets_of(file.data)  # a workbook that cannot be read is refused for that reason
        return DesignError(
            "no sheet of the workbook has the headings of a wire list"
            + without_ends(file.data)
            + "; --print-mapping prints a mapping to correct, for --mapping"
        )
    if other := other_spreadsheet(file.data):
        return DesignError(f"is {other}: save it as .xlsx or .csv, and import that")
    if file.data.startswith(b"PK\x03\x04"):
        return DesignError(f"is a ZIP archive; unpack it, and import the file in it: {known}")
    text, _ = decode(file.data)
    if file.is_markup:
        root = local_name(parse_xml(file.data))
        return DesignError(f"the root element is <{root}>; what is read: {known}")
    first = next((line.strip() for line in text.splitlines() if line.strip()), "")
    return DesignError(
        f"line 1: {first[:80]!r} begins no format that is read: {known}; a CSV file with other "
        f"headings needs --mapping{without_ends(file.data)}; --print-mapping prints a mapping to "
        "correct, and --format forces a format"
    )
