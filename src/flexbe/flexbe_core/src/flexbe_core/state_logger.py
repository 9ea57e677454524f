"""Log what the states of a behavior do, in a file with one line per event.

    - {event: enter, duration: 0.0002, name: Say, state: LogState, path: /Say,
       time: 1763722110.1, logger: flexbe.events, loglevel: INFO}

Each line is an item of a YAML list. Private parameters of the node switch it on and say where the
files go; evaluate_logs (flexbe_widget) reads them.
"""

from __future__ import annotations

import base64
import functools
import logging
import logging.config
import pickle
import re
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import rospy
import yaml
from std_msgs.msg import String

from flexbe_core.core.state import State
from flexbe_core.proxy.proxy_publisher import ProxyPublisher
from flexbe_core.ros import clock

StateClass = TypeVar("StateClass", bound=type)

# Event of a line -> method of a state.
EVENTS = {
    "start": "on_start",
    "stop": "on_stop",
    "enter": "on_enter",
    "exit": "on_exit",
    "pause": "on_pause",
    "resume": "on_resume",
}

_SERIALIZERS: dict[str, Callable[[Any], Any]] = {
    "yaml": lambda value: yaml.safe_load(yaml.safe_dump(value)),
    "str": str,
    "repr": repr,
    "pickle": lambda value: base64.b64encode(pickle.dumps(value)).decode("ascii"),
}


class _LineDumper(yaml.SafeDumper):
    """Writes a text of several lines on one, with escapes."""

    def analyze_scalar(self, scalar: str) -> Any:  # noqa: ANN401 - PyYAML has no types
        analysis = super().analyze_scalar(scalar)
        analysis.allow_single_quoted &= not analysis.multiline
        return analysis


class YamlFormatter(logging.Formatter):
    """Formats a record whose message is a dict as an item of a YAML list."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the line."""
        found = record.msg if isinstance(record.msg, dict) else {"message": record.getMessage()}
        line = {**found, "logger": record.name, "loglevel": record.levelname}
        line.setdefault("time", clock.now())
        text: str = yaml.dump(
            line, Dumper=_LineDumper, default_flow_style=True, sort_keys=False, width=1 << 30
        )
        return f"- {text.strip()}"


class RunLogFile(logging.FileHandler):
    """The file of a run log; where it cannot be written on, the behavior runs on without it."""

    def __init__(self, filename: str) -> None:
        super().__init__(filename, encoding="utf-8")
        self._is_given_up = False

    def emit(self, record: logging.LogRecord) -> None:
        """Write a line, unless an earlier one could not be written."""
        if not self._is_given_up:
            super().emit(record)

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802 - logging's name
        """Give up on the file where the disk is full, for example."""
        error = sys.exc_info()[1]
        if isinstance(error, OSError):
            self._give_up(error)
        else:
            super().handleError(record)

    def close(self) -> None:
        """Close the file."""
        try:
            super().close()
        except OSError as error:  # of what is still to be written
            self._give_up(error)

    def _give_up(self, error: OSError) -> None:
        if not self._is_given_up:
            self._is_given_up = True
            text = "the run log %s ends here, and the behavior runs on without it: %s"
            rospy.logerr(text, self.baseFilename, error)


class PublishBehaviorLogMessage(logging.Handler):
    """Publishes the lines; a log configuration may name it as a handler."""

    def __init__(
        self, level: int | str = logging.NOTSET, topic: str = "flexbe/state_logger"
    ) -> None:
        """Publish on `topic`."""
        super().__init__(level)
        self._topic = topic
        self._publisher = ProxyPublisher({topic: String})

    def emit(self, record: logging.LogRecord) -> None:
        """Publish a line."""
        self._publisher.publish(self._topic, String(self.format(record)))


