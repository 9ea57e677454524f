"""What is installed: behaviors with their checksums, states with their documentation."""

from __future__ import annotations

import ast
import zlib
from dataclasses import dataclass
from pathlib import Path

from flexbe_synthesizer.core.library.signature import BehaviorClass, StateClass
from flexbe_synthesizer.edge.files import read_regular_text
from flexbe_synthesizer.edge.package_path import Inventory, read_inventory


@dataclass(frozen=True)
class Installed:
    """A behavior that is installed.

    Attributes:
        behavior_id: by which the engine finds it.
        source_checksum: by which the engine publishes that it runs, and verifies the version.
    """

    behavior: BehaviorClass
    behavior_id: int
    source_checksum: int

    @property
    def name(self) -> str:
        """Return its display name."""
        return self.behavior.name


@dataclass(frozen=True)
class Catalogue:
    """What the packages of a ROS package path offer at the moment of each call."""

    ros_package_path: str

    def behaviors(self) -> tuple[Installed, ...]:
        """Return the behaviors that are installed, by name."""
        inventory = self._inventory()
        folders = {package.name: package.module_folder for package in inventory.packages}
        found = []
        for behavior in inventory.library.behaviors:
            text = _text(_file(folders[behavior.package], behavior.module))
            if text is not None:
                found.append(Installed(behavior, _checksum(behavior.module), _checksum(text)))
        return tuple(sorted(found, key=lambda one: one.name))

    def states(self) -> tuple[StateClass, ...]:
        """Return the state classes that are installed, by package and name."""
        return tuple(
            sorted(self._inventory().library.states, key=lambda state: (state.package, state.name))
        )

    def documentation(self, state: StateClass) -> str:
        """Return the docstring of a state class; empty if there is none."""
        packages = self._inventory().packages
        folder = next((p.module_folder for p in packages if p.name == state.package), None)
        text = _text(_file(folder, state.module)) if folder else None
        for node in ast.parse(text or "").body:
            if isinstance(node, ast.ClassDef) and node.name == state.name:
                return ast.get_docstring(node) or ""
        return ""

    def _inventory(self) -> Inventory:
        return read_inventory(self.ros_package_path)


def _file(folder: Path, module: str) -> Path:
    return folder.joinpath(*module.split(".")[1:]).with_suffix(".py")


def _text(file: Path) -> str | None:
    try:
        return read_regular_text(file)
    except (OSError, ValueError):
        return None


def _checksum(text: str) -> int:
    """Return the checksum of FlexBE's wire protocol: Adler-32, cut to 31 bits."""
    return zlib.adler32(text.encode()) & 0x7FFFFFFF
