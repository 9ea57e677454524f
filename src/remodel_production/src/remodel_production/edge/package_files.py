"""Data files of packages: the catalogue, the mappings of wire lists and the abilities."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import rospkg
import yaml

from remodel_production.core.catalogue import Catalogue, catalogue_from
from remodel_production.core.production import Ability, AbilityParameter
from remodel_production.errors import CatalogueError, PlannerError, blamed
from remodel_states.core.table_error import TableError, schema_problems
from remodel_states.core.wires.wire_materials import MaterialError
from remodel_states.edge import exported_tables
from remodel_states.edge.wire_material_file import read_wire_materials


@cache  # of a process; finding packages takes longer than planning most problems
def package_folder(package: str) -> Path:
    """Return the folder of a package on the ROS package path."""
    return Path(rospkg.RosPack().get_path(package))


def catalogue_file() -> Path:
    """Return the path of the catalogue."""
    return package_folder("remodel_production") / "config/catalogue.yaml"


def wire_list_mappings() -> list[Path]:
    """Return the paths of the mappings of wire lists."""
    return sorted((package_folder("remodel_production") / "config/wire_lists").glob("*.yaml"))


def read_catalogue(path: Path) -> Catalogue:
    """Return the catalogue in a file, with the wire materials that the cell has, too.

    Raises:
        CatalogueError: if the file is no YAML or not of the catalogue's form, with each problem, or
            a table of wire materials cannot be read.
    """
    try:
        data = yaml.load(path.read_text(encoding="utf-8"), Loader=yaml.CSafeLoader)
    except (OSError, yaml.YAMLError) as error:
        raise CatalogueError(f"{path}: {error}") from error
    schema = package_folder("remodel_production") / "config/catalogue.schema.json"
    problems = list(schema_problems(data, json.loads(schema.read_text(encoding="utf-8"))))
    if problems:
        raise CatalogueError(f"{path}: " + "\n  ".join(problems))
    try:
        materials = read_wire_materials()
    except MaterialError as error:
        raise CatalogueError(str(error)) from error
    with blamed(path):
        return catalogue_from(data, materials)


def read_abilities() -> tuple[Ability, ...]:
    """Return the abilities of the tables that packages export, by name.

    Raises:
        PlannerError: if a table cannot be read.
    """
    try:
        rows = exported_tables.read_abilities()
    except TableError as error:
        raise PlannerError(str(error)) from error
    return tuple(
        Ability(
            name,
            row.action.title,
            tuple(AbilityParameter(f.name, f.type, f.text) for f in row.action.goal),
        )
        for name, row in sorted(rows.items())
    )
