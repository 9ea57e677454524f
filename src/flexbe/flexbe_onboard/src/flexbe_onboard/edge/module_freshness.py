"""Forget modules whose files have changed, so that the next run imports them again.

A behavior may contain others, and states: Python would import each once in the life of the engine.
One change makes the engine forget all modules of packages that export behaviors or states.
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import sys
from pathlib import Path

Stamp = tuple[int, int]


class ModuleFreshness:
    """The modules imported for behaviors, and the stamps of their files at that time."""

    def __init__(self) -> None:
        """Treat the modules imported so far as the engine's own, which are never forgotten."""
        self._own = frozenset(sys.modules)
        self._stamps: dict[str, tuple[str, Stamp | None]] = {}
        self._packages: dict[str, bool] = {}

    def remember(self) -> None:
        """Remember the stamps of the modules that were imported since the last call."""
        for name in set(sys.modules) - self._own - self._stamps.keys():
            file = getattr(sys.modules.get(name), "__file__", None)
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
