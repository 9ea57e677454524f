"""The synthesis action server: requests in a queue, served one after another by one thread."""

from __future__ import annotations

import os
import queue
import threading
import time
from dataclasses import asdict
from pathlib import Path

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from flexbe_msgs.msg import (
    BehaviorSynthesisAction,
    BehaviorSynthesisFeedback,
    BehaviorSynthesisResult,
    OutcomeCondition,
    StateInstantiation,
    SynthesisErrorCodes,
)

from flexbe_core.ros.master import SteadyActionServer
from flexbe_synthesizer.core.export.layout import Instantiation
from flexbe_synthesizer.edge.chart_files import ChartMemory
from flexbe_synthesizer.edge.package_path import find_packages
from flexbe_synthesizer.synthesis import (
    ErrorCode,
    Request,
    RequestError,
    RequestResult,
    Settings,
    deadline,
    fulfil,
)

ACTION = "flexbe/synthesize"
_MOST_WAITING = 64  # requests; who has more outstanding has lost count of them


class SynthesisServer:
    """Serves `flexbe_msgs/BehaviorSynthesis` on the relative name `flexbe/synthesize`."""

    def __init__(self, settings: Settings, time_limit_s: float) -> None:
        """Start serving; a request may take `time_limit_s` [s] from when it is served."""
        self._settings = settings
        self._memory = ChartMemory()
        self._time_limit_s = time_limit_s
        self._waiting: queue.Queue[actionlib.ServerGoalHandle] = queue.Queue(_MOST_WAITING)
        self._worker = threading.Thread(target=self._work, name="synthesis", daemon=True)
        self._server = SteadyActionServer(
            ACTION, BehaviorSynthesisAction, self._take_goal, self._take_cancel, auto_start=False
        )
        self._worker.start()
        self._server.start()

    def _take_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        try:
            self._waiting.put_nowait(handle)
        except queue.Full:
            text = f"{_MOST_WAITING} requests are waiting already; send this one again later"
            handle.set_rejected(_failure(ErrorCode.QUEUE_FULL), text)

    def _take_cancel(self, handle: actionlib.ServerGoalHandle) -> None:
        """End a request that still waits; one that is served sees it at its next step."""
        if handle.get_goal_status().status == GoalStatus.RECALLING:
            handle.set_canceled(_failure(ErrorCode.CANCELLED), "cancelled before it was served")

    def _work(self) -> None:
        while not rospy.is_shutdown():
            try:
                handle = self._waiting.get(timeout=1.0)
            except queue.Empty:
                continue
            if handle.get_goal_status().status == GoalStatus.PENDING:
                self._serve(handle)

    def _serve(self, handle: actionlib.ServerGoalHandle) -> None:
        """Fulfil one request and return its result."""
        handle.set_accepted()
        asked = handle.get_goal().request
        rospy.loginfo("synthesizing %s for '%s'", asked.goal, asked.name)

        def report(status: str, progress: float) -> None:
            handle.publish_feedback(BehaviorSynthesisFeedback(status, progress))

        in_time = deadline(self._time_limit_s, time.monotonic)  # a client waits

        def expect_time() -> None:
            in_time()
            # It may have been cancelled at the very moment at which it was accepted.
            if handle.get_goal_status().status != GoalStatus.ACTIVE:
                raise RequestError(ErrorCode.CANCELLED, "cancelled; nothing was written")

        request = Request(asked.goal, asked.initial_condition, tuple(asked.sm_outcomes))
        try:
            answer = fulfil(request, self._settings, report, expect_time, memory=self._memory)
            _succeed(handle, answer)
        except RequestError as error:
            self._fail(handle, error.code, str(error))
        except Exception as error:  # noqa: BLE001 - one request must not end the others
            rospy.logerr("synthesis failed", exc_info=True)
            self._fail(handle, ErrorCode.INTERNAL, f"internal error: {error!r}; see the log")

    def _fail(self, handle: actionlib.ServerGoalHandle, code: ErrorCode, text: str) -> None:
        handle.publish_feedback(BehaviorSynthesisFeedback(text, 1.0))
        if code is ErrorCode.CANCELLED:
            rospy.loginfo("synthesis: %s", text)
            handle.set_canceled(_failure(code), text)
        else:
            rospy.logerr("synthesis failed, %s (%d): %s", code.name, code, text)
            handle.set_aborted(_failure(code), text)


def _succeed(handle: actionlib.ServerGoalHandle, answer: RequestResult) -> None:
    for warning in answer.warnings:
        rospy.logwarn("%s", warning)
    text = f"{len(answer.states)} states, wrote {', '.join(map(str, answer.written)) or 'nothing'}"
    handle.publish_feedback(BehaviorSynthesisFeedback(text, 1.0))
    rospy.loginfo("synthesis: %s", text)
    states = [_message(state) for state in answer.states]
    result = BehaviorSynthesisResult(SynthesisErrorCodes(ErrorCode.SUCCESS), states)
    handle.set_succeeded(result, text)


def _failure(code: ErrorCode) -> BehaviorSynthesisResult:
    return BehaviorSynthesisResult(SynthesisErrorCodes(code), [])


def _message(state: Instantiation) -> StateInstantiation:
    fields = asdict(state)
    fields["cond_transition"] = [
        OutcomeCondition([name for name, _ in pairs], [outcome for _, outcome in pairs])
        for pairs in state.cond_transition
    ]
    return StateInstantiation(**fields)


# Read the server's parameters


def read_settings() -> Settings:
    """Return the settings that the private parameters of this node give.

    Raises:
        ValueError: if the package to write to does not exist.
    """
    ros_package_path = os.environ.get("ROS_PACKAGE_PATH", "")
    packages, _warnings = find_packages(ros_package_path)
    folders = [Path(f) for f in rospy.get_param("~chart_folders", "").split(os.pathsep) if f]
    if not folders:
        folders = sorted(p.folder / "charts" for p in packages if p.has_behaviors)
        folders.append(Path(rospy.get_param("~user_charts", "~/remodel_charts")).expanduser())
    output = rospy.get_param("~output", "remodel_behaviors")
    if os.sep in output:
        return Settings(tuple(folders), Path(output), ros_package_path)
    for package in packages:
        if package.name == output:
            return Settings(tuple(folders), package.folder, ros_package_path)
    raise ValueError(
        f"there is no package '{output}' on the ROS package path to write behaviors to; set "
        "~output (launch argument output) to a package's name or folder"
    )


def read_time_limit() -> float:
    """Return how long a request may take [s]."""
    return float(rospy.get_param("~time_limit", 60.0))
