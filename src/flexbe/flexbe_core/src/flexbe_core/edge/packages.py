"""Find the packages that export something, read their manifests, and find their sources.

rospkg is not used to find them for two reasons: it caches what it found for the life of the
process, and one malformed package.xml anywhere on the path makes it raise.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
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


# Read a behavior's manifest.
#
# <behavior name="Example Behavior">
#   <executable package_path="my_behaviors.example_behavior_sm" class="ExampleBehaviorSM"/>
#   ...
# </behavior>


class ManifestError(ValueError):
    """A manifest that names a behavior, but not well enough to find it."""


@dataclass(frozen=True)
class Manifest:
    """What a manifest says about where the behavior is.

    Attributes:
        name: display name.
        package_path: dotted path of the module, from its package on.
        class_name: class of the behavior; empty if the manifest does not name it.
    """

    name: str
    package_path: str
    class_name: str

    @property
    def package(self) -> str:
        """The ROS package."""
        return self.package_path.split(".")[0]


def read_manifest(text: bytes) -> Manifest | None:
    """Return what a manifest says; None if the file is not a manifest.

    Raises:
        ManifestError: if it is one, and faulty.
    """
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ManifestError(f"is not well-formed XML: {error}") from error
    if root.tag != "behavior":
        return None
    executable = root.find("executable")
    if executable is None:
        raise ManifestError("has no <executable package_path=... class=...> in its <behavior>")
    name, path = root.get("name", ""), executable.get("package_path", "")
    if not name:
        raise ManifestError("has no name: write <behavior name=...>")
    if not all(part.isidentifier() for part in path.split(".")) or "." not in path:
        raise ManifestError(f"has package_path {path!r}; write package.module, without .py")
    return Manifest(name, path, executable.get("class", ""))


# Find the source file of a module of a package, without importing either


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
