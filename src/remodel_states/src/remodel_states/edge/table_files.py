"""Read tables of abilities and faults from their files."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import yaml

from remodel_states.core.ability_tables import Ability, abilities_from
from remodel_states.core.action_file import Action, action_from
from remodel_states.core.fault_tables import FaultTables, join_fault_tables
from remodel_states.core.schema_problems import schema_problems
from remodel_states.errors import TableError

# The C parser takes a tenth of the time.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def faults_from(files: Mapping[str, Path], contract: Path) -> FaultTables:
    """Return the tables in files, by package; `contract` is the folder of remodel_msgs.

    Raises:
        TableError: if a table cannot be read, or two contradict each other.
    """
    schema = contract / "config/faults.schema.json"
    tables, problems = join_fault_tables(
        {package: read_table(file, schema) for package, file in files.items()}
    )
    if problems:
        raise TableError(", ".join(map(str, files.values())), problems)
    return tables


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
    table = read_table(file, contract / "config/abilities.schema.json")
    abilities, problems = abilities_from(package, table, read_actions(folder), codes)
    if problems:
        raise TableError(str(file), problems)
    return abilities


def read_actions(folder: Path) -> dict[str, Action]:
    """Return the actions of a package, by name."""
    files = sorted((folder / "action").glob("*.action"))
    return {file.stem: action_from(file.stem, file.read_text(encoding="utf-8")) for file in files}


def read_table(file: Path, schema: Path) -> Any:  # noqa: ANN401 - YAML
    """Return a parsed table that has the form of a schema.

    Raises:
        TableError: with each problem.
    """
    try:
        parsed = yaml.load(file.read_text(encoding="utf-8"), Loader=_LOADER)
    except (OSError, yaml.YAMLError) as error:
        raise TableError(str(file), [str(error)]) from error
    problems = [*schema_problems(parsed, json.loads(schema.read_text(encoding="utf-8")))]
    if problems:
        raise TableError(str(file), problems)
    return parsed
