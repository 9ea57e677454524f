"""The engine as a ROS node: runs behaviors on request, one at a time, and publishes their status.

    idle --start request--> preparing --STARTED--> running --FINISHED or FAILED--> idle
                                |                    | ^
                                +--ERROR--> idle     | +--ERROR-- (the switch is refused)
                                                     v |
      preparing <--SWITCHING-- (the old version) -- switching

A request for another version of the running behavior switches to it: the active state continues in
the new version, locked. Any other request during a run is refused, and changes nothing.

Commands that stay in force (pause, lock, autonomy, attach, preempt) and arrive while a behavior is
prepared are in force when its first state is due. A preempt also ends the wait for action servers.
"""

from __future__ import annotations

import os
import threading
import time
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TypeVar

import rospy
from flexbe_msgs.msg import BehaviorSelection, BEStatus, CommandFeedback

from flexbe_core import Behavior, BehaviorLibrary, Logger
from flexbe_core.behavior import paired
from flexbe_core.engine.engine import ErrorPolicy, MigratingState
from flexbe_core.engine.user_data import BehaviorFailure, StateMachineError
from flexbe_core.proxy.proxy_action_client import WAITS, cancel_all_goals
from flexbe_core.ros import session
from flexbe_core.ros.command_hub import HUB
from flexbe_core.ros.topics import START_AT
from flexbe_onboard.behavior_source import (
    Modification,
    ModuleFreshness,
    OptionError,
    StartError,
    load_behavior,
    read_inputs,
)
from flexbe_onboard.run_watch import HangPolicy, HangWatch, Heartbeat, UserdataService

Choice = TypeVar("Choice", bound=Enum)

# [s] Wall time; no state of this project takes a tenth of it for one execution.
DEFAULT_HANG_LIMIT_S = 10.0


@dataclass(frozen=True)
class Options:
    """What the launch file chooses.

    Attributes:
        modifications: apply source changes that come with a request.
        start_at: start behaviors at any of their states, if a request says so.
        enable_clear_imports: import modules of behaviors and states again for each run.
        on_error: what happens when a state raises.
        hang_limit_s: [s] wall time of one execution that counts as a hang; 0 for none.
        on_hang: what happens when a state does not return.
    """

    modifications: bool = False
    start_at: bool = False
    enable_clear_imports: bool = False
    on_error: ErrorPolicy = ErrorPolicy.AUTO
    hang_limit_s: float = DEFAULT_HANG_LIMIT_S
    on_hang: HangPolicy = HangPolicy.REPORT


def read_options(modifications: bool = False) -> Options:
    """Return the options that the node's private parameters choose.

    Args:
        modifications: whether source changes are applied if the parameter is not set.

    Raises:
        OptionError: if a parameter is invalid.
    """
    return Options(
        modifications=bool(rospy.get_param("~modifications", modifications)),
        start_at=bool(rospy.get_param("~start_at", False)),
        enable_clear_imports=bool(rospy.get_param("~enable_clear_imports", False)),
        on_error=_choice("~on_error", ErrorPolicy.AUTO),
        hang_limit_s=_seconds("~hang_limit_s", DEFAULT_HANG_LIMIT_S),
        on_hang=_choice("~on_hang", HangPolicy.REPORT),
    )


def _choice(name: str, default: Choice) -> Choice:
    found = rospy.get_param(name, default.value)
    for member in type(default):
        if member.value == found:
            return member
    known = ", ".join(str(member.value) for member in type(default))
    raise OptionError(f"{name} must be one of {known}; found {found!r}")


def _seconds(name: str, default: float) -> float:
    found = rospy.get_param(name, default)
    if isinstance(found, int | float) and not isinstance(found, bool) and 0 <= found < float("inf"):
        return float(found)
    raise OptionError(f"{name} must be a number of seconds, 0 or more; found {found!r}")


