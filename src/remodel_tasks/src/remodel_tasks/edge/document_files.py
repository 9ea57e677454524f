"""Texts, documents and charts on disk."""

from __future__ import annotations

import contextlib
import json
import os
import re
from pathlib import Path

import yaml

from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart
from remodel_production.errors import InstanceError


def read_text(file: Path) -> str:
    """Return the text of a file; InstanceError if it cannot be read as UTF-8."""
    try:
        return file.read_text(encoding="utf-8")
    except OSError as error:
        raise InstanceError(f"cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InstanceError(f"is no UTF-8 text: {error.reason} at byte {error.start}") from error


def write_text(file: Path, text: str) -> None:
    """Write a text so that the file always holds the whole old one or the whole new one.

    Raises:
        InstanceError: if it cannot be written.
    """
    beside = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        beside.write_text(text, encoding="utf-8")
        beside.replace(file)
    except OSError as error:
        with contextlib.suppress(OSError):
            beside.unlink()
        raise InstanceError(f"{file} cannot be written: {error.strerror}") from error


def read_yaml(file: Path) -> object:
    """Return the parsed document of a file.

    Raises:
        InstanceError: if it cannot be read or is no YAML, with the place.
    """
    try:
        return yaml.load(read_text(file), yaml.CSafeLoader)
    except yaml.YAMLError as error:
        raise InstanceError(f"is no YAML: {' '.join(str(error).split())}") from error
    except RecursionError as error:
        raise InstanceError("is nested too deeply") from error


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
    """Write a document, all of it or nothing; InstanceError if it cannot be written."""
    write_text(file, json.dumps(document, separators=(",", ":")) + "\n")


def keep_chart(chart: Chart, folder: Path) -> tuple[Path, bool]:
    """Write a chart unless it is there, unchanged; return its file, and whether it was written.

    Raises:
        InstanceError: if the folder or the file cannot be written.
    """
    file = folder / f"{re.sub(r'[^a-z0-9]+', '_', chart.name.lower()).strip('_')}.xml"
    text = write_chart(chart)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if file.is_file() and file.read_text(encoding="utf-8") == text:
            return file, False
    except (OSError, UnicodeDecodeError) as error:
        raise InstanceError(f"{file}: cannot be used: {error}") from error
    write_text(file, text)
    return file, True
