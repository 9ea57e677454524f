"""Where this package's data files are, in a source, devel or install space."""

from pathlib import Path

import rospkg

_PACKAGE = "remodel_production"


def catalogue_file() -> Path:
    """Return the path of the catalogue."""
    return _folder() / "config" / "catalogue.yaml"


def wire_list_mappings() -> list[Path]:
    """Return the paths of the mappings of wire lists."""
    return sorted((_folder() / "config" / "wire_lists").glob("*.yaml"))


def _folder() -> Path:
    return Path(rospkg.RosPack().get_path(_PACKAGE))