class StateLogger:
    """The run log of the behavior that runs in this process.

    Attributes:
        enabled: whether a run log is being written.
    """

    enabled: ClassVar[bool] = False
    _serialize: ClassVar[Callable[[Any], Any]] = _SERIALIZERS["yaml"]

    @staticmethod
    def initialize(be_name: str | None = None, autonomy: int | None = None) -> None:
        """Begin the run log of a behavior, if the node's parameters enable it.

        If it cannot be written, an error is logged and the behavior runs without it.
        """
        if not rospy.core.is_initialized() or not rospy.get_param("~log_enabled", False):
            return
        try:
            StateLogger._serialize = _serializer(rospy.get_param("~log_serialize", "yaml"))
            folder = Path(rospy.get_param("~log_folder", "~/.flexbe_logs")).expanduser()
            folder.mkdir(parents=True, exist_ok=True)
            file = folder / _file_name(be_name or "behavior")
            logging.config.dictConfig(
                _merged(
                    _configuration(file, str(rospy.get_param("~log_level", "INFO")).upper()),
                    rospy.get_param("~log_config", {}),
                )
            )
        except (OSError, ValueError, TypeError, AttributeError, RuntimeError) as error:
            rospy.logerr("no run log of %s is written: %s", be_name, error)
            return
        StateLogger.enabled = True
        StateLogger.get("flexbe.initialize").info({"behavior": be_name, "autonomy": autonomy})

    @staticmethod
    def shutdown() -> None:
        """End the run log."""
        if StateLogger.enabled:
            StateLogger.enabled = False
            root = logging.getLogger("flexbe")
            for handler in tuple(root.handlers):
                root.removeHandler(handler)
                handler.close()

    @staticmethod
    def get(name: str) -> logging.Logger:
        """Return a logger of the run log; its messages are dicts."""
        return logging.getLogger(name)

    @staticmethod
    def log(name: str, state: State, **keys: object) -> None:
        """Write a line about a state; `loglevel` chooses the level (INFO)."""
        if StateLogger.enabled:
            level = logging.getLevelName(str(keys.pop("loglevel", "INFO")))
            about = {"name": state.name, "state": type(state).__name__, "path": state.path}
            StateLogger.get(name).log(level, {**keys, **about})

    @staticmethod
    def log_events(name: str, **events: str) -> Callable[[StateClass], StateClass]:
        """Decorate a class of states: log calls of methods, given as event=method."""

        def wrap(state: State) -> None:
            for event, method in events.items():
                setattr(state, method, _logged(state, getattr(state, method), name, event))

        return _decorator(wrap)

    @staticmethod
    def log_outcomes(name: str) -> Callable[[StateClass], StateClass]:
        """Decorate a class of states: log the outcomes that execute returns."""

        def decorate(cls: StateClass) -> StateClass:
            execute = cls.execute  # type: ignore[attr-defined]

            @functools.wraps(execute)
            def logged(self: State, *args: object, **kwargs: object) -> str | None:
                outcome: str | None = execute(self, *args, **kwargs)
                if outcome is not None:
                    StateLogger.log(name, self, outcome=outcome)
                return outcome

            cls.execute = logged  # type: ignore[attr-defined]
            return cls

        return decorate

    @staticmethod
    def log_userdata(
        name: str, keys: Iterable[str] | None = None
    ) -> Callable[[StateClass], StateClass]:
        """Decorate a class of states: log its userdata (all keys by default), at DEBUG level."""
        chosen = None if keys is None else tuple(keys)

        def wrap(state: State) -> None:
            for method in ("on_enter", "on_exit"):
                call = getattr(state, method)
                setattr(state, method, _with_userdata(state, call, name, chosen))

        return _decorator(wrap)


def log_all_events(state: State) -> None:
    """Log the events and userdata of a state from now on, once however often it is asked for."""
    for event, method in EVENTS.items():
        call = getattr(state, method)
        call = getattr(call, "recorded", call)
        with_userdata = call
        if method in ("on_enter", "on_exit"):
            with_userdata = _with_userdata(state, call, "flexbe.userdata", None)
        logged = _logged(state, with_userdata, "flexbe.events", event)
        logged.recorded = call  # type: ignore[attr-defined]
        setattr(state, method, logged)


def _logged(state: State, call: Callable[..., Any], name: str, event: str) -> Callable[..., None]:
    @functools.wraps(call)
    def logged(*args: object) -> None:
        begin = time.monotonic()
        call(*args)
        duration = round(time.monotonic() - begin, 6)
        StateLogger.log(name, state, event=event, duration=duration)

    return logged


def _with_userdata(
    state: State, call: Callable[..., Any], name: str, keys: tuple[str, ...] | None
) -> Callable[..., None]:
    @functools.wraps(call)
    def logged(userdata: Any) -> None:  # noqa: ANN401 - UserData, or what a test passes
        call(userdata)
        if StateLogger.enabled and StateLogger.get(name).isEnabledFor(logging.DEBUG):
            declared = keys or (*state.input_keys, *state.output_keys)
            values = {key: _serialized(userdata[key]) for key in declared if key in userdata}
            StateLogger.log(name, state, userdata=values, loglevel="DEBUG")

    return logged


def _serialized(value: object) -> object:
    try:
        return StateLogger._serialize(value)
    except Exception:  # noqa: BLE001 - whatever users put into userdata
        return repr(value)


def _decorator(wrap: Callable[[State], None]) -> Callable[[StateClass], StateClass]:
    """Return a decorator of classes that calls `wrap` with each new instance."""

    def decorate(cls: StateClass) -> StateClass:
        construct = cls.__init__  # type: ignore[misc]

        @functools.wraps(construct)
        def constructing(self: State, *args: object, **kwargs: object) -> None:
            construct(self, *args, **kwargs)
            wrap(self)

        cls.__init__ = constructing  # type: ignore[misc]
        return cls

    return decorate


def _serializer(name: str) -> Callable[[Any], Any]:
    if name not in _SERIALIZERS:
        known = ", ".join(_SERIALIZERS)
        raise ValueError(f"~log_serialize must be one of {known}; found {name!r}")
    return _SERIALIZERS[name]


def _file_name(behavior: str) -> str:
    stamp = time.strftime("%Y-%m-%d-%H_%M_%S")
    return f"{re.sub('[ ,./]', '_', behavior.lower())}_{stamp}.yaml"


def _configuration(file: Path, level: str) -> dict[str, Any]:
    return {
        "version": 1,
        "disable_existing_loggers": False,
        "formatters": {"yaml": {"()": "flexbe_core.state_logger.YamlFormatter"}},
        "handlers": {
            "file": {
                "class": "flexbe_core.state_logger.RunLogFile",
                "filename": str(file),
                "formatter": "yaml",
            },
            "publish": {
                "class": "flexbe_core.state_logger.PublishBehaviorLogMessage",
                "formatter": "yaml",
            },
        },
        "loggers": {"flexbe": {"level": level, "handlers": ["file"], "propagate": False}},
    }


def _merged(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return the base with all that `over` says, mapping by mapping."""
    merged = dict(base)
    for key, value in over.items():
        both = isinstance(value, Mapping) and isinstance(merged.get(key), Mapping)
        merged[key] = _merged(merged[key], value) if both else value
    return merged
