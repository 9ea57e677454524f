"""The ROS master: whether it answers and is still the one joined; who is connected to a topic.

rospy waits for a master forever, and registers a node only once. A node that must not do so calls
`require_master` before it joins, and `spin` or a `MasterWatch` afterwards. rospy's handler of
signals deadlocks when one arrives while the node still advertises its topics. Therefore no program
calls rospy.init_node: nodes that serve call `join` and `spin`, commands call `join_interruptibly`.
"""

from __future__ import annotations

import _thread
import http.client
import signal
import socket
import threading
import time
import xmlrpc.client
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import actionlib
import rosgraph
import rospy
from actionlib_msgs.msg import GoalID
from genpy import Message

from flexbe_core.ros.clock import report_standstill

# [s] Wall time that a master which is being started gets to answer.
START_LIMIT_S = 5.0

# [s] Wall time after which a call to the master is given up.
CALL_LIMIT_S = 2.0

# [s] Wall time between two calls while a master is waited for, and while one is watched.
_WAIT_EVERY_S = 0.1
WATCH_EVERY_S = 1.0

# [s] Wall time between two wake-ups of a node's main thread.
_SIGNALS_EVERY_S = 0.5

# [s] Wall time that a node whose shutdown was requested by ROS gets to stop publishing.
_SERVED_LIMIT_S = 2.0

# [s] Wall time without an answer after which a master counts as silent.
SILENCE_S = 5.0

# os.EX_UNAVAILABLE: what the node was registered with is gone.
EXIT_MASTER_RESTARTED = 69

_CALLER = "/master_check"


class NoMasterError(Exception):
    """There is no ROS master; the text names its URI and what to do."""


@dataclass(frozen=True, slots=True)
class Identity:
    """What distinguishes one master from the next at the same URI.

    Attributes:
        pid: of its process; in containers each may have the same.
        run_id: that roslaunch gives it; empty if it has not done so yet.
    """

    pid: int
    run_id: str

    def is_same(self, later: Identity) -> bool:
        """Return whether the master that `later` answers at the URI is this one."""
        known = self.run_id and later.run_id
        return self.pid == later.pid and (not known or self.run_id == later.run_id)


class _Transport(xmlrpc.client.Transport):
    """HTTP with a time limit: a stopped process still accepts connections, and never answers."""

    def make_connection(self, host: str | tuple[str, dict[str, str]]) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = CALL_LIMIT_S
        return connection


def master_identity() -> Identity | None:
    """Return which master answers now, None if none does within 2 s a call."""
    try:
        uri = rosgraph.get_master_uri()
        with xmlrpc.client.ServerProxy(uri, transport=_Transport()) as master:
            _, _, pid = master.getPid(_CALLER)
            code, _, run_id = master.getParam(_CALLER, "/run_id")
    except (OSError, ValueError, TypeError, http.client.HTTPException, xmlrpc.client.Error):
        return None
    return Identity(int(pid), str(run_id) if code == 1 else "")


def require_master(limit_s: float = START_LIMIT_S) -> None:
    """Return as soon as a ROS master answers.

    Args:
        limit_s: [s] of wall time to wait for one.

    Raises:
        NoMasterError: if none does.
    """
    end = time.monotonic() + limit_s
    while master_identity() is None:
        if time.monotonic() >= end:
            raise NoMasterError(
                f"no ROS master at {rosgraph.get_master_uri()} within {limit_s:g} s; "
                "start one with roscore or roslaunch, or set ROS_MASTER_URI"
            )
        time.sleep(_WAIT_EVERY_S)


