"""Read tables of abilities and faults from their files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from remodel_states.core.fault_tables import FaultTables, join_fault_tables
from remodel_states.core.schema_problems import schema_problems
from remodel_states.errors import TableError


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


def read_table(file: Path, schema: Path) -> Any:  # noqa: ANN401 - YAML
    """Return a parsed table that has the form of a schema.

    Raises:
        TableError: with each problem.
    """
    try:
        parsed = yaml.safe_load(file.read_text(encoding="utf-8"))
    except (OSError, yaml.YAMLError) as error:
        raise TableError(str(file), [str(error)]) from error
    problems = [*schema_problems(parsed, json.loads(schema.read_text(encoding="utf-8")))]
    if problems:
        raise TableError(str(file), problems)
    return parsed
