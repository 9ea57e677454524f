"""Find the packages on the ROS package path, and the state classes and behaviors in them.

Only text is read. What cannot be read costs a warning and nothing else: a broken package somewhere
on the path is no reason not to use the others.
"""

from __future__ import annotations

import errno
import importlib.util
import os
import re
import sys
import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar
from xml.etree import ElementTree

import yaml

from flexbe_synthesizer.core.chart.error_routes import ListedCode, error_names, read_error_table
from flexbe_synthesizer.core.library.signature import BehaviorClass, Library, StateClass, Unreadable
from flexbe_synthesizer.core.library.sources import (
    Manifest,
    read_behavior_class,
    read_manifest,
    read_state_class,
)
from flexbe_synthesizer.edge.files import Stamp, Stamps, read_regular, read_regular_text

if TYPE_CHECKING:
    from functools import _lru_cache_wrapper

# Files that are remembered as they were read last: those of orders with thousands of tasks as well.
_REMEMBERED = 1 << 14
_TABLES = "remodel_states"  # the export whose attributes are files of tables
_LISTING_CODES = ("faults", "abilities")  # the attributes whose files may list error codes
_LARGEST_MANIFEST = 2**20  # [bytes]; what is larger is something else

_PACKAGE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")  # a dot would have a package imported

_Content = TypeVar("_Content")


@dataclass(frozen=True)
class Package:
    """A ROS package, and which exports its package.xml has.

    Attributes:
        name: of the package.
        folder: of its package.xml.
        has_states: it exports `<flexbe_states/>`.
        has_behaviors: it exports `<flexbe_behaviors/>`.
        code_tables: the files of `<remodel_states faults="..." abilities="..."/>`, which list error
            codes.
    """

    name: str
    folder: Path
    has_states: bool = False
    has_behaviors: bool = False
    code_tables: tuple[Path, ...] = ()

    @property
    def module_folder(self) -> Path:
        """Return the folder of its Python package: in the sources, else where it is installed."""
        source = self.folder / "src" / self.name
        if source.is_dir():
            return source
        spec = importlib.util.find_spec(self.name)  # of a top-level name: nothing is imported
        locations = spec.submodule_search_locations if spec else None
        return Path(locations[0]) if locations else source


def read_package(folder: Path) -> Package:
    """Return the package of a folder that has a package.xml.

    Raises:
        ValueError: if the package.xml cannot be read or names no package.
        OSError: if it is not there.
    """
    try:
        root = ElementTree.fromstring(read_regular(folder / "package.xml"))
    except (ElementTree.ParseError, LookupError) as error:  # an unknown encoding
        raise ValueError(f"{folder / 'package.xml'} is not well-formed: {error}") from error
    name = (root.findtext("name") or "").strip()
    if not _PACKAGE_NAME.fullmatch(name):
        raise ValueError(f"{folder / 'package.xml'} names no package: {name!r}")
    exports = {child.tag for export in root.iter("export") for child in export}
    return Package(
        name,
        folder,
        has_states="flexbe_states" in exports,
        has_behaviors="flexbe_behaviors" in exports,
        code_tables=tuple(_code_tables(root, folder)),
    )


def _code_tables(root: ElementTree.Element, folder: Path) -> Iterator[Path]:
    """Yield the tables of error codes that a package.xml exports.

    A table of abilities may list codes, too. remodel_states reads the same files.
    """
    exported = {
        key: path for each in root.findall(f"export/{_TABLES}") for key, path in each.items()
    }
    for path in filter(None, map(exported.get, _LISTING_CODES)):
        yield Path(path.replace("${prefix}", str(folder)))


