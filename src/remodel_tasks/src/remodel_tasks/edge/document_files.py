"""YAML and JSON documents on disk."""

from __future__ import annotations

import json
from pathlib import Path

import yaml

from remodel_production.edge.text_file import read_text, write_text
from remodel_production.errors import InstanceError


def read_yaml(file: Path) -> object:
    """Return the parsed document of a file.

    Raises:
        InstanceError: if it cannot be read or is no YAML, with the place.
    """
    try:
        return yaml.load(read_text(file), _Loader)
    except yaml.YAMLError as error:
        raise InstanceError(f"is no YAML: {' '.join(str(error).split())}") from error
    except RecursionError as error:
        raise InstanceError("is nested too deeply") from error


# The same loader, in C where libyaml is there.
_Loader: type = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def read_json(file: Path) -> object:
    """Return the parsed document of a file.

    Raises:
        InstanceError: if it cannot be read or is no JSON, with the place.
    """
    try:
        return json.loads(read_text(file))
    except json.JSONDecodeError as error:
        raise InstanceError(
            f"is no JSON: {error.msg} in line {error.lineno}, column {error.colno}"
        ) from error
    except RecursionError as error:
        raise InstanceError("is nested too deeply") from error


def write_json(file: Path, document: object) -> None:
    """Write a document, all of it or nothing.

    Raises:
        InstanceError: if it cannot be written.
    """
    write_text(file, json.dumps(document, separators=(",", ":")) + "\n")
