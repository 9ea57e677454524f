"""Find the tables of all packages on the ROS package path, and the files of cells; read them.

A package exports its tables, and the folder of its cells, in its package.xml:

    <export>
      <remodel_states abilities="${prefix}/config/abilities.yaml"
                      faults="${prefix}/config/faults.yaml"
                      cells="${prefix}/config/cells"/>
    </export>

Of the file `NAME.yaml` of a cell, `name` and `takes` are read here; the rest is for those who run
it. The table of wire materials is that of remodel_msgs, with the user's own beside it.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar
from xml.etree import ElementTree

import rospkg
import yaml

from remodel_states.core.cell import SCHEMA, CellLimits
from remodel_states.core.tables import (
    CONTRACT,
    Ability,
    Action,
    FaultTables,
    TableError,
    abilities_from,
    action_from,
    join_fault_tables,
    schema_problems,
)
from remodel_states.core.wires import MaterialError, WireMaterials, materials_from

EXPORT = "remodel_states"

_Content = TypeVar("_Content")


def read_faults() -> FaultTables:
    """Return the error codes and faults of all packages on the ROS package path.

    Raises:
        TableError: if a table cannot be read, or two contradict each other.
    """
    return _faults_of(exporting_packages())


def read_abilities() -> dict[str, Ability]:
    """Return the abilities of all packages on the ROS package path, by name.

    Raises:
        TableError: if a table cannot be read or does not fit its actions, or two packages have an
            ability of one name.
    """
    folders = exporting_packages()
    codes = _faults_of(folders).codes
    found: dict[str, Ability] = {}
    for package, file in _exported(folders, "abilities").items():
        abilities = abilities_in(package, file, folders[package], codes, contract=folders[CONTRACT])
        if twice := [name for name in abilities if name in found]:
            others = ", ".join(f"{name} of {found[name].package}" for name in twice)
            raise TableError(str(file), [f"there is {others} already; choose another name"])
        found |= abilities
    return found


def read_abilities_of(folder: Path) -> tuple[str, dict[str, Ability]]:
    """Return the name and the abilities of a package, which may be missing on the ROS package path.

    Raises:
        TableError: if it exports no table of abilities, a table cannot be read, or it does not fit
            the actions.
    """
    name = (_manifest(folder).findtext("name") or "").strip()
    folders = {**exporting_packages(), name: folder}
    files = _exported(folders, "abilities")
    if name not in files:
        raise TableError(str(folder / "package.xml"), ["it exports no table of abilities"])
    codes = _faults_of(folders).codes
    return name, abilities_in(name, files[name], folder, codes, contract=folders[CONTRACT])


def exported_paths(kind: str) -> dict[str, Path]:
    """Return the file or folder of a kind in each package that exports one, such as "cells"."""
    return _exported(exporting_packages(), kind)


def exporting_packages() -> dict[str, Path]:
    """Return the folders of the packages that export tables, that of the contract first.

    Raises:
        TableError: if remodel_msgs is not among them.
    """
    packages = rospkg.RosPack()
    folders = {name: Path(packages.get_path(name)) for name in sorted(packages.list())}
    found = {name: folder for name, folder in folders.items() if _export(folder) is not None}
    if CONTRACT not in found:
        paths = ":".join(rospkg.get_ros_paths())
        raise TableError(CONTRACT, [f"not on the ROS package path ({paths}); source its workspace"])
    return {CONTRACT: found.pop(CONTRACT), **found}


def _faults_of(folders: Mapping[str, Path]) -> FaultTables:
    exported = [_exported(folders, table) for table in ("faults", "abilities")]
    files = {name: [own[name] for own in exported if name in own] for name in folders}
    return faults_from(files, folders[CONTRACT])


def _exported(folders: Mapping[str, Path], table: str) -> dict[str, Path]:
    """Return the file of a table in each package that exports one."""
    paths = {package: (_export(folder) or {}).get(table) for package, folder in folders.items()}
    return {
        package: Path(path.replace("${prefix}", str(folders[package])))
        for package, path in paths.items()
        if path
    }


def _export(folder: Path) -> Mapping[str, str] | None:
    """Return what a package exports; None if it exports no tables."""
    file = folder / "package.xml"  # a package of rosbuild has none
    if not file.is_file() or EXPORT.encode() not in file.read_bytes():
        return None
    elements = _manifest(folder).findall(f"export/{EXPORT}")
    return {key: path for element in elements for key, path in element.items()} or None


def _manifest(folder: Path) -> ElementTree.Element:
    """Return the package.xml of a package.

    Raises:
        TableError: if it cannot be read.
    """
    file = folder / "package.xml"
    try:
        return ElementTree.parse(file).getroot()
    except OSError as error:
        problem = f"{error.strerror}; give the folder of a package"
        raise TableError(str(file), [problem]) from error
    except (ElementTree.ParseError, LookupError) as error:  # an unknown encoding
        raise TableError(str(file), [f"it is not XML: {error}"]) from error


# Read tables of abilities and faults from their files


# The C parser takes a tenth of the time.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

# Sections of tables.
_ABILITIES = ("abilities",)
_FAULTS = ("no_fault", "faults")
_ANY_TABLE = {
    "type": "object",
    "properties": {name: {} for name in (*_ABILITIES, *_FAULTS)},
    "additionalProperties": False,
}


def faults_from(files: Mapping[str, Sequence[Path]], contract: Path) -> FaultTables:
    """Return the error codes and faults in files, as one table.

    Args:
        files: package -> its tables of faults, and of abilities, which may list faults too.
        contract: folder of remodel_msgs.

    Raises:
        TableError: if a table cannot be read, or two contradict each other.
    """
    schema = contract / "config/faults.schema.json"
    tables = {
        package: [read_table(file, schema, _FAULTS) for file in own]
        for package, own in files.items()
    }
    joined, problems = join_fault_tables(tables)
    if problems:
        names = [str(file) for own in files.values() for file in own]
        raise TableError(", ".join(names), problems)
    return joined


def abilities_in(
    package: str, file: Path, folder: Path, codes: Collection[str], contract: Path
) -> dict[str, Ability]:
    """Return the abilities of a package, by name.

    Args:
        package: its name.
        file: its table.
        folder: of the package; its actions are in `action`.
        codes: names of all error codes.
        contract: folder of remodel_msgs.

    Raises:
        TableError: if the table cannot be read, or does not fit the actions.
    """
    table = read_table(file, contract / "config/abilities.schema.json", _ABILITIES)
    abilities, problems = abilities_from(package, table, read_actions(folder), codes)
    if problems:
        raise TableError(str(file), problems)
    return abilities


def read_actions(folder: Path) -> dict[str, Action]:
    """Return the actions of a package, by name.

    Raises:
        TableError: if a file cannot be read.
    """
    files = sorted((folder / "action").glob("*.action"))
    return {file.stem: _parsed(file, partial(action_from, file.stem)) for file in files}


def read_table(file: Path, schema: Path, sections: Sequence[str]) -> dict[str, Any]:
    """Return sections of a parsed table, which have the form of a schema.

    Raises:
        TableError: with each problem.
    """
    parsed = _parsed(file, _parse_yaml)
    form = json.loads(schema.read_text(encoding="utf-8"))
    problems = [*schema_problems(parsed, _ANY_TABLE)]
    if not problems:
        parsed = {name: value for name, value in parsed.items() if name in sections}
        problems = [*schema_problems(parsed, form)]
    if problems:
        raise TableError(str(file), problems)
    return parsed


_parse_yaml: Callable[[str], Any] = partial(yaml.load, Loader=_LOADER)


def _parsed(file: Path, parse: Callable[[str], _Content]) -> _Content:
    """Return what a text in UTF-8 holds.

    Raises:
        TableError: if it cannot be read or parsed.
    """
    try:
        return parse(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError, yaml.YAMLError) as error:
        raise TableError(str(file), [str(error)]) from error


# Wire materials, and what cells take


# Files of a user's own materials, separated like those of PATH.
VARIABLE = "REMODEL_WIRE_MATERIALS"


def read_wire_materials() -> WireMaterials:
    """Return the materials in the files that REMODEL_WIRE_MATERIALS names, then the project's.

    Raises:
        MaterialError: if a file cannot be read or is no such table.
    """
    materials = _read_materials(
        Path(rospkg.RosPack().get_path(CONTRACT)) / "config/wire_materials.yaml"
    )
    own = [Path(part) for part in os.environ.get(VARIABLE, "").split(os.pathsep) if part]
    for file in reversed(own):
        materials = materials.beside(_read_materials(file))
    return materials


def _read_materials(file: Path) -> WireMaterials:
    try:
        return materials_from(_parse_yaml(file.read_text(encoding="utf-8")))
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise MaterialError(f"{file}: {error}") from error


_CELL_FORM = {
    "type": "object",
    "required": ["name", "takes"],
    "properties": {"name": {"type": "string", "minLength": 1}, "takes": dict(SCHEMA)},
}


def cell_names() -> tuple[str, ...]:
    """Return the names of the cells of all packages, sorted."""
    return tuple(sorted(_cell_files()))


def read_cell_limits(cell: str) -> CellLimits:
    """Return what a cell takes: one of a package by its name, or one of your own by its file.

    Raises:
        TableError: if there is no such cell, or its file does not say what it takes.
    """
    known = {} if cell.endswith((".yaml", ".yml")) else _cell_files()
    file = known.get(cell, Path(cell))
    if not os.path.isfile(file):  # unlike Path.is_file, no error for names that are too long
        there_are = ", ".join(sorted(known or _cell_files()))
        problem = f"no such cell or file; there are: {there_are}, or the path of a .yaml file"
        raise TableError(cell, [problem])
    parsed = _parsed(file, _parse_yaml)
    problems = list(schema_problems(parsed, _CELL_FORM))
    if problems:
        raise TableError(str(file), problems)
    return CellLimits.stated(parsed["name"], parsed["takes"])


def _cell_files() -> dict[str, Path]:
    """Return the files of cells by the names of the files."""
    folders = exported_paths("cells").values()
    return {file.stem: file for folder in folders for file in sorted(folder.glob("*.yaml"))}
