"""From a start request to the class of its behavior: find, check and import the source."""

from __future__ import annotations

import ast
import contextlib
import importlib
import importlib.abc
import importlib.machinery
import importlib.util
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

import rospy

from flexbe_core import Behavior, BehaviorLibrary
from flexbe_core.behavior import paired
from flexbe_core.behavior_library import packages_exporting
from flexbe_core.engine.supervision import checksum


class StartError(Exception):
    """A start request cannot be granted; the text says why and what to do."""


class OptionError(ValueError):
    """A parameter of the node is invalid."""


@dataclass(frozen=True)
class Modification:
    """A replacement of characters [begin, end) of the unmodified text."""

    begin: int
    end: int
    content: str


def modified(text: str, modifications: Sequence[Modification]) -> str:
    """Return the text with all modifications.

    Raises:
        StartError: if they are not in ascending order, overlap or reach beyond the text.
    """
    parts, position = [], 0
    for index, change in enumerate(modifications):
        if not position <= change.begin <= change.end <= len(text):
            raise StartError(
                f"modification {index} replaces characters {change.begin} to {change.end}; it must "
                f"begin at {position} or later, behind the one before, and end by {len(text)}"
            )
        parts += [text[position : change.begin], change.content]
        position = change.end
    return "".join([*parts, text[position:]])


# Read input values, which arrive as the text of Python literals


class AttributeDict(dict[str, Any]):
    """A dict whose values can be read as attributes too, as states of stock FlexBE expect."""

    def __getattr__(self, key: str) -> Any:  # noqa: ANN401 - whatever was sent
        """Return the value of a key."""
        try:
            return self[key]
        except KeyError as error:
            raise AttributeError(f"no value named {key!r}") from error


def read_inputs(keys: Sequence[str], values: Sequence[str]) -> dict[str, Any]:
    """Return the inputs of a start request; see paired for what it raises."""
    return {key: read_value(value) for key, value in paired(keys, values)}


def read_value(text: str) -> Any:  # noqa: ANN401 - whatever was sent
    """Return the value of a literal; other text stays a string. Nothing is evaluated."""
    try:
        return _with_attributes(ast.literal_eval(text))
    except (ValueError, SyntaxError, MemoryError, RecursionError, TypeError):
        return text


def _with_attributes(value: Any) -> Any:  # noqa: ANN401 - likewise
    if isinstance(value, dict):
        return AttributeDict({key: _with_attributes(item) for key, item in value.items()})
    if isinstance(value, list):
        return [_with_attributes(item) for item in value]
    return value


class _CheckedSource(importlib.abc.InspectLoader):
    """Loads a module from a text, so that exactly what was checked is what runs."""

    def __init__(self, text: str, path: str) -> None:
        self._text = text
        self._path = path

    def get_source(self, fullname: str) -> str:
        """Return the text, for tracebacks too."""
        return self._text

    def get_code(self, fullname: str) -> CodeType:
        """Compile the text; no bytecode file is read, which might be older than the text."""
        return self.source_to_code(self._text, self._path)


def load_behavior(
    library: BehaviorLibrary,
    behavior_id: int,
    wanted_checksum: int,
    modifications: Sequence[Modification] = (),
) -> type[Behavior]:
    """Return the class of a behavior.

    Args:
        library: where to find it.
        behavior_id: id in the library.
        wanted_checksum: checksum of the source, after the modifications.
        modifications: changes to the installed source.

    Raises:
        StartError: if it cannot be found, is another version, or cannot be imported.
    """
    entry = library.get_behavior(behavior_id)
    if entry is None:
        raise StartError(
            f"there is no behavior with id {behavior_id} on this computer; "
            f"there are: {', '.join(library.names()) or 'none'}"
        )
    name, module_name = entry["name"], f"{entry['package']}.{entry['file']}"
    path = library.get_sourcecode_filepath(behavior_id)
    if path is None:
        raise StartError(f"behavior {name!r} has no source: found no file for {module_name}")
    text = modified(_read(path), modifications)
    if checksum(text) != wanted_checksum:
        raise StartError(
            f"behavior {name!r} is another version here: {path} has checksum {checksum(text)}, "
            f"the request has {wanted_checksum}; install the same version on both computers"
        )
    if modifications:
        module_name = f"tmp_{wanted_checksum}"
    module = _import(module_name, text, path)
    return _behavior_class(module, entry["class"], path)


