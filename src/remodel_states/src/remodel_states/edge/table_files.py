"""Read tables of abilities and faults from their files."""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from remodel_states.core.ability_tables import Ability, abilities_from
from remodel_states.core.action_file import Action, action_from
from remodel_states.core.fault_tables import FaultTables, join_fault_tables
from remodel_states.core.schema_problems import schema_problems
from remodel_states.core.table_error import TableError

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
    """Return the actions of a package, by name."""
    files = sorted((folder / "action").glob("*.action"))
    return {file.stem: action_from(file.stem, file.read_text(encoding="utf-8")) for file in files}


def read_table(file: Path, schema: Path, sections: Sequence[str]) -> dict[str, Any]:
    """Return sections of a parsed table, which have the form of a schema.

    Raises:
        TableError: with each problem.
    """
    try:
        parsed = yaml.load(file.read_text(encoding="utf-8"), Loader=_LOADER)
    except (OSError, yaml.YAMLError) as error:
        raise TableError(str(file), [str(error)]) from error
    form = json.loads(schema.read_text(encoding="utf-8"))
    problems = [*schema_problems(parsed, _ANY_TABLE)]
    if not problems:
        parsed = {name: value for name, value in parsed.items() if name in sections}
        problems = [*schema_problems(parsed, form)]
    if problems:
        raise TableError(str(file), problems)
    return parsed
