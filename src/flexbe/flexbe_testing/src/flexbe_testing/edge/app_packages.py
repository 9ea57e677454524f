"""Find what the FlexBE App knows: states and behaviors of ROS packages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from xml.etree import ElementTree

from flexbe_testing.app.behavior import BehaviorDefinition
from flexbe_testing.app.known import Known
from flexbe_testing.app.load import define_behavior
from flexbe_testing.app.states import StateDefinition, read_state
from flexbe_testing.app.text import AppLoadError


def read_packages(folders: Iterable[Path]) -> Known:
    """Return what the App finds in the folders of packages, in which it looks for exports."""
    states: list[StateDefinition] = []
    behaviors: list[BehaviorDefinition] = []
    for folder in folders:
        package = ElementTree.parse(folder / "package.xml").getroot()
        exports = {entry.tag for export in package.iter("export") for entry in export}
        modules = folder / "src" / (package.findtext("name") or "").strip()
        if "flexbe_states" in exports:
            states += read_states(modules)
        if "flexbe_behaviors" in exports:
            behaviors += _read_behaviors(folder, modules)
    return Known(states, behaviors)


def read_states(folder: Path) -> Iterator[StateDefinition]:
    """Yield the state of each file in the module folder of a package."""
    for file in sorted(folder.rglob("*.py")):
        if file.name != "__init__.py":
            module = ".".join(file.relative_to(folder.parent).with_suffix("").parts)
            found = read_state(file.read_text(encoding="utf-8"), module)
            if found is not None:
                yield found


def _read_behaviors(folder: Path, modules: Path) -> Iterator[BehaviorDefinition]:
    """Yield the behaviors of a package's manifests; those that the App cannot load are left out."""
    for file in sorted((folder / "manifest").glob("*.xml")):
        executable = ElementTree.parse(file).getroot().find("executable")
        module = "" if executable is None else executable.get("package_path", "")
        code = modules / f"{module.partition('.')[2]}.py"
        if module.count(".") != 1 or not code.is_file():
            continue
        try:
            yield define_behavior(code.read_text(encoding="utf-8"), module)
        except AppLoadError:
            continue