def _read(path: str) -> str:
    try:
        return Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise StartError(f"cannot read {path}: {error}") from error


def _import(name: str, text: str, path: str) -> ModuleType:
    loader = _CheckedSource(text, path)
    spec = importlib.machinery.ModuleSpec(name, loader, origin=path)
    spec.has_location = True
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        importing(lambda: loader.exec_module(module))
    except (Exception, SystemExit) as error:
        sys.modules.pop(name, None)
        raise StartError(f"cannot import {path}: {type(error).__name__}: {error}") from error
    return module


def _behavior_class(module: ModuleType, named: str, path: str) -> type[Behavior]:
    """Return the class that the manifest names, or else the only behavior of the module."""
    found = {
        name: value
        for name, value in vars(module).items()
        if isinstance(value, type)
        and issubclass(value, Behavior)
        and value.__module__ == module.__name__
    }
    if named in found:
        return found[named]
    if len(found) == 1:
        return next(iter(found.values()))
    raise StartError(
        f"{path} has no class {named!r} that is a Behavior; "
        f"it has: {', '.join(found) or 'none'}; correct the class in the manifest"
    )


# Import what behaviors import: from the Python path, or else from the ROS package path.
#
# A package that is on the ROS package path but was not built into the workspace has its modules in
# src/, which is not on the Python path.


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


# Forget modules whose files have changed, so that the next run imports them again.
#
# A behavior may contain others, and states: Python would import each once in the life of the
# engine. One change makes the engine forget all modules of packages that export behaviors or
# states.


Stamp = tuple[int, int]


class ModuleFreshness:
    """The modules imported for behaviors, and the stamps of their files at that time."""

    def __init__(self) -> None:
        self._own = frozenset(sys.modules)
        self._stamps: dict[str, tuple[str, Stamp | None]] = {}
        self._packages: dict[str, bool] = {}

    def remember(self) -> None:
        """Remember the stamps of the modules that were imported since the last call."""
        for name in set(sys.modules) - self._own - self._stamps.keys():
            # Without getattr, which imports what a lazy module stands for.
            file = getattr(sys.modules.get(name), "__dict__", {}).get("__file__")
            if file and self._is_of_behaviors(name.split(".")[0], Path(file)):
                self._stamps[name] = (file, _stamp(file))

    def forget_changed(self) -> None:
        """Forget all modules of behaviors and states if one of their files has changed."""
        changed = [file for file, stamp in self._stamps.values() if _stamp(file) != stamp]
        for file in changed:
            # Python compares bytecode and source by whole seconds, and would miss a fast change.
            with contextlib.suppress(OSError, NotImplementedError):
                Path(importlib.util.cache_from_source(file)).unlink()
        if changed:
            self.forget_all()

    def forget_all(self) -> None:
        """Forget all modules of behaviors and states."""
        for name in self._stamps:
            sys.modules.pop(name, None)
        self._stamps.clear()
        importlib.invalidate_caches()

    def _is_of_behaviors(self, package: str, file: Path) -> bool:
        """Return whether a module's package exports behaviors or states."""
        if package not in self._packages:
            self._packages[package] = _exports_behaviors(package, file)
        return self._packages[package]


def _exports_behaviors(package: str, file: Path) -> bool:
    """Read the package.xml above the source, or beside the lib folder it is installed in."""
    for folder in file.parents:
        for manifest in (folder / "package.xml", folder / "share" / package / "package.xml"):
            if manifest.is_file():
                text = manifest.read_bytes()
                return b"<flexbe_states" in text or b"<flexbe_behaviors" in text
    return False


def _stamp(file: str) -> Stamp | None:
    try:
        status = Path(file).stat()
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size
