"""The child process of the doctor: import modules, and construct what is in them.

python3 -m flexbe_testing.ros.doctor.construct REQUEST RESULT, two files of JSON. The request names
the folders for the path, and the modules with their files. The result is written before each module
with its name: so it is known which one ended the process.
"""

from __future__ import annotations

import importlib
import inspect
import json
import sys
import traceback
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from flexbe_core import Behavior
from flexbe_core.core import State, StateMachine
from flexbe_testing.ros.doctor import stubs

_ERROR, _NOTE = "error", "note"
_NO_VALUE = inspect.Parameter.empty


class Construction:
    """Constructs the classes of modules, and gathers what went wrong."""

    def __init__(self, finder: stubs.MessageStubs, folders: list[str]) -> None:
        """Begin.

        Args:
            finder: the stand-ins for messages.
            folders: where the user's code lies.
        """
        self._finder = finder
        self._folders = folders
        self.findings: list[dict[str, Any]] = []
        self.constructed = 0

    def module(self, name: str, file: str) -> None:
        """Import a module and construct its states and behaviors."""
        stubbed = set(self._finder.stubbed)
        try:
            module = importlib.import_module(name)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - user code
            self._add(error, file, 1, *_import_problem(error))
            return
        for package in sorted(self._finder.stubbed - stubbed):
            text = f"package {package} is not on this computer; its messages were stubbed"
            self._put(file, _line_of(file, package), "missing-messages", _NOTE, text=text)
        for found in vars(module).values():
            if isinstance(found, type) and found.__module__ == name:
                self._construct(found, file)

    def _construct(self, found: type, file: str) -> None:
        is_state = issubclass(found, State) and not issubclass(found, StateMachine)
        if not is_state and not issubclass(found, Behavior):
            return
        line = inspect.getsourcelines(found)[1]
        if is_state and any(_needed(found)):
            return  # with the values of a behavior that uses it
        try:
            if issubclass(found, Behavior):
                _build(found())
            else:
                found()
        except (Exception, SystemExit) as error:  # noqa: BLE001 - user code
            what = f"{found.__name__} cannot be constructed: {type(error).__name__}: {error}"
            self._add(error, file, line, "construction", text=what)
            return
        self.constructed += 1

    def _add(self, error: BaseException, file: str, line: int, rule: str, text: str) -> None:
        """Report an error where it was raised in the user's code."""
        if isinstance(error, SyntaxError):
            file, line = error.filename or file, error.lineno or line
        for frame in traceback.extract_tb(error.__traceback__):
            if frame.filename.startswith(tuple(f"{folder}/" for folder in self._folders)):
                file, line = frame.filename, frame.lineno or line
        self._put(file, line, rule, _ERROR, text=text)

    def _put(self, file: str, line: int, rule: str, severity: str, text: str) -> None:
        found = {"file": file, "line": line, "rule": rule, "severity": severity, "text": text}
        if found not in self.findings:
            self.findings.append(found)


def _import_problem(error: BaseException) -> tuple[str, str]:
    if isinstance(error, ModuleNotFoundError):
        text = f"package {error.name} is not on this computer; install it or put it on PYTHONPATH"
        return "missing-package", text
    return "import", f"cannot be imported: {type(error).__name__}: {error}"


def _needed(found: type) -> Iterator[str]:
    """Yield the parameters that have no default."""
    for parameter in list(inspect.signature(found.__init__).parameters.values())[1:]:
        is_named = parameter.kind in (parameter.POSITIONAL_OR_KEYWORD, parameter.KEYWORD_ONLY)
        if is_named and parameter.default is _NO_VALUE:
            yield parameter.name


def _build(behavior: Behavior) -> None:
    """Build the state machine of a behavior, and check where its outcomes lead."""
    _check(behavior.create())


def _check(machine: StateMachine) -> None:
    machine.assert_consistent_transitions()
    for label in machine:
        if isinstance(machine[label], StateMachine):
            _check(machine[label])


def _line_of(file: str, package: str) -> int:
    """Return the first line that names a package."""
    for number, line in enumerate(Path(file).read_text().splitlines(), 1):
        if package in line:
            return number
    return 1


def main(request_file: str, result_file: str) -> None:
    """Serve one request."""
    request = json.loads(Path(request_file).read_text())
    sys.path[:0] = request["folders"]
    construction = Construction(stubs.install(), request["folders"])
    for name, file in request["modules"]:
        _write(Path(result_file), name, construction)
        construction.module(name, file)
    _write(Path(result_file), "", construction)


def _write(file: Path, at: str, construction: Construction) -> None:
    """Write what was found so far, and which module comes next; in one step."""
    result = {"at": at, "findings": construction.findings, "constructed": construction.constructed}
    new = file.with_suffix(".new")
    new.write_text(json.dumps(result))
    new.replace(file)


if __name__ == "__main__":
    main(*sys.argv[1:3])
