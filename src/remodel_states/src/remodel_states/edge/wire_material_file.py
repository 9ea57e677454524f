"""Read the table of wire materials, and the user's own beside it."""

from __future__ import annotations

import os
from pathlib import Path

import rospkg
import yaml

from remodel_states.core.fault_tables import CONTRACT
from remodel_states.core.wires.wire_materials import MaterialError, WireMaterials, materials_from

# Files of a user's own materials, separated like those of PATH.
VARIABLE = "REMODEL_WIRE_MATERIALS"
# The C parser takes a tenth of the time.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def read_wire_materials() -> WireMaterials:
    """Return the materials in the files that REMODEL_WIRE_MATERIALS names, then the project's.

    Raises:
        MaterialError: if a file cannot be read or is no such table.
    """
    materials = _read(Path(rospkg.RosPack().get_path(CONTRACT)) / "config/wire_materials.yaml")
    own = [Path(part) for part in os.environ.get(VARIABLE, "").split(os.pathsep) if part]
    for file in reversed(own):
        materials = materials.beside(_read(file))
    return materials


def _read(file: Path) -> WireMaterials:
    try:
        return materials_from(yaml.load(file.read_text(encoding="utf-8"), Loader=_LOADER))
    except (OSError, UnicodeDecodeError, yaml.YAMLError, MaterialError) as error:
        raise MaterialError(f"{file}: {error}") from error
