"""Find what the FlexBE App knows: states and behaviors of ROS packages."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from xml.etree import ElementTree

import rospkg

from flexbe_testing.core.app.behavior import BehaviorDefinition, Known
from flexbe_testing.core.app.load import define_behavior
from flexbe_testing.core.app.states import StateDefinition, read_state
from flexbe_testing.core.app.text import AppLoadError

_EXPORTS = ("flexbe_states", "flexbe_behaviors")


def flexbe_packages() -> list[Path]:
    """Return the folders of all packages on the ROS package path that export states or behaviors.

    Raises:
        ValueError: if a package.xml is not XML.
    """
    ros = rospkg.RosPack()
    folders = [Path(ros.get_path(name)) for name in sorted(ros.list())]
    return [folder for folder in folders if _exports(folder) & set(_EXPORTS)]


def read_packages(folders: Iterable[Path]) -> Known:
    """Return what the App finds in the folders of packages that export states or behaviors.

    Raises:
        ValueError: if a package.xml or manifest is not XML, or a module not UTF-8.
    """
    states: list[StateDefinition] = []
    behaviors: list[BehaviorDefinition] = []
    for folder in folders:
        exports = _exports(folder)
        if "flexbe_states" in exports:
            states += read_states(_modules(folder))
        if "flexbe_behaviors" in exports:
            behaviors += _read_behaviors(folder)
    return Known(states, behaviors)


def read_states(folder: Path) -> Iterator[StateDefinition]:
    """Yield the state of each file in the module folder of a package."""
    for file in sorted(folder.rglob("*.py")):
        if file.name != "__init__.py":
            module = ".".join(file.relative_to(folder.parent).with_suffix("").parts)
            found = read_state(read_source(file), module)
            if found is not None:
                yield found


def read_source(file: Path) -> str:
    """Return the text of a file.

    Raises:
        ValueError: if it is not UTF-8; the text names the file.
    """
    try:
        return file.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(f"{file} is not UTF-8: {error.reason} at byte {error.start}") from error


def behavior_files(folder: Path) -> Iterator[tuple[Path, Path]]:
    """Yield manifest and code of each behavior of a package whose code is there.

    Raises:
        ValueError: if a manifest is not XML.
    """
    for file in sorted((folder / "manifest").glob("*.xml")):
        executable = _parse(file).find("executable")
        module = "" if executable is None else executable.get("package_path", "")
        code = _modules(folder) / f"{module.partition('.')[2]}.py"
        if module.count(".") == 1 and code.is_file():
            yield file, code


def _read_behaviors(folder: Path) -> Iterator[BehaviorDefinition]:
    """Yield the behaviors of a package; those that the App cannot load are left out."""
    for _manifest, code in behavior_files(folder):
        try:
            module = f"{_modules(folder).name}.{code.stem}"
            yield define_behavior(read_source(code), module)
        except AppLoadError:
            continue


def _exports(folder: Path) -> set[str]:
    return {
        entry.tag for export in _parse(folder / "package.xml").iter("export") for entry in export
    }


def _modules(folder: Path) -> Path:
    name = (_parse(folder / "package.xml").findtext("name") or "").strip()
    return folder / "src" / name


def _parse(file: Path) -> ElementTree.Element:
    try:
        return ElementTree.parse(file).getroot()
    except ElementTree.ParseError as error:
        raise ValueError(f"{file} is not XML: {error}") from error
