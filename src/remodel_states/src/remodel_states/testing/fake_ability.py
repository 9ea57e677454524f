"""Ability servers without a robot: they answer as they are told, at once or never.

For tests, and for dry runs of behaviors (`rosrun remodel_states fake_abilities`).
"""

from __future__ import annotations

import threading
from collections.abc import Iterable
from dataclasses import dataclass

import actionlib
import rospy
from genpy import Message
from remodel_msgs import msg as remodel_msgs
from remodel_msgs.msg import ErrorCode

from flexbe_core.ros.steady_action_server import SteadyActionServer
from remodel_states.testing.nonsense import nonsense

ABILITIES = (
    "CheckConnection",
    "DetectCable",
    "DiscardCable",
    "ExtractCable",
    "FixCable",
    "InsertCable",
    "LocateGearboxComponent",
    "PickCable",
    "PlaceCable",
    "PlaceConnector",
    "PlacePin",
    "RouteWire",
)


@dataclass(frozen=True)
class Answer:
    """How a fake ability answers one goal.

    Attributes:
        error_code: 0 succeeds, another code aborts with it.
        refuse: reject the goal instead.
        hang: never answer; the goal ends only when it is cancelled.
        contradict: say success in the result, whatever the code.
        elapsed_s: [s] told as the result's elapsed_time.
    """

    error_code: int = ErrorCode.NONE
    refuse: bool = False
    hang: bool = False
    contradict: bool = False
    elapsed_s: float = 0.1


class FakeAbility:
    """An action server that answers one goal after the other; the last answer is repeated."""

    def __init__(
        self, ability: str, answers: Iterable[Answer] = (Answer(),), topic: str = ""
    ) -> None:
        """Start to serve an ability, on its usual topic unless another is given."""
        self._types = {
            part: getattr(remodel_msgs, f"{ability}{part}") for part in ("Action", "Result")
        }
        self._answers = list(answers)
        self._lock = threading.Lock()
        self.goals: list[Message] = []
        self.cancelled: list[str] = []
        self._server = SteadyActionServer(
            topic or f"remodel_abilities/{ability.lower()}",
            self._types["Action"],
            self._on_goal,
            self._on_cancel,
            auto_start=False,
        )
        self._server.start()

    def script(self, *answers: Answer) -> None:
        """Replace the answers to come and forget the goals that came."""
        with self._lock:
            self._answers = list(answers)
            self.goals, self.cancelled = [], []

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        with self._lock:
            answer = self._answers.pop(0) if len(self._answers) > 1 else self._answers[0]
            self.goals.append(handle.get_goal())
        senseless = nonsense(handle.get_goal())
        if senseless:
            result = self._result(handle, Answer(refuse=True))
            result.error_message = senseless
            handle.set_rejected(result, senseless)
            return
        result = self._result(handle, answer)
        if answer.refuse:
            handle.set_rejected(result, result.error_message)
            return
        handle.set_accepted()
        if answer.hang:
            return
        if answer.error_code == ErrorCode.NONE:
            handle.set_succeeded(result)
        else:
            handle.set_aborted(result, result.error_message)

    def _on_cancel(self, handle: actionlib.ServerGoalHandle) -> None:
        with self._lock:
            self.cancelled.append(handle.get_goal().id)
        handle.set_canceled(self._result(handle, Answer(ErrorCode.PREEMPTED)), "cancelled")

    def _result(self, handle: actionlib.ServerGoalHandle, answer: Answer) -> Message:
        code = answer.error_code or (ErrorCode.INVALID_GOAL if answer.refuse else ErrorCode.NONE)
        return self._types["Result"](
            id=handle.get_goal().id,
            success=code == ErrorCode.NONE or answer.contradict,
            message="" if code else "done, by a fake",
            elapsed_time=answer.elapsed_s,
            error_code=code,
            error_message=f"told to answer error {code}" if code else "",
        )


def serve_all(codes: dict[str, list[int]]) -> list[FakeAbility]:
    """Serve every ability.

    Args:
        codes: for some abilities, the error codes of successive goals; 0 succeeds.

    Raises:
        ValueError: if codes names no ability.
    """
    unknown = sorted(set(codes) - set(ABILITIES))
    if unknown:
        raise ValueError(f"no such ability: {', '.join(unknown)}; there are {', '.join(ABILITIES)}")
    fakes = [
        FakeAbility(ability, [Answer(code) for code in codes.get(ability, [0])])
        for ability in ABILITIES
    ]
    rospy.loginfo("fake abilities serve: %s", ", ".join(ABILITIES))
    return fakes