# [s] Least wall time between STARTED and the status that ends the run: tools and tests read the
# last status a hundred times per second, and must not miss a short run.
_SHORTEST_RUN_S = 0.03

# [s] Wall time in which the last messages of a node that hangs are sent.
_FLUSH_S = 0.5

# os.EX_SOFTWARE: the node found a fault in itself.
_EXIT_HUNG = 70

# [s] Wall time that a running behavior gets to stop when the node is shut down.
_STOP_LIMIT_S = 3.0


class Phase(Enum):
    """What the engine is doing."""

    IDLE = "idle"
    PREPARING = "preparing"
    RUNNING = "running"
    SWITCHING = "switching"


class SwitchPhase(Enum):
    """The feedback on a request that arrives while a behavior runs."""

    RECEIVED = "received"
    START = "start"
    PREPARED = "prepared"
    FAILED = "failed"
    NOT_SWITCHABLE = "not_switchable"


class EngineNode:
    """The behavior engine of one namespace."""

    def __init__(self, options: Options) -> None:
        self._options = options
        self._lock = threading.Lock()
        self._phase = Phase.IDLE
        self._behavior: Behavior | None = None
        self._worker: threading.Thread | None = None
        self._started_at = 0.0
        self._preempts = 0  # that had arrived when the behavior began to be prepared
        self._switch: BehaviorSelection | None = None
        self._successor: Behavior | None = None
        self._status = rospy.Publisher("flexbe/status", BEStatus, latch=True, queue_size=100)
        self._feedback = rospy.Publisher("flexbe/command_feedback", CommandFeedback, queue_size=100)
        watch = HangWatch(options.hang_limit_s, lambda: self._behavior, self._on_hang)
        self._heartbeat = Heartbeat(watch.check)
        self._userdata_service = UserdataService(lambda: self._behavior)
        session.connect()
        WAITS.report, WAITS.is_stopped = Logger.logwarn, self._is_start_stopped
        self._library = BehaviorLibrary()
        self._freshness = ModuleFreshness()
        rospy.on_shutdown(self._stop)
        rospy.Subscriber("flexbe/start_behavior", BehaviorSelection, self._on_request)
        Logger.loginfo("the engine knows %d behaviors", self._library.count_behaviors())
        self._publish_status(BEStatus.READY, 0)

    def _on_request(self, request: BehaviorSelection) -> None:
        with self._lock:
            phase = self._phase
            if phase is Phase.IDLE:
                self._phase, self._preempts = Phase.PREPARING, HUB.preempts
                HUB.hold()
            elif phase is Phase.RUNNING:
                self._phase, self._switch = Phase.SWITCHING, request
        if phase is Phase.IDLE:
            self._worker = threading.Thread(target=self._work, args=(request,), name="behavior")
            self._worker.start()
        elif phase is Phase.RUNNING:
            threading.Thread(target=self._prepare_switch, args=(request,), name="switch").start()
        else:
            text = f"the engine is {phase.value} another; try again"
            self._refuse(request, SwitchPhase.FAILED, text)

    def _is_start_stopped(self) -> bool:
        """Return whether an operator has stopped the behavior while it is prepared."""
        return self._phase is Phase.PREPARING and HUB.preempts != self._preempts

    def _work(self, request: BehaviorSelection) -> None:
        """Prepare and run the behavior of a request, and its successors, in the run's thread."""
        try:
            behavior = self._prepare(request)
        except Exception as error:  # noqa: BLE001 - a StartError, or else the engine stays usable
            Logger.logerr("behavior is not started: %s", error)
            Logger.local(traceback.format_exc(), Logger.REPORT_DEBUG)
            self._become_idle(BEStatus.ERROR, request.behavior_checksum)
            return
        while True:
            code, args = self._run_whole(behavior)
            successor, self._successor = self._successor, None
            if successor is None:
                break
            self._publish_status(BEStatus.SWITCHING, behavior.id)
            behavior = successor
        self._become_idle(code, behavior.id, args)

    def _become_idle(self, code: int, behavior_id: int, args: Sequence[str] = ()) -> None:
        time.sleep(max(0.0, self._started_at + _SHORTEST_RUN_S - time.monotonic()))
        with self._lock:
            late, self._switch = self._switch, None
            self._behavior, self._phase = None, Phase.IDLE
            HUB.drop()
            # A behavior that ends with its engine was not stopped by an operator: it is lost.
            if not rospy.core.is_shutdown_requested():
                self._publish_status(code, behavior_id, args)
        if late is not None:
            text = "the running version ended before it could be switched"
            self._refuse(late, SwitchPhase.FAILED, text)

    def _run_whole(self, behavior: Behavior) -> tuple[int, list[str]]:
        """Run a behavior to its end, and return its last status."""
        try:
            return BEStatus.FINISHED, [self._run(behavior)]
        except BehaviorFailure as failure:
            Logger.logerr("behavior failed at %s", failure)
            trace = "".join(traceback.format_exception(failure.cause))
            Logger.local(trace, Logger.REPORT_ERROR)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - users' code; the engine must continue
            Logger.logerr("behavior failed: %s: %s", type(error).__name__, error)
            Logger.local(traceback.format_exc(), Logger.REPORT_ERROR)
        return BEStatus.FAILED, []

    def _refuse(self, request: BehaviorSelection, phase: SwitchPhase, why: str) -> None:
        Logger.logerr("start request refused: %s", why)
        self._feedback.publish("switch", [phase.value])
        self._publish_status(BEStatus.ERROR, request.behavior_checksum)

    # A switch: prepared on a thread of its own, then offered to the running behavior.

    def _prepare_switch(self, request: BehaviorSelection) -> None:
        """Prepare another version of the behavior, and offer it the active state."""
        running = self._behavior
        self._feedback.publish("switch", [SwitchPhase.RECEIVED.value])
        name = (self._library.get_behavior(request.behavior_id) or {}).get("name")
        if running is not None and name not in (None, running.name):
            text = f"behavior {running.name!r} is running; stop it first"
            self._call_off(request, SwitchPhase.NOT_SWITCHABLE, text)
            return
        try:
            behavior = self._prepare(request)
        except Exception as error:  # noqa: BLE001 - as in _work
            self._call_off(request, SwitchPhase.FAILED, str(error))
            return
        self._feedback.publish("switch", [SwitchPhase.START.value])
        if running is not None:
            running.release(lambda migrating: self._offer(request, behavior, migrating))

    def _offer(
        self, request: BehaviorSelection, behavior: Behavior, migrating: MigratingState | None
    ) -> bool:
        """Attach the active state; called by the thread of the run, between two executions."""
        if migrating is None:
            self._call_off(request, SwitchPhase.FAILED, "no state is active")
            return False
        try:
            behavior.attach_state(migrating)
        except StateMachineError as error:
            self._call_off(request, SwitchPhase.FAILED, str(error))
            return False
        with self._lock:
            self._phase, self._switch, self._successor = Phase.PREPARING, None, behavior
            self._preempts = HUB.preempts
            HUB.hold()
        self._feedback.publish("switch", [SwitchPhase.PREPARED.value])
        return True

    def _call_off(self, request: BehaviorSelection, phase: SwitchPhase, why: str) -> None:
        """Refuse a switch, unless the end of the behavior did so already; the run continues."""
        with self._lock:
            if self._switch is not request:
                return
            self._phase, self._switch = Phase.RUNNING, None
        self._refuse(request, phase, why)

    def _prepare(self, request: BehaviorSelection) -> Behavior:
        """Return the behavior, built and with its parameters and inputs.

        Raises:
            StartError: if the request cannot be granted.
        """
        modifications = [
            Modification(m.index_begin, m.index_end, m.new_content) for m in request.modifications
        ]
        if modifications and not self._options.modifications:
            raise StartError(
                "the request changes the behavior's source, which this engine does not allow; "
                "to allow it: roslaunch flexbe_onboard behavior_onboard.launch modifications:=true"
            )
        if self._options.enable_clear_imports:
            self._freshness.forget_all()
        self._freshness.forget_changed()
        behavior_class = load_behavior(
            self._library, request.behavior_id, request.behavior_checksum, modifications
        )
        try:
            return self._build(behavior_class, request)
        except StartError:
            raise
        except (Exception, SystemExit) as error:
            text = f"cannot build {behavior_class.__name__}: {type(error).__name__}: {error}"
            raise StartError(text) from error
        finally:
            self._freshness.remember()

    def _build(self, behavior_class: type[Behavior], request: BehaviorSelection) -> Behavior:
        behavior, start = behavior_class(), ""
        try:
            for key, value in paired(request.arg_keys, request.arg_values):
                if key == START_AT:
                    start = value
                elif not behavior.set_parameter(key, value):
                    Logger.logwarn("behavior %s has no parameter %r", behavior.name, key)
            inputs = read_inputs(request.input_keys, request.input_values)
        except ValueError as error:
            raise StartError(str(error)) from error
        behavior.set_up(
            request.behavior_checksum, request.autonomy_level, False, self._options.on_error
        )
        if not start:
            behavior.prepare_for_execution(inputs)
            return behavior
        if not self._options.start_at:
            raise StartError(
                f"the request starts {behavior.name!r} at {start!r}, which this engine does not "
                "allow, as a cell may not be as the state expects it; to allow it for a simulated "
                "cell: roslaunch flexbe_onboard behavior_onboard.launch start_at:=true"
            )
        behavior.prepare_for_execution()
        try:
            behavior.start_at(start, inputs)
        except StateMachineError as error:
            raise StartError(str(error)) from error
        return behavior

    def _run(self, behavior: Behavior) -> str:
        """Run a behavior and return its outcome."""
        behavior.confirm()
        self._behavior, self._phase = behavior, Phase.RUNNING
        path = behavior.requested_state_path
        self._publish_status(BEStatus.STARTED, behavior.id, [] if path is None else [path])
        self._started_at = time.monotonic()
        Logger.loginfo("behavior %s started", behavior.name)
        outcome = behavior.execute()
        Logger.loginfo("behavior %s ended with %s", behavior.name, outcome)
        return outcome

    def _on_hang(self, behavior: Behavior, path: str) -> None:
        """End the node if that is the policy; Python cannot end only the thread that hangs."""
        if self._options.on_hang is not HangPolicy.RESTART:
            return
        Logger.logerr("behavior %s failed: %s hangs; the engine restarts", behavior.name, path)
        cancel_all_goals()
        self._publish_status(BEStatus.FAILED, behavior.id)
        time.sleep(_FLUSH_S)
        os._exit(_EXIT_HUNG)

    def _publish_status(self, code: int, behavior_id: int, args: Sequence[str] = ()) -> None:
        self._status.publish(BEStatus(behavior_id=behavior_id, code=code, args=list(args)))

    def _stop(self) -> None:
        """Stop what runs when the node is shut down, so that its goals are cancelled."""
        behavior, worker = self._behavior, self._worker
        if behavior is not None and worker is not None:
            behavior.preempt()
            worker.join(_STOP_LIMIT_S)


class FlexbeOnboard(EngineNode):
    """The behavior engine in the calling program's node.

    As in stock FlexBE, and unlike the node of behavior_onboard.launch, it applies source changes
    in requests unless `~modifications` is false: the embedding program decides who may send them.
    """

    def __init__(self) -> None:
        """Advertise everything, and publish that the engine is ready.

        Raises:
            OptionError: if a private parameter of the node is invalid.
        """
        super().__init__(read_options(modifications=True))

    @property
    def _behavior_lib(self) -> BehaviorLibrary:
        """The behaviors that it finds; tests of stock FlexBE add their own."""
        return self._library
