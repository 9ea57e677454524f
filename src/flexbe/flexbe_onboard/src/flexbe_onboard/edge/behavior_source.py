"""From the name of a behavior to its class: find, check and import the source."""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path
from types import CodeType, ModuleType

from flexbe_core import Behavior, BehaviorLibrary
from flexbe_core.engine.events import checksum
from flexbe_onboard.core.modification import Modification, modified
from flexbe_onboard.edge.import_path import importing
from flexbe_onboard.errors import StartError


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