class MasterWatch:
    """Watches, on a thread of its own, the master that the node has joined."""

    def __init__(
        self,
        on_restart: Callable[[str], None],
        on_silence: Callable[[str], None] = rospy.logwarn,
        on_return: Callable[[], None] = lambda: None,
        joined: Identity | None = None,
    ) -> None:
        """Begin to watch; callbacks are called from the thread of the watch.

        Args:
            on_restart: gets one sentence when another master answers at the URI; this node is not
                registered with it. Called once for each restart.
            on_silence: gets one sentence when none has answered for SILENCE_S.
            on_return: called when the master answers again after that, and is the same.
            joined: the master that the node has joined; the one that answers now, if not given.
        """
        self._on_restart = on_restart
        self._on_silence = on_silence
        self._on_return = on_return
        self._joined = joined or master_identity()
        self._silent_since: float | None = None
        self._is_silent = False
        self._ended = threading.Event()
        rospy.on_shutdown(self.stop)
        threading.Thread(target=self._watch, name="master watch", daemon=True).start()

    def stop(self) -> None:
        """Watch no more."""
        self._ended.set()

    def _watch(self) -> None:
        while not self._ended.wait(WATCH_EVERY_S):
            found = master_identity()
            if self._ended.is_set():
                return
            if found is None:
                self._note_silence()
            else:
                self._note_answer(found)

    def _note_silence(self) -> None:
        # Not since the last answer: this process may have been stopped meanwhile itself.
        self._silent_since = self._silent_since or time.monotonic()
        silent_s = time.monotonic() - self._silent_since
        if silent_s >= SILENCE_S and not self._is_silent:
            self._is_silent = True
            self._on_silence(
                f"the ROS master at {rosgraph.get_master_uri()} has not answered for "
                f"{silent_s:.0f} s; nodes that start now are not found"
            )

    def _note_answer(self, found: Identity) -> None:
        was_silent = self._is_silent
        self._is_silent, self._silent_since = False, None
        is_same = self._joined is None or self._joined.is_same(found)
        if not is_same or found.run_id:
            self._joined = found
        if not is_same:
            self._on_restart(
                f"the ROS master at {rosgraph.get_master_uri()} was restarted: nodes that joined "
                "the former one and nodes of the new one cannot find each other; "
                "restart the launch"
            )
        elif was_silent:
            self._on_return()


_ended = threading.Event()

# The master that this process has joined; empty before, None if it was gone at once.
_joined: list[Identity | None] = []


def join(name: str) -> None:
    """Become a node that SIGINT and SIGTERM end once it calls `spin`, not while it is set up."""
    threading.excepthook = _log_error
    # Without a master, rospy waits for one, and a signal must be able to end that.
    found = master_identity()
    if found is not None:
        _keep_signals()
    rospy.init_node(name, disable_signals=True)
    if found is None:
        _keep_signals()
    _joined[:] = [found or master_identity()]
    _check_node()


def _check_node() -> None:
    """Have mistakes of the set-up logged that ROS itself does not mention."""
    report_standstill()
    # On a thread: a name server that does not answer takes many seconds.
    threading.Thread(target=report_unknown_host, name="host name", daemon=True).start()


def report_unknown_host() -> None:
    """Log a warning if the host name that other nodes use for this one does not resolve."""
    host = rosgraph.network.get_host_name()
    try:
        socket.getaddrinfo(host, None)
    except OSError as error:
        rospy.logwarn(
            "the host name of this node, %s, does not resolve (%s), so that no other node can "
            "connect to it; set ROS_HOSTNAME or ROS_IP to what others reach",
            host,
            error,
        )


def _keep_signals() -> None:
    """Have signals end `spin`, and nothing before it."""
    for number in (signal.SIGINT, signal.SIGTERM):
        # On a thread of its own: the main thread may hold any lock now, that of the event too.
        signal.signal(number, lambda *_: _thread.start_new_thread(_ended.set, ()))


def _log_error(error: threading.ExceptHookArgs) -> None:
    """Print what ended a thread, unless it only published while ROS was closing the topics.

    The timers of actionlib's servers do that at each shutdown.
    """
    if not is_late_publication(error.exc_value):
        threading.__excepthook__(error)


def is_late_publication(error: BaseException | None) -> bool:
    """Return whether an error only says that ROS is shutting down and has closed a topic."""
    is_closed = isinstance(error, rospy.ROSException) and "closed" in str(error)
    return is_closed and rospy.core.is_shutdown_requested()


def join_interruptibly(name: str, anonymous: bool = True) -> None:
    """Become a node for the length of a command: signals raise KeyboardInterrupt, as in Python.

    SIGTERM does so too if the main thread calls this; from another thread it leaves signals alone.
    """
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    rospy.init_node(name, anonymous=anonymous, disable_signals=True)
    _check_node()


