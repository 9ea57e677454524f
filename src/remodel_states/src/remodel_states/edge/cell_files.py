"""Find the files of cells on the ROS package path, and read what each cell takes.

A package exports the folder of its cells in its package.xml:

    <export>
      <remodel_states cells="${prefix}/config/cells"/>
    </export>

Of a file `NAME.yaml` in it, `name` and `takes` are read here; the rest is for those who run it.
"""

from __future__ import annotations

from pathlib import Path

import yaml

from remodel_states.core.cell import SCHEMA, CellLimits
from remodel_states.core.table_error import TableError, schema_problems
from remodel_states.edge.exported_tables import exported_paths

_FORM = {
    "type": "object",
    "required": ["name", "takes"],
    "properties": {"name": {"type": "string", "minLength": 1}, "takes": dict(SCHEMA)},
}


def cell_names() -> tuple[str, ...]:
    """Return the names of the cells of all packages, sorted."""
    return tuple(sorted(_files()))


def read_cell_limits(cell: str) -> CellLimits:
    """Return what a cell takes: one of a package by its name, or one of your own by its file.

    Raises:
        TableError: if there is no such cell, or its file does not say what it takes.
    """
    known = {} if cell.endswith((".yaml", ".yml")) else _files()
    file = known.get(cell, Path(cell))
    if not file.is_file():
        there_are = ", ".join(sorted(known or _files()))
        problem = f"no such cell or file; there are: {there_are}, or the path of a .yaml file"
        raise TableError(cell, [problem])
    try:
        parsed = yaml.safe_load(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise TableError(str(file), [str(error)]) from error
    problems = list(schema_problems(parsed, _FORM))
    if problems:
        raise TableError(str(file), problems)
    return CellLimits.stated(parsed["name"], parsed["takes"])


def _files() -> dict[str, Path]:
    """Return the files of cells by the names of the files."""
    folders = exported_paths("cells").values()
    return {file.stem: file for folder in folders for file in sorted(folder.glob("*.yaml"))}
