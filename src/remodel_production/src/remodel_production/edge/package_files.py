"""Where packages' data files are, in a source, devel or install space."""

from functools import cache
from pathlib import Path

import rospkg


@cache  # of a process; finding packages takes longer than planning most problems
def package_folder(package: str) -> Path:
    """Return the folder of a package on the ROS package path."""
    return Path(rospkg.RosPack().get_path(package))


def catalogue_file() -> Path:
    """Return the path of the catalogue."""
    return package_folder("remodel_production") / "config/catalogue.yaml"


def wire_list_mappings() -> list[Path]:
    """Return the paths of the mappings of wire lists."""
    return sorted((package_folder("remodel_production") / "config/wire_lists").glob("*.yaml"))
