"""Use cases on disk."""

from __future__ import annotations

import json
import os
from pathlib import Path

from remodel_production.edge.design_files import package_folder
from remodel_production.errors import InstanceError
from remodel_states.core.tables import schema_problems
from remodel_tasks.core.use_case.model import DesignKind, UseCase
from remodel_tasks.core.use_case.reading import use_case_from
from remodel_tasks.edge.document_files import read_yaml
from remodel_tasks.errors import UseCaseError

# Folders with use cases of the user's own, before those of the package; separated as PATH is.
VARIABLE = "REMODEL_USE_CASES"


def find_use_case(name: str) -> UseCase:
    """Return the use case of a name; UseCaseError if there is none, or its file is malformed."""
    files = _files()
    for file in files:
        if file.stem == name:
            return read_use_case(file)
    names = ", ".join(use_case_names()) or "none"
    searched = ", ".join(str(folder) for folder in _folders())
    raise UseCaseError(
        f"no use case {name}; there are {names} (searched: {searched}): name one of them, or add "
        f"the folder of {name}.yaml to {VARIABLE}, also where the supervisor is started"
    )


def use_case_for(kind: DesignKind, name: str = "") -> UseCase:
    """Return the use case of a name; without one, that by which designs of a kind are done.

    Raises:
        UseCaseError: if there is none, or the file of one is malformed.
    """
    if name:
        return find_use_case(name)
    for file in _files():
        data = _parsed(file)
        designs = data.get("designs") if isinstance(data, dict) else None
        if isinstance(designs, dict) and designs.get("default_for") == kind.value:
            return read_use_case(file)
    raise UseCaseError(
        f"no use case says `designs: {{default_for: {kind.value}}}`: name one by --use-case"
    )


def use_case_names() -> tuple[str, ...]:
    """Return the names of all use cases."""
    return tuple(sorted({file.stem for file in _files()}))


def use_case_folder() -> Path:
    """Return the folder of the package's use cases."""
    return _config() / "use_cases"


def _config() -> Path:
    return package_folder("remodel_tasks") / "config"


def _files() -> list[Path]:
    return [file for folder in _folders() for file in sorted(folder.glob("*.yaml"))]


def _folders() -> list[Path]:
    own = [Path(part) for part in os.environ.get(VARIABLE, "").split(os.pathsep) if part]
    return [*own, use_case_folder()]


def read_use_case(file: Path) -> UseCase:
    """Return the use case in a file, which bears its name.

    Raises:
        UseCaseError: naming the file, and what is wrong where.
    """
    data = _parsed(file)
    schema = json.loads((_config() / "use_case.schema.json").read_text(encoding="utf-8"))
    findings = list(schema_problems(data, schema))
    if not findings and data["name"] != file.stem:
        findings = [f"name: expected {file.stem}, as the file is called, found {data['name']}"]
    if findings:
        raise UseCaseError(f"{file}: " + "\n  ".join(findings))
    try:
        return use_case_from(data)
    except UseCaseError as error:
        raise UseCaseError(f"{file}: {error}") from error


def _parsed(file: Path) -> object:
    try:
        return read_yaml(file)
    except InstanceError as error:
        raise UseCaseError(f"{file}: {error}") from error
