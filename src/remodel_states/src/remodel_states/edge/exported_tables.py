"""Find the tables of abilities and faults of all packages on the ROS package path.

A package exports its tables in its package.xml:

    <export>
      <remodel_states abilities="${prefix}/config/abilities.yaml"
                      faults="${prefix}/config/faults.yaml"/>
    </export>
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

import rospkg

from flexbe_core.edge.package_path import packages_exporting
from remodel_states.core.fault_tables import CONTRACT, FaultTables
from remodel_states.edge.table_files import faults_from
from remodel_states.errors import TableError

EXPORT = "remodel_states"


def read_faults() -> FaultTables:
    """Return the error codes and faults of all packages on the ROS package path.

    Raises:
        TableError: if a table cannot be read, or two contradict each other.
    """
    folders = exporting_packages()
    return faults_from(_exported(folders, "faults"), folders[CONTRACT])


def exporting_packages() -> dict[str, Path]:
    """Return the folders of the packages that export tables, that of the contract first.

    Raises:
        TableError: if remodel_msgs is not among them.
    """
    found = packages_exporting(EXPORT, lambda text: None)
    if CONTRACT not in found:
        paths = ":".join(rospkg.get_ros_paths())
        raise TableError(CONTRACT, [f"not on the ROS package path ({paths}); source its workspace"])
    return {CONTRACT: found.pop(CONTRACT), **dict(sorted(found.items()))}


def _exported(folders: Mapping[str, Path], table: str) -> dict[str, Path]:
    """Return the file of a table in each package that exports one."""
    found = {}
    for package, folder in folders.items():
        element = ElementTree.parse(folder / "package.xml").find(f"export/{EXPORT}")
        path = element.get(table, "") if element is not None else ""
        if path:
            found[package] = Path(path.replace("${prefix}", str(folder)))
    return found
