"""Read the table of wire materials."""

from __future__ import annotations

from pathlib import Path

import rospkg
import yaml

from remodel_sim.core.errors import MaterialError
from remodel_sim.core.workpiece.wire_materials import WireMaterials, materials_from


def read_wire_materials(path: Path | None = None) -> WireMaterials:
    """Read a table of wire materials, the package's own unless a path is given.

    Raises:
        MaterialError: when the file cannot be read or is no such table.
    """
    file = path or Path(rospkg.RosPack().get_path("remodel_sim")) / "config/wire_materials.yaml"
    try:
        return materials_from(yaml.safe_load(file.read_text()))
    except (OSError, yaml.YAMLError, MaterialError) as error:
        raise MaterialError(f"{file}: {error}") from error
