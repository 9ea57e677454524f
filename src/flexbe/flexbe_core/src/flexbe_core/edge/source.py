"""Find the source file of a module of a package, without importing either."""

from __future__ import annotations

import sys
from pathlib import Path


def source_file(package: str, module_path: str, package_folder: Path | None) -> Path | None:
    """Return the file of a module, None if there is none.

    The source layouts of catkin packages are searched first, then the Python path, where
    installed packages are.

    Args:
        package: name of the ROS package.
        module_path: dotted path of the module, beginning with the package.
        package_folder: folder of the package.xml, if known.
    """
    relative = Path(*module_path.split(".")).with_suffix(".py")
    roots = [Path(entry) for entry in sys.path if entry]
    if package_folder is not None:
        roots = [package_folder / "src", package_folder, *roots]
    return next((root / relative for root in roots if (root / relative).is_file()), None)