def find_packages(
    package_path: str, seen: Stamps | None = None
) -> tuple[tuple[Package, ...], tuple[str, ...]]:
    """Return the packages below the folders of a ROS_PACKAGE_PATH, and warnings.

    A folder with a package.xml is not searched further, nor one with a CATKIN_IGNORE. Of two
    packages of one name the first on the path counts.

    Args:
        package_path: folders, separated by `os.pathsep`.
        seen: takes the stamps of all that was read.
    """
    seen = Stamps() if seen is None else seen
    packages: dict[str, Package] = {}
    warnings: list[str] = []
    for folder in _package_folders(package_path, seen):
        try:
            seen.take(folder / "package.xml")
            package = read_package(folder)
        except (ValueError, OSError) as error:
            warnings.append(f"{error}; the package is left out")
        else:
            packages.setdefault(package.name, package)
    return tuple(packages.values()), tuple(warnings)


def _package_folders(package_path: str, seen: Stamps) -> Iterator[Path]:
    visited: set[str] = set()  # links may lead in circles
    for top in filter(None, package_path.split(os.pathsep)):
        seen.take(top)
        for folder, inner, files in os.walk(top, followlinks=True):
            place = os.path.realpath(folder)
            if place in visited:
                inner.clear()
                continue
            visited.add(place)
            if "package.xml" in files and "CATKIN_IGNORE" not in files:
                yield Path(folder)
            if "package.xml" in files or "CATKIN_IGNORE" in files:
                inner.clear()
            inner[:] = sorted(name for name in inner if not name.startswith("."))
            for name in inner:
                seen.take(f"{folder}/{name}")


def read_library(
    packages: Sequence[Package], seen: Stamps | None = None
) -> tuple[Library, tuple[str, ...]]:
    """Return what charts can name of the packages, and warnings.

    Args:
        packages: where to look.
        seen: takes the stamps of all that was read.
    """
    seen = Stamps() if seen is None else seen
    warnings: list[str] = []
    states = tuple(_read_states((p for p in packages if p.has_states), warnings, seen))
    behaviors = tuple(_read_behaviors((p for p in packages if p.has_behaviors), warnings, seen))
    folders = {package.name: package.module_folder for package in packages if package.has_behaviors}
    library = Library(
        states=tuple(s for s in states if isinstance(s, StateClass)),
        behaviors=tuple(b for b in behaviors if isinstance(b, BehaviorClass)),
        unreadable_states=tuple(s for s in states if isinstance(s, Unreadable)),
        unreadable_behaviors=tuple(b for b in behaviors if isinstance(b, Unreadable)),
        error_names=error_names(_read_error_codes(packages, warnings, seen)),
        text_of=BehaviorFiles(folders),
    )
    return library, tuple(warnings)


@dataclass(frozen=True)
class BehaviorFiles:
    """The files of behaviors, by the folders of their Python packages."""

    folders: Mapping[str, Path]

    def __call__(self, behavior: BehaviorClass) -> str:
        """Return the text of a behavior's file, empty if it cannot be read."""
        package, *module = behavior.module.split(".")
        try:
            path = self.folders[package].joinpath(*module).with_suffix(".py")
            return read_regular_text(path)
        except (KeyError, OSError, ValueError):
            return ""


def _files_below(top: Path, suffix: str, seen: Stamps) -> list[Path]:
    """Return the files with a suffix in a folder and below it, sorted; links are not followed."""
    seen.take(top)
    found = []
    for folder, inner, files in os.walk(top):
        found += [Path(folder, name) for name in (*files, *inner) if name.endswith(suffix)]
        for name in inner:
            seen.take(f"{folder}/{name}")
    return sorted(found)


def _module_folder(package: Package, seen: Stamps) -> Path:
    """Return the folder of a package's Python package."""
    source = package.folder / "src" / package.name
    if seen.take(source) is None:
        for folder in sys.path:  # what is installed may appear there
            seen.take(folder)
    return package.module_folder


