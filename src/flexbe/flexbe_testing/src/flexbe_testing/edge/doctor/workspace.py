"""The FlexBE packages of a workspace."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

_EXPORTS = ("flexbe_states", "flexbe_behaviors")
_SKIPPED = {"build", "devel", "install", "logs"}


@dataclass(frozen=True)
class Package:
    """A package that exports states or behaviors.

    Attributes:
        name: its name.
        folder: its folder.
        modules: the folder with its Python package, to be put on the path.
    """

    name: str
    folder: Path
    modules: Path

    def files(self) -> list[Path]:
        """Return its Python files."""
        return sorted((self.modules / self.name).rglob("*.py"))


def packages(workspace: Path) -> Iterator[Package]:
    """Yield the FlexBE packages below a folder, as catkin finds packages."""
    for folder, subfolders, files in os.walk(workspace):
        if "CATKIN_IGNORE" in files:
            subfolders.clear()
            continue
        if "package.xml" in files:
            subfolders.clear()
            if (name := _exporting(Path(folder) / "package.xml")) is not None:
                yield _package(name, Path(folder))
            continue
        subfolders[:] = sorted(
            name for name in subfolders if name not in _SKIPPED and not name.startswith(".")
        )


def _package(name: str, folder: Path) -> Package:
    modules = folder / "src" if (folder / "src" / name).is_dir() else folder
    return Package(name, folder, modules)


def _exporting(file: Path) -> str | None:
    """Return the name of a package that exports states or behaviors.

    A package whose package.xml is not XML gets the name of its folder, so that it is examined too.
    """
    try:
        root = ElementTree.parse(file).getroot()
    except ElementTree.ParseError:
        text = file.read_text(errors="replace")
        return file.parent.name if any(element in text for element in _EXPORTS) else None
    if all(root.find(f"export/{element}") is None for element in _EXPORTS):
        return None
    return (root.findtext("name") or "").strip() or None
