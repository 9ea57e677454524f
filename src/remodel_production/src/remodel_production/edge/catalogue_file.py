"""Read the catalogue from its YAML file."""

import json
from pathlib import Path

import yaml

from remodel_production.core.catalogue import Catalogue, catalogue_from
from remodel_production.edge.package_files import package_folder
from remodel_production.errors import CatalogueError, blamed
from remodel_states.core.table_error import schema_problems
from remodel_states.core.wires.wire_materials import MaterialError
from remodel_states.edge.wire_material_file import read_wire_materials


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
