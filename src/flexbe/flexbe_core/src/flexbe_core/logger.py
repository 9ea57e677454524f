"""Messages for the operator.

A message is published for operators at once. It is also logged with rospy, which calls the master
and writes to the terminal. That may take long, so a thread does it and no transition waits.
"""

from __future__ import annotations

import queue
import threading
from typing import ClassVar

import rospy
from flexbe_msgs.msg import BehaviorLog

from flexbe_core.proxy.proxy_publisher import ProxyPublisher

# [s] Wall time that a process which ends waits for pending log messages.
_FLUSH_LIMIT_S = 1.0

# The terminal's code for blue: hints stand out, as in stock FlexBE.
_BLUE, _PLAIN = "\033[94m", "\033[0m"

_LOCAL = {
    BehaviorLog.INFO: rospy.loginfo,
    BehaviorLog.WARN: rospy.logwarn,
    BehaviorLog.HINT: lambda form, text: rospy.loginfo(form, f"{_BLUE}{text}{_PLAIN}"),
    BehaviorLog.ERROR: rospy.logerr,
    BehaviorLog.DEBUG: rospy.logdebug,
}


class _LocalLog:
    """Logs with rospy, on a thread that starts with the first message."""

    def __init__(self) -> None:
        self._texts: queue.Queue[tuple[int, str]] = queue.Queue()
        self._thread: threading.Thread | None = None
        self._lock = threading.Lock()

    def put(self, severity: int, text: str) -> None:
        """Log a text soon."""
        self._texts.put((severity, text))
        if self._thread is None:
            self._start()

    def _start(self) -> None:
        with self._lock:
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="flexbe_log", daemon=True)
                self._thread.start()
                rospy.on_shutdown(self._flush)

    def _run(self) -> None:
        while True:
            severity, text = self._texts.get()
            _LOCAL.get(severity, rospy.loginfo)("%s", text)
            self._texts.task_done()

    def _flush(self) -> None:
        waiter = threading.Thread(target=self._texts.join, daemon=True)
        waiter.start()
        waiter.join(_FLUSH_LIMIT_S)


class Logger:
    """Publishes messages for operators, and logs them locally.

    Texts are %-formatted only if there are arguments, so that "100%" is a text like any other.
    """

    REPORT_INFO = BehaviorLog.INFO
    REPORT_WARN = BehaviorLog.WARN
    REPORT_HINT = BehaviorLog.HINT
    REPORT_ERROR = BehaviorLog.ERROR
    REPORT_DEBUG = BehaviorLog.DEBUG

    LOGGING_TOPIC = "flexbe/log"

    _local_log: ClassVar[_LocalLog] = _LocalLog()

    @staticmethod
    def initialize() -> None:
        """Advertise the topic; the first message does so otherwise."""
        ProxyPublisher({Logger.LOGGING_TOPIC: BehaviorLog})

    @staticmethod
    def log(text: object, severity: int) -> None:
        """Publish a message for operators, and log it locally."""
        Logger.initialize()
        ProxyPublisher().publish(Logger.LOGGING_TOPIC, BehaviorLog(str(text), severity))
        Logger.local(text, severity)

    @staticmethod
    def local(text: object, severity: int) -> None:
        """Log a message locally only."""
        Logger._local_log.put(severity, str(text))

    @staticmethod
    def logdebug(text: object, *args: object) -> None:
        """Publish and log details for developers."""
        Logger.log(_formatted(text, args), Logger.REPORT_DEBUG)

    @staticmethod
    def loginfo(text: object, *args: object) -> None:
        """Publish and log what happens."""
        Logger.log(_formatted(text, args), Logger.REPORT_INFO)

    @staticmethod
    def logwarn(text: object, *args: object) -> None:
        """Publish and log a problem that the behavior handles by itself."""
        Logger.log(_formatted(text, args), Logger.REPORT_WARN)

    @staticmethod
    def loghint(text: object, *args: object) -> None:
        """Publish and log a hint what the operator can do."""
        Logger.log(_formatted(text, args), Logger.REPORT_HINT)

    @staticmethod
    def logerr(text: object, *args: object) -> None:
        """Publish and log a problem that needs the operator."""
        Logger.log(_formatted(text, args), Logger.REPORT_ERROR)

    @staticmethod
    def localdebug(text: object, *args: object) -> None:
        """Log details for developers, locally only."""
        Logger.local(_formatted(text, args), Logger.REPORT_DEBUG)

    @staticmethod
    def localinfo(text: object, *args: object) -> None:
        """Log what happens, locally only."""
        Logger.local(_formatted(text, args), Logger.REPORT_INFO)


def _formatted(text: object, args: tuple[object, ...]) -> str:
    return str(text) % args if args else str(text)
