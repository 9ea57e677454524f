"""JSON documents on disk."""

from __future__ import annotations

import contextlib
import json
import os
from pathlib import Path

from remodel_planner.edge.text_file import read_text
from remodel_planner.errors import InstanceError


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
    """Write a document so that the file always holds the whole old one or the whole new one.

    Raises:
        InstanceError: if it cannot be written.
    """
    beside = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        beside.write_text(json.dumps(document, separators=(",", ":")) + "\n", encoding="utf-8")
        beside.replace(file)
    except OSError as error:
        with contextlib.suppress(OSError):
            beside.unlink()
        raise InstanceError(f"{file} cannot be written: {error.strerror}") from error
