"""The files of the tools: values that are kept, run logs, new packages."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from flexbe_core.behavior_library import named_file
from flexbe_widget.core.repository import RepositoryError


class RequestError(Exception):
    """An invalid request; the text says what was found, what there is, what to do."""


class LogError(Exception):
    """A run log that cannot be read."""


# Values that are kept in files.
#
# A file is named absolutely, from home (~/...), or from a ROS package (package/folder/file). Behind
# it, :key chooses an entry of a YAML file; :outer/inner an entry of an entry.


_SCHEME = "file://"

# A value is sent in a message; a file with more characters was meant for something else.
_LONGEST_FILE = 1 << 24


def resolved(value: str) -> str:
    """Return the value, or the content of the file that it names with file://.

    Raises:
        RequestError: if the file cannot be read, or has no such entry.
    """
    if not value.startswith(_SCHEME):
        return value
    name, key = _split(value.removeprefix(_SCHEME))
    text = _read(name)
    return _dumped(_entry(name, text, key)) if key else text


def yaml_text(place: str) -> str:
    """Return as YAML text what a YAML file holds, or the entry of it behind the colon.

    Raises:
        RequestError: if the file cannot be read, or has no such entry.
    """
    name, key = _split(place)
    return _dumped(_entry(name, _read(name), key))


def _split(place: str) -> tuple[str, str]:
    name, _, key = place.partition(":")
    return name, key


def _read(name: str) -> str:
    try:
        path = named_file(name)
    except FileNotFoundError as error:
        raise RequestError(str(error)) from error
    try:
        with path.open(encoding="utf-8") as file:
            text = file.read(_LONGEST_FILE + 1)
    except (OSError, ValueError) as error:
        raise RequestError(f"cannot read file {path}: {error}") from error
    if len(text) > _LONGEST_FILE:
        raise RequestError(f"file {path} is longer than {_LONGEST_FILE} characters")
    return text


def _entry(name: str, text: str, key: str) -> object:
    try:
        found = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError, RecursionError) as error:  # ValueError: of a wrong date
        raise RequestError(f"file {name} is not YAML: {error}") from error
    for part in key.split("/") if key else ():
        if not isinstance(found, dict) or part not in found:
            there = ", ".join(map(str, found)) if isinstance(found, dict) else "no entries"
            raise RequestError(f"file {name} has no entry {key!r}; at {part!r} there are: {there}")
        found = found[part]
    return found


def _dumped(value: object) -> str:
    if isinstance(value, str):
        return value
    text: str = yaml.safe_dump(value, default_flow_style=True)
    return text.removesuffix("...\n").strip()


# Read the run log of a behavior


def read_log(name: str) -> list[dict[str, Any]]:
    """Return the lines of a run log; the last may be incomplete if its engine was killed.

    Raises:
        LogError: if it cannot be read, or is not a run log.
    """
    try:
        texts = Path(name).expanduser().read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise LogError(f"cannot read {name}: {error}") from error
    lines = []
    for number, text in enumerate(texts, 1):
        try:
            (line,) = yaml.safe_load(text)
        except (yaml.YAMLError, ValueError, TypeError) as error:
            if number == len(texts):
                break
            raise LogError(f"{name}:{number}: not a line of a run log: {text:.80}") from error
        if isinstance(line, dict):
            if not isinstance(line.get("time", 0.0), (int, float)):
                raise LogError(f"{name}:{number}: 'time' is not a number of seconds: {text:.80}")
            lines.append(line)
    return lines


# Write files that do not exist yet


def write_new_files(folder: Path, files: Mapping[str, str]) -> None:
    """Write files below a folder, all or none.

    Raises:
        RepositoryError: if one exists already, or cannot be written.
    """
    there = [path for path in files if (folder / path).exists()]
    if there:
        raise RepositoryError(f"{folder / there[0]} exists already; nothing was written")
    written: list[Path] = []
    try:
        for path, text in files.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            written.append(folder / path)
            written[-1].write_text(text, encoding="utf-8")
    except OSError as error:
        for file in written:
            file.unlink(missing_ok=True)
        raise RepositoryError(f"cannot write into {folder}: {error}") from error
