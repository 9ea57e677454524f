"""Request a behavior from the engine, for operators too (flexbe/request_behavior)."""

from __future__ import annotations

import difflib
import threading
import time
import traceback
from collections.abc import Iterable, Sequence
from pathlib import Path

import rospy
from flexbe_msgs.msg import BehaviorRequest, BehaviorSelection, BEStatus, ContainerStructure
from std_msgs.msg import String

from flexbe_core import BehaviorLibrary, Logger
from flexbe_core.behavior import paired
from flexbe_core.engine.supervision import UNSUPERVISED, checksum
from flexbe_widget.edge.files import RequestError, resolved, yaml_text
from flexbe_widget.ros.engine_link import EngineLink, Event

Pairs = Sequence[tuple[str, str]]


class UnknownBehaviorError(RequestError):
    """There is no behavior with the requested name."""


def start_request(
    library: BehaviorLibrary,
    name: str,
    parameters: Pairs = (),
    inputs: Pairs = (),
    autonomy_level: int = UNSUPERVISED,
) -> BehaviorSelection:
    """Return the message that requests a behavior from the engine.

    Args:
        library: where to find it.
        name: its display name.
        parameters: (key, value) pairs.
        inputs: (key, value) pairs; values are Python literals. Values of both that begin with
            file:// are read from files.
        autonomy_level: 255 to run without supervision.

    Raises:
        UnknownBehaviorError: if there is no such behavior.
        RequestError: if its source, or a file that a value names, cannot be read.
    """
    behavior_id, _ = library.find_behavior(name)
    if behavior_id is None:
        raise UnknownBehaviorError(unknown_behavior(name, library.names()))
    path = library.get_sourcecode_filepath(behavior_id)
    if path is None:
        raise RequestError(f"behavior {name!r} has a manifest, but no source file")
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RequestError(f"cannot read {path}: {error}") from error
    return BehaviorSelection(
        behavior_id=behavior_id,
        behavior_checksum=checksum(text),
        autonomy_level=autonomy_level,
        arg_keys=[key for key, _ in parameters],
        arg_values=[resolved(value) for _, value in parameters],
        input_keys=[key for key, _ in inputs],
        input_values=[resolved(value) for _, value in inputs],
    )


# Suggest the names that were perhaps meant


# How alike (0 to 1) a name must be to be offered.
_ALIKE = 0.5


def unknown_behavior(name: str, known: Sequence[str]) -> str:
    """Return the message for a request for a behavior that does not exist."""
    if not known:
        return (
            f"unknown behavior {name!r}: there are no behaviors on the ROS package path; "
            "is the workspace sourced?"
        )
    by_lower = {candidate.lower(): candidate for candidate in known}
    near = difflib.get_close_matches(name.lower(), list(by_lower), n=3, cutoff=_ALIKE)
    if near:
        return f"unknown behavior {name!r}; near it: {_quoted(by_lower[n] for n in near)}"
    return f"unknown behavior {name!r}; there are: {_quoted(known)}"


def _quoted(names: Iterable[str]) -> str:
    return ", ".join(f"'{name}'" for name in names)


_YAML = "/YAML:"

# [s] Wall time between two checks whether the engine is there.
_CHECK_EVERY_S = 0.05

# Older versions of the FlexBE App use another protocol.
_OLDEST_APP = (2, 2, 0)


class RequestServer:
    """Serves flexbe/request_behavior."""

    def __init__(self, wait_s: float) -> None:
        """Begin to serve.

        Args:
            wait_s: [s] how long a request waits for an engine.
        """
        self._wait_s = wait_s
        self._library = BehaviorLibrary()
        self._changed = threading.Event()
        self._link = EngineLink(self._on_engine)
        self._status = rospy.Publisher("flexbe/status", BEStatus, queue_size=100)
        self._structure = rospy.Publisher(
            "flexbe/mirror/structure", ContainerStructure, queue_size=100
        )
        Logger.initialize()
        rospy.Subscriber("flexbe/ui_version", String, self._on_version)
        rospy.Subscriber("flexbe/request_behavior", BehaviorRequest, self._on_request)

    def _on_request(self, message: BehaviorRequest) -> None:
        threading.Thread(target=self._serve, args=(message,), daemon=True).start()

    def _serve(self, message: BehaviorRequest) -> None:
        try:
            pairs = paired(message.arg_keys, message.arg_values)
            parameters = [_parameter(key, value) for key, value in pairs]
            request = start_request(
                self._library,
                message.behavior_name,
                parameters,
                (),
                autonomy_level=message.autonomy_level,
            )
            self._wait_for_engine()
        except Exception as error:  # noqa: BLE001 - a RequestError, or else who asked must know too
            Logger.logerr("%s", error)
            Logger.local(traceback.format_exc(), Logger.REPORT_DEBUG)
            self._status.publish(BEStatus(code=BEStatus.ERROR))
            return
        if message.autonomy_level != UNSUPERVISED and message.structure:
            self._structure.publish(request.behavior_checksum, message.structure)
        self._link.start(request)

    def _wait_for_engine(self) -> None:
        end = time.monotonic() + self._wait_s
        while not self._link.is_there:
            if time.monotonic() > end:
                raise RequestError(
                    f"there is no behavior engine; gave up after {self._wait_s:g} s "
                    "(start it with: roslaunch flexbe_onboard behavior_onboard.launch)"
                )
            self._changed.wait(_CHECK_EVERY_S)
            self._changed.clear()

    def _on_engine(self, event: Event) -> None:
        self._changed.set()

    def _on_version(self, message: String) -> None:
        parts = message.data.split(".")
        if not all(part.isdigit() for part in parts):
            rospy.logwarn("the FlexBE App has an invalid version: %r", message.data)
        elif tuple(map(int, parts)) < _OLDEST_APP:
            oldest = ".".join(map(str, _OLDEST_APP))
            rospy.logwarn("FlexBE App %s is too old; use %s or later", message.data, oldest)


def _parameter(key: str, value: str) -> tuple[str, str]:
    """Return a parameter with its final value: a key marked as YAML names a file."""
    if not key.startswith(_YAML):
        return key, value
    plain = f"/{key.removeprefix(_YAML)}"
    try:
        return plain, yaml_text(value)
    except RequestError as error:
        Logger.logwarn("parameter %s keeps its text: %s", plain, error)
        return plain, value