def _read_states(
    packages: Iterable[Package], warnings: list[str], seen: Stamps
) -> Iterator[StateClass | Unreadable]:
    """Yield the state class of each file of the packages that has one."""
    for package in packages:
        top = _module_folder(package, seen)
        for path in _files_below(top, ".py", seen):
            if path.name == "__init__.py":
                continue
            module = ".".join((package.name, *path.relative_to(top).with_suffix("").parts))
            try:
                state = _read(_read_state, path, seen, package.name, module)
            except (OSError, SyntaxError, ValueError, RecursionError, MemoryError) as error:
                reason = str(error) or "its code is nested too deeply"
                warnings.append(f"{path} cannot be read: {reason}; its state is left out")
            else:
                if state is not None:
                    yield state


def _read(
    reader: _lru_cache_wrapper[_Content], path: Path, seen: Stamps, *more: object
) -> _Content:
    """Return what a reader makes of a file, from memory if it has read this version before."""
    stamp = seen.take(path)
    read = reader.__wrapped__ if stamp is None or stamp.is_fresh else reader
    return read(path, stamp, *more)


@lru_cache(maxsize=_REMEMBERED)  # a file that changes does not have the others read again
def _read_state(
    path: Path, _version: Stamp | None, package: str, module: str
) -> StateClass | Unreadable | None:
    """Return the state class of a version of a file, None if it has none."""
    text = read_regular_text(path)
    may_hold_one = "(EventState)" in text  # parsing is slow
    return read_state_class(text, package, module) if may_hold_one else None


def _read_error_codes(
    packages: Iterable[Package], warnings: list[str], seen: Stamps
) -> Iterator[ListedCode]:
    """Yield the error codes of each package that exports some."""
    for path in (path for package in packages for path in package.code_tables):
        try:
            yield from _read(_read_code_table, path, seen)
        except (OSError, ValueError) as error:
            warnings.append(f"{path} cannot be read: {error}; its error codes are left out")


@lru_cache(maxsize=_REMEMBERED)
def _read_code_table(path: Path, _version: Stamp | None) -> tuple[ListedCode, ...]:
    """Return the error codes that a version of a file has."""
    try:
        return read_error_table(yaml.safe_load(read_regular_text(path)))
    except (yaml.YAMLError, RecursionError) as error:
        raise ValueError(str(error)) from error


def _read_behaviors(
    packages: Iterable[Package], warnings: list[str], seen: Stamps
) -> Iterator[BehaviorClass | Unreadable]:
    """Yield the behavior of each manifest of the packages."""
    for package in packages:
        module_folder = _module_folder(package, seen)
        for path in _files_below(package.folder, ".xml", seen):
            if path.name.startswith("#"):
                continue
            try:
                manifest = _read(_read_manifest, path, seen)
            except OSError as error:
                if error.errno != errno.EFBIG:
                    warnings.append(f"{path} cannot be read: {error}")
                continue
            if manifest is not None and manifest.package == package.name:
                source = module_folder.joinpath(*manifest.module.split("."))
                yield _read(_read_behavior, source.with_suffix(".py"), seen, manifest)


@lru_cache(maxsize=_REMEMBERED)
def _read_manifest(path: Path, _version: Stamp | None) -> Manifest | None:
    """Return the manifest that a version of a file holds; None if it holds none."""
    return read_manifest(read_regular(path, _LARGEST_MANIFEST), str(path))


@lru_cache(maxsize=_REMEMBERED)
def _read_behavior(
    path: Path, _version: Stamp | None, manifest: Manifest
) -> BehaviorClass | Unreadable:
    """Return the behavior class of a version of a file."""
    try:
        text = read_regular_text(path)
    except (OSError, ValueError) as error:
        reason = f"its file cannot be read: {error}"
        return Unreadable(manifest.name, manifest.package, reason, manifest.class_name)
    return read_behavior_class(text, manifest)


# What is installed on a ROS package path, read again only when some of it has changed


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
        entries = filter(None, package_path.split(os.pathsep))
        path = tuple(Path(os.path.realpath(entry)) for entry in entries)
        found = Inventory(packages, library, (*path_warnings, *warnings), path)
        _known.pop(package_path, None)
        _known[package_path] = seen, found
        while len(_known) > _MOST_PATHS:
            del _known[next(iter(_known))]
        return found
