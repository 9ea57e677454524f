"""Find the packages on the ROS package path that export something.

rospkg is not used for two reasons: it caches what it found for the life of the process, and one
malformed package.xml anywhere on the path makes it raise.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from xml.etree import ElementTree

import rospkg

# Here packages are direct children, and below are the files of everything else on the machine.
_SYSTEM_SHARE = "/usr/share"


def packages_exporting(element: str, warn: Callable[[str], None]) -> dict[str, Path]:
    """Return the folders of packages whose package.xml exports `element`, by their names.

    Args:
        element: name of the element inside <export>.
        warn: called with a message for each package.xml that cannot be read.
    """
    found: dict[str, Path] = {}
    for root in rospkg.get_ros_paths():
        for folder in _package_folders(root):
            name = _name_if_exporting(folder / "package.xml", element, warn)
            if name is not None:
                found.setdefault(name, folder)
    return found


def _package_folders(root: str) -> Iterator[Path]:
    seen: set[str] = set()
    for folder, subfolders, files in os.walk(root, followlinks=True):
        real = os.path.realpath(folder)
        if real in seen or "CATKIN_IGNORE" in files:
            subfolders.clear()
            continue
        seen.add(real)
        if "package.xml" in files:
            yield Path(folder)
            subfolders.clear()
        elif folder.startswith(_SYSTEM_SHARE + "/"):
            subfolders.clear()
        else:
            subfolders[:] = sorted(name for name in subfolders if not name.startswith("."))


def _name_if_exporting(file: Path, element: str, warn: Callable[[str], None]) -> str | None:
    try:
        text = file.read_bytes()
        if element.encode() not in text:
            return None
        root = ElementTree.fromstring(text)
    except (OSError, ElementTree.ParseError) as error:
        warn(f"{file} is left out: {error}")
        return None
    if root.find(f"export/{element}") is None:
        return None
    return (root.findtext("name") or "").strip() or None
