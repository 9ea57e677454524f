"""Read the server's parameters."""

from __future__ import annotations

import os
from pathlib import Path

import rospy

from flexbe_synthesizer.edge.package_path import find_packages
from flexbe_synthesizer.request import Settings


def read_settings() -> Settings:
    """Return the settings that the private parameters of this node give.

    Raises:
        ValueError: if the package to write to does not exist.
    """
    ros_package_path = os.environ.get("ROS_PACKAGE_PATH", "")
    packages, _warnings = find_packages(ros_package_path)
    folders = [Path(f) for f in rospy.get_param("~chart_folders", "").split(os.pathsep) if f]
    if not folders:
        folders = sorted(p.folder / "charts" for p in packages if p.has_behaviors)
        folders.append(Path(rospy.get_param("~user_charts", "~/remodel_charts")).expanduser())
    output = rospy.get_param("~output", "remodel_behaviors")
    if os.sep in output:
        return Settings(tuple(folders), Path(output), ros_package_path)
    for package in packages:
        if package.name == output:
            return Settings(tuple(folders), package.folder, ros_package_path)
    raise ValueError(
        f"there is no package '{output}' on the ROS package path to write behaviors to; set "
        "~output (launch argument output) to a package's name or folder"
    )


def read_time_limit() -> float:
    """Return how long a request may take [s]."""
    return float(rospy.get_param("~time_limit", 60.0))
