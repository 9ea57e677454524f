"""Import what behaviors import: from the Python path, or else from the ROS package path.

A package that is on the ROS package path but was not built into the workspace has its modules in
src/, which is not on the Python path.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import rospy

from flexbe_core.edge.packages import packages_exporting


def importing(load: Callable[[], None]) -> None:
    """Call `load`; while a package of states or behaviors is missing, add its folder and try again.

    Raises:
        ModuleNotFoundError: if what is missing is not on the ROS package path either.
        Exception: what else `load` raises.
    """
    while True:
        try:
            return load()
        except ModuleNotFoundError as error:
            if error.name is None or not _add(error.name.split(".")[0]):
                raise


def _add(package: str) -> bool:
    """Make a package of states or behaviors importable; return whether that is new."""
    for element in ("flexbe_states", "flexbe_behaviors"):
        folder = packages_exporting(element, lambda text: None).get(package)
        if folder is not None and str(folder / "src") not in sys.path:
            sys.path.append(str(folder / "src"))
            rospy.loginfo("importing package %s from %s", package, folder / "src")
            return True
    return False
