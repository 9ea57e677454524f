"""Design files on disk, the mappings of wire lists, and placements."""

from __future__ import annotations

from pathlib import Path

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.imports.placement import with_placement
from remodel_production.core.imports.shared.text_encoding import decode
from remodel_production.core.imports.wire_lists.mapping import WireListMapping, mapping_from
from remodel_production.edge.package_files import wire_list_mappings
from remodel_production.errors import DesignError, blamed

# The largest example of QElectroTech has 3.5 MB, a vehicle's harness as KBL some 50 MB.
_MOST_BYTES = 100_000_000


def read_design(file: Path) -> bytes:
    """Return the content of a file.

    Raises:
        DesignError: if it cannot be read, or is too large for any design.
    """
    try:
        with file.open("rb") as stream:
            data = stream.read(_MOST_BYTES + 1)
    except OSError as error:
        raise DesignError(f"{file}: cannot be read: {error.strerror}") from error
    if len(data) > _MOST_BYTES:
        raise DesignError(
            f"{file}: is larger than {_MOST_BYTES // 1_000_000} MB, the most that is read: is it a "
            "design file?"
        )
    return data


def read_mappings(file: Path | None) -> tuple[WireListMapping, ...]:
    """Return the mapping in a file, or those of the package if there is none.

    Raises:
        DesignError: naming the file and the line if a mapping is malformed.
    """
    files = [file] if file is not None else wire_list_mappings()
    return tuple(_read_mapping(each) for each in files)


def read_placement(file: Path | None, catalogue: Catalogue) -> Catalogue:
    """Return a catalogue in which the placement in a file counts first; itself if there is none.

    Raises:
        DesignError: naming the file and the line if the placement is malformed.
    """
    if file is None:
        return catalogue
    data = read_design(file)
    with blamed(file):
        return with_placement(catalogue, decode(data)[0])


def _read_mapping(file: Path) -> WireListMapping:
    data = read_design(file)
    try:
        return mapping_from(decode(data)[0])
    except DesignError as error:
        raise DesignError(f"{file}: {error}") from error
