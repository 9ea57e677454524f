"""All behaviors on the ROS package path: packages, manifests and sources.

rospkg is not used to find them for two reasons: it caches what it found for the life of the
process, and one malformed package.xml anywhere on the path makes it raise.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from xml.etree import ElementTree

import rospkg
import rospy

from flexbe_core.engine.supervision import checksum

# Here packages are direct children, and below are the files of everything else on the machine.
_SYSTEM_SHARE = "/usr/share"

# What ElementTree raises: the last two for an encoding that it does not know, or cannot read.
XML_ERRORS = (ElementTree.ParseError, LookupError, ValueError)


def packages_exporting(element: str, warn: Callable[[str], None]) -> dict[str, Path]:
    """Return the folders of packages whose package.xml exports `element`, by their names.

    Args:
        element: name of the element inside <export>.
        warn: called with a message for each package.xml that cannot be read.
    """
    found: dict[str, Path] = {}
    for folder, name, package in _packages(element, warn):
        if name and package.find(f"export/{element}") is not None:
            found.setdefault(name, folder)
    return found


def package_folder(name: str) -> Path | None:
    """Return the folder of a ROS package; None if there is none."""
    found = _packages(name, lambda text: None)
    return next((folder for folder, its_name, _ in found if its_name == name), None)


def named_file(name: str) -> Path:
    """Return the path of a file that is named absolutely, from home, or as package/folder/file.

    Raises:
        FileNotFoundError: if there is no such package.
    """
    if name.startswith(("/", "~")):
        return Path(os.path.expanduser(name))  # Path.expanduser raises for an unknown user
    package, _, rest = name.partition("/")
    folder = package_folder(package)
    if folder is None:
        raise FileNotFoundError(
            f"cannot find file {name!r}: there is no ROS package {package!r}; "
            "write package/file, ~/file or /file"
        )
    return folder / rest


def _packages(
    word: str, warn: Callable[[str], None]
) -> Iterator[tuple[Path, str, ElementTree.Element]]:
    """Yield folder, name and package.xml of the packages whose package.xml has a word in it."""
    for folder in (each for root in rospkg.get_ros_paths() for each in _package_folders(root)):
        file = folder / "package.xml"
        try:
            text = file.read_bytes()
            if word.encode() in text:
                package = ElementTree.fromstring(text)
                yield folder, (package.findtext("name") or "").strip(), package
        except (OSError, *XML_ERRORS) as error:
            warn(f"{file} is left out: {error}")


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
    except XML_ERRORS as error:
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


# [bytes] No manifest is longer; a longer file was written by mistake, or to do harm.
_LONGEST_MANIFEST = 1 << 20


class BehaviorLibrary:
    """The behaviors of all packages that export flexbe_behaviors.

    A behavior's id is the checksum of its package path, package.module. Manifests that cannot be
    read are left out, with one warning each. Behaviors, manifests and packages that are added
    later are found when they are requested, by any thread.
    """

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._warned: set[str] = set()
        self._added: list[tuple[str, str | None]] = []
        self.parse_packages()

    def parse_packages(self) -> None:
        """Read the manifests of all packages again."""
        self._behavior_lib: dict[int, dict[str, str]] = {}
        self._files: dict[int, tuple[Path, int]] = {}
        self._ids: dict[str, int] = {}
        self._folders = packages_exporting("flexbe_behaviors", self._warn)
        for package, folder in self._folders.items():
            self._read_manifests(str(folder), package)
        for path, pkg in self._added:
            self._read_manifests(path, pkg)

    def get_behavior(self, behavior_id: int) -> dict[str, str] | None:
        """Return a behavior's name, package, file and class; None if there is none with this id."""
        with self._lock:
            if behavior_id not in self._behavior_lib or self._is_outdated(behavior_id):
                self.parse_packages()
            return self._behavior_lib.get(behavior_id)

    def find_behavior(self, name: str) -> tuple[int, dict[str, str]] | tuple[None, None]:
        """Return id and entry of the behavior with this display name, or None twice."""
        with self._lock:
            found = self._ids.get(name)
            if found is None or self._is_outdated(found):
                self.parse_packages()
                found = self._ids.get(name)
            return (None, None) if found is None else (found, self._behavior_lib[found])

    def count_behaviors(self) -> int:
        """Return the number of behaviors."""
        return len(self._behavior_lib)

    def names(self) -> tuple[str, ...]:
        """Return the display names of all behaviors, sorted."""
        with self._lock:
            return tuple(sorted({entry["name"] for entry in self._behavior_lib.values()}))

    def get_sourcecode_filepath(self, behavior_id: int, add_tmp: bool = False) -> str | None:
        """Return the path of a behavior's source file; None if there is none.

        Args:
            behavior_id: id of the behavior.
            add_tmp: return the path of the operator's unsaved version instead, which need not
                exist.
        """
        entry = self.get_behavior(behavior_id)
        if entry is None:
            return None
        package = entry["package"].split(".")[0]
        module_path = f"{entry['package']}.{entry['file']}"
        file = source_file(package, module_path, self._folders.get(package))
        if file is None:
            return None
        return str(file.with_name(f"{file.stem}_tmp.py") if add_tmp else file)

    def _add_behavior_manifests(self, path: str, pkg: str | None = None) -> None:
        """Add all behaviors whose manifests lie below a folder, besides those of packages.

        Args:
            path: the folder.
            pkg: package whose behaviors are added; None for all.
        """
        self._added.append((path, pkg))
        self._read_manifests(path, pkg)

    def _read_manifests(self, path: str, pkg: str | None) -> None:
        for file in _xml_files(Path(path)):
            try:
                manifest = _read(file)
                if manifest is not None and pkg in (None, manifest.package):
                    self._add(manifest, file)
            except (OSError, ManifestError) as error:
                self._warn(f"manifest {file} is left out: it {error}")

    def _add(self, manifest: Manifest, file: Path) -> None:
        same = self._ids.get(manifest.name)
        behavior_id = checksum(manifest.package_path)
        if same is not None and same != behavior_id:
            self._warn(
                f"there are two behaviors named {manifest.name!r}: "
                f"{self._files[same][0]} is used, {file} is left out"
            )
            return
        if before := self._behavior_lib.get(behavior_id):
            self._ids.pop(before["name"], None)
        package, _, module = manifest.package_path.rpartition(".")
        self._behavior_lib[behavior_id] = {
            "name": manifest.name,
            "package": package,
            "file": module,
            "class": manifest.class_name,
        }
        self._files[behavior_id] = (file, file.stat().st_mtime_ns)
        self._ids[manifest.name] = behavior_id

    def _is_outdated(self, behavior_id: int) -> bool:
        file, read_at = self._files[behavior_id]
        try:
            return file.stat().st_mtime_ns != read_at
        except OSError:
            return True

    def _warn(self, text: str) -> None:
        if text not in self._warned:
            self._warned.add(text)
            rospy.logwarn("behavior library: %s", text)


def _xml_files(folder: Path) -> Iterator[Path]:
    """Yield the files that may be manifests, in a fixed order; reading a FIFO would never end."""
    for at, folders, files in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith((".", "#")))
        for name in sorted(files):
            file = Path(at, name)
            is_named_so = name.endswith(".xml") and not name.startswith((".", "#"))
            if is_named_so and name != "package.xml" and file.is_file():
                yield file


def _read(file: Path) -> Manifest | None:
    status = file.stat()
    if status.st_size > _LONGEST_MANIFEST:
        raise ManifestError(f"is {status.st_size} bytes long; at most {_LONGEST_MANIFEST} are read")
    return _read_version(file, (status.st_mtime_ns, status.st_size))


@lru_cache(maxsize=1 << 14)  # each new behavior has all manifests searched
def _read_version(file: Path, _version: tuple[int, int]) -> Manifest | None:
    """Return the manifest that a version of a file holds; None if it holds none."""
    return read_manifest(file.read_bytes())