def begin_node(name: str, limit_s: float) -> Callable[[], None]:
    """Become an anonymous node in the background, without handlers of signals.

    Registering takes about 0.1 s of talking to the master, which a short program can use.

    Args:
        name: of the node.
        limit_s: [s] how long to wait for a master.

    Returns:
        what waits until the process is a node; it raises NoMasterError if there is no master, and
        what rospy.init_node raised.
    """
    errors: list[Exception] = []

    def begin() -> None:
        try:
            require_master(limit_s)
            join_interruptibly(name)
        except Exception as error:  # noqa: BLE001 - raised in the thread that waits
            errors.append(error)

    thread = threading.Thread(target=begin, daemon=True)
    thread.start()

    def wait() -> None:
        thread.join()
        for error in errors:
            raise error

    return wait


def _wait(is_over: Callable[[], bool]) -> None:
    # Python handles signals in the main thread, but the system may deliver one to another thread,
    # for instance while that starts a third. Only a main thread that wakes up notices it then.
    while not is_over():
        _ended.wait(_SIGNALS_EVERY_S)


def spin(serve: Callable[[Callable[[], bool]], None] = _wait) -> int:
    """Serve until ROS shuts this node down, or its master was restarted; return the exit code.

    roslaunch respawns a node that ends with EXIT_MASTER_RESTARTED; it then joins the new master.

    Args:
        serve: what the calling thread does meanwhile; it gets a function that returns whether the
            node ends, and returns soon after that. Its topics are open until then.
    """
    restarts: list[str] = []

    def on_restart(text: str) -> None:
        restarts.append(text)
        _ended.set()

    # Another master may answer by now: setting up a node takes some time.
    watch = MasterWatch(on_restart, joined=_joined[0] if _joined else None)
    served = threading.Event()
    rospy.on_shutdown(lambda: _end(served))
    try:
        serve(_ended.is_set)
    finally:
        served.set()
    watch.stop()
    if not restarts:
        rospy.signal_shutdown("asked to end")
        return 0
    rospy.logfatal("%s", restarts[0])
    rospy.signal_shutdown(restarts[0])
    return EXIT_MASTER_RESTARTED


def _end(served: threading.Event) -> None:
    """End `spin`, and give it time to stop publishing before ROS closes the topics."""
    _ended.set()
    served.wait(_SERVED_LIMIT_S)


# An action server that keeps working when the ROS clock is set back, and ends quietly


class SteadyActionServer(actionlib.ActionServer):
    """An action server that continues to publish its status when `/clock` jumps back.

    The timer of actionlib's own server ends then, and clients count the server as lost. A goal that
    arrives while ROS closes the topics is dropped: no client would get an answer.
    """

    def initialize(self) -> None:
        """Set up the server, with a timer that survives."""
        super().initialize()
        if self.status_frequency > 0.0:
            self.status_timer.shutdown()
            period = rospy.Duration(1.0 / self.status_frequency)
            self.status_timer = rospy.Timer(period, self.publish_status_async, reset=True)

    def internal_goal_callback(self, goal: Message) -> None:
        """Handle a goal that has arrived."""
        with _without_late_publications():
            super().internal_goal_callback(goal)

    def internal_cancel_callback(self, goal_id: GoalID) -> None:
        """Handle a cancel that has arrived."""
        with _without_late_publications():
            super().internal_cancel_callback(goal_id)


@contextmanager
def _without_late_publications() -> Iterator[None]:
    try:
        yield
    except rospy.ROSException as error:
        if not is_late_publication(error):
            raise


def senders(subscriber: rospy.Subscriber) -> set[str]:
    """Return the names of the nodes from which a subscriber receives.

    The list that rospy keeps is replaced, never changed, so that it needs no lock; a connection
    that is still being made has no name yet. actionlib does the same.
    """
    return {c.callerid_pub for c in subscriber.impl.connections if c.callerid_pub != "unknown"}


def drop_dead(publisher: rospy.Publisher) -> None:
    """Drop a publisher's connections to nodes that have died.

    rospy notices them after a while, or when it writes. A node that has started again under its
    name seems to be connected until then, and what is sent to it is lost.
    """
    publisher.impl.check()


def is_heard(publisher: rospy.Publisher) -> bool:
    """Return whether any node receives what a publisher sends."""
    drop_dead(publisher)
    return bool(publisher.get_num_connections() > 0)


def hears(publisher: rospy.Publisher, node: str) -> bool:
    """Return whether a node receives what a publisher sends."""
    drop_dead(publisher)
    return bool(publisher.impl.has_connection(node))
