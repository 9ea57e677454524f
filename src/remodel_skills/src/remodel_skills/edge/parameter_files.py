"""Read the numbers of the skills: `parameters/*.yaml` of the package, and a user's own."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import rospkg
import yaml

from remodel_skills.edge.parameter_table import GROUPS, Entry, InForce, ParameterError, in_force

# A folder with files like the package's own, whose entries replace those of the same name.
VARIABLE = "REMODEL_SKILLS"
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def read_parameters() -> InForce:
    """Read the package's parameters, and those of the folder that REMODEL_SKILLS names.

    Raises:
        ParameterError: with everything that is wrong, each with its file and line.
    """
    return parameters_with(os.environ.get(VARIABLE, ""))


@cache
def parameters_with(own: str) -> InForce:
    """Read the package's parameters, and those of a user's own folder; "": there is none.

    They are read once in a process.

    Raises:
        ParameterError: see `read_parameters`.
    """
    folder = Path(rospkg.RosPack().get_path("remodel_skills")) / "parameters"
    shipped = dict(_read(folder / f"{group}.yaml") for group in GROUPS)
    return in_force(shipped, dict(_own_files(Path(own))) if own else {})


def _own_files(folder: Path) -> Iterator[tuple[str, dict[str, Entry]]]:
    files = sorted(folder.glob("*.yaml"))
    if not files:
        raise ParameterError([f"{VARIABLE} names {folder}, which has no file; allowed: {_names()}"])
    for file in files:
        if file.stem not in GROUPS:
            raise ParameterError([f"{file} is no file of parameters; allowed: {_names()}"])
        yield _read(file)


def _names() -> str:
    return ", ".join(f"{group}.yaml" for group in GROUPS)


def _read(file: Path) -> tuple[str, dict[str, Entry]]:
    """Return the group of a file, and its entries by field; raises ParameterError."""
    try:
        loader = LOADER(file.read_text())
        node = loader.get_single_node()
    except (OSError, yaml.YAMLError) as error:
        raise ParameterError([f"{file} cannot be read: {error}"]) from error
    if not isinstance(node, yaml.MappingNode):
        raise ParameterError([f"{file} holds no parameters; allowed: names, each with its value"])
    entries: dict[str, Entry] = {}
    for key, value in node.value:
        line = key.start_mark.line + 1
        if key.value in entries:
            first = entries[key.value].line
            raise ParameterError(
                [f"{file}:{line}: {file.stem}.{key.value} stands in line {first}, too"]
            )
        content = loader.construct_object(value, deep=True)
        entries[key.value] = Entry(content, str(file), line)
    return file.stem, entries
