"""The child process of the doctor: import modules, and construct what is in them.

python3 -m flexbe_testing.ros.doctor_child REQUEST RESULT, two files of JSON. The request names the
folders for the path, and the modules with their files. The result is written before each module
with its name: so it is known which one ended the process.
"""

from __future__ import annotations

import importlib
import importlib.abc
import importlib.machinery
import inspect
import json
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest.mock import MagicMock

import actionlib
import rospy

from flexbe_core import Behavior
from flexbe_core.core import State, StateMachine
from flexbe_core.proxy import (
    ProxyActionClient,
    ProxyPublisher,
    ProxyServiceCaller,
    ProxySubscriberCached,
    ProxyTransformListener,
)

# Stand-ins for everything that a state's constructor reaches for outside of its process.
#
# Only for the child process of the doctor: they replace functions of rospy and of the proxies.


_INTERFACES = ("msg", "srv", "action")


class _AnyMessageType(type(MagicMock)):  # type: ignore[misc]
    """Has every constant."""

    def __getattr__(cls, name: str) -> MagicMock:
        if name.startswith("_"):
            raise AttributeError(name)
        return MagicMock(name=f"{cls.__name__}.{name}")


class _StubModule(ModuleType):
    """A module of messages that is not on this computer: every name in it is a message type."""

    def __getattr__(self, name: str) -> type:
        if name.startswith("__"):
            raise AttributeError(name)
        made = _AnyMessageType(name, (MagicMock,), {"__module__": self.__name__})
        setattr(self, name, made)
        return made


class MessageStubs(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Imports message packages that no other finder finds, and remembers them."""

    def __init__(self) -> None:
        self.stubbed: set[str] = set()

    def find_spec(
        self, name: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Return a spec for what looks like a package of messages."""
        top, _, rest = name.partition(".")
        if not (top.endswith(("_msgs", "_msg", "_srvs", "_interfaces")) or rest in _INTERFACES):
            return None
        self.stubbed.add(top)
        return importlib.machinery.ModuleSpec(name, self, is_package=True)

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        """Return a module in which every name is a message type."""
        return _StubModule(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: there is no source."""


def install() -> MessageStubs:
    """Replace everything; there is no ROS master, and nothing waits."""
    rospy.rostime.set_rostime_initialized(True)
    for name in ("Publisher", "Subscriber", "ServiceProxy", "Service", "Timer", "Rate"):
        setattr(rospy, name, MagicMock(name=f"rospy.{name}"))
    for name in ("wait_for_message", "wait_for_service", "sleep", "spin", "init_node"):
        setattr(rospy, name, MagicMock(name=f"rospy.{name}"))
    rospy.get_param = _get_param
    rospy.get_name = lambda: "/flexbe_doctor"
    for name in ("SimpleActionClient", "ActionClient", "SimpleActionServer", "ActionServer"):
        setattr(actionlib, name, MagicMock(name=f"actionlib.{name}"))
    _silence_proxies()
    time.sleep = lambda seconds: None
    finder = MessageStubs()
    sys.meta_path.append(finder)
    return finder


def _silence_proxies() -> None:
    nothing: Callable[..., Any] = lambda *args, **kwargs: None  # noqa: E731
    ProxyActionClient.setupClient = nothing
    ProxyServiceCaller.setupService = nothing
    ProxyPublisher.createPublisher = nothing
    ProxySubscriberCached.subscribe = nothing
    ProxyTransformListener.listener = lambda self: MagicMock(name="TransformListener")


def _get_param(name: str, default: object = None) -> object:
    return MagicMock(name=f"parameter {name}") if default is None else default


# Import modules, and construct what is in them


_ERROR, _NOTE = "error", "note"
_NO_VALUE = inspect.Parameter.empty


class Construction:
    """Constructs the classes of modules, and gathers what went wrong."""

    def __init__(self, finder: MessageStubs, folders: list[str]) -> None:
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
                _check(found().create())
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
    construction = Construction(install(), request["folders"])
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
