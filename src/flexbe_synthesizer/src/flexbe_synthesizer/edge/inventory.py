"""What is installed on a ROS package path, read again only when some of it has changed."""

from __future__ import annotations

import os
import threading
from dataclasses import dataclass
from pathlib import Path

from flexbe_synthesizer.core.library.library import Library
from flexbe_synthesizer.edge.package_path import Package, find_packages, read_library
from flexbe_synthesizer.edge.stamps import Stamps

_MOST_PATHS = 4  # whose packages are remembered; a process has one


@dataclass(frozen=True)
class Inventory:
    """The packages on a ROS package path, what charts can name of them, and warnings."""

    packages: tuple[Package, ...]
    library: Library
    warnings: tuple[str, ...]
    path: tuple[Path, ...]

    def rank(self, folder: Path) -> int:
        """Return the place on the path of the folder of a package, which need not be there yet."""
        around = (folder.resolve(), *folder.resolve().parents)
        return next((i for i, entry in enumerate(self.path) if entry in around), len(self.path))


_known: dict[str, tuple[Stamps, Inventory]] = {}
_lock = threading.Lock()


def read_inventory(package_path: str) -> Inventory:
    """Return what is on a ROS package path: the same value for as long as nothing there changes.

    Folders and files are compared by their stamps; what has changed within the last two seconds
    is read again each time, since a second change could leave the same stamp.
    """
    with _lock:
        known = _known.get(package_path)
        if known is not None and known[0].still_hold():
            return known[1]
        seen = Stamps()
        packages, path_warnings = find_packages(package_path, seen)
        library, warnings = read_library(packages, seen)
        path = tuple(Path(entry).resolve() for entry in package_path.split(os.pathsep) if entry)
        found = Inventory(packages, library, (*path_warnings, *warnings), path)
        _known.pop(package_path, None)
        _known[package_path] = seen, found
        while len(_known) > _MOST_PATHS:
            del _known[next(iter(_known))]
        return found
