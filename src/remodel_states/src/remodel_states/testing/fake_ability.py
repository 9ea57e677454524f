"""Ability servers without a robot: their answers are scripted, and given at once or never.

For tests, and for dry runs of behaviors (`rosrun remodel_states fake_abilities`).
"""

from __future__ import annotations

import threading
from collections.abc import Iterable
from dataclasses import dataclass

import rospy
from genpy import Message
from remodel_msgs.msg import ErrorCode

from remodel_states.ability_server import AbilityServer
from remodel_states.core.ability_error import AbilityError
from remodel_states.core.ability_tables import Ability, chosen_abilities
from remodel_states.edge.exported_tables import read_abilities
from remodel_states.serving import RunningGoal


@dataclass(frozen=True)
class FakeAnswer:
    """How a fake ability answers one goal.

    Attributes:
        error_code: 0 succeeds, another code aborts with it.
        refuse: reject the goal instead.
        hang: never answer; the goal ends only when it is cancelled.
        contradict: say success in the result, whatever the code.
        elapsed_s: [s] elapsed_time of the result.
    """

    error_code: int = ErrorCode.NONE
    refuse: bool = False
    hang: bool = False
    contradict: bool = False
    elapsed_s: float = 0.1


class FakeAbility(AbilityServer):
    """A server that answers one goal after the other at once; the last answer is repeated."""

    def __init__(
        self,
        ability: str | Ability,
        answers: Iterable[FakeAnswer] = (FakeAnswer(),),
        topic: str = "",
    ) -> None:
        """Start to serve an ability, on its usual topic unless another is given."""
        self._lock = threading.Lock()
        self.script(*answers)
        super().__init__(ability, topic=topic)

    def script(self, *answers: FakeAnswer) -> None:
        """Replace the answers to come and forget the goals that came."""
        with self._lock:
            self._answers = list(answers)
            self.goals: list[Message] = []
            self.cancelled: list[str] = []

    def prepare(self, goal: Message) -> FakeAnswer:
        """Return the next answer, unless it refuses the goal."""
        with self._lock:
            answer = self._answers.pop(0) if len(self._answers) > 1 else self._answers[0]
            self.goals.append(goal)
        if answer.refuse:
            code = answer.error_code or ErrorCode.INVALID_GOAL
            raise AbilityError(code, _reason(code))
        return answer

    def start(self, running: RunningGoal, prepared: FakeAnswer) -> None:
        """Answer."""
        if not prepared.hang:
            self.finish(running, lambda: self._answer(running, prepared))

    def cancel(self, running: RunningGoal) -> None:
        """End a goal that hangs."""
        with self._lock:
            self.cancelled.append(running.goal.id)
        self.finish(running, lambda: running.fail(ErrorCode.PREEMPTED, "cancelled", {}))

    def _answer(self, running: RunningGoal, answer: FakeAnswer) -> None:
        code, elapsed = answer.error_code, {"elapsed_time": answer.elapsed_s}
        if code == ErrorCode.NONE:
            running.succeed("done, by a fake", {**self.ability.fake, **elapsed})
        else:
            found = {**elapsed, "success": answer.contradict}
            running.fail(code, _reason(code), found)


def _reason(code: int) -> str:
    return f"scripted to answer error {code}"


def serve_all(
    codes: dict[str, list[int]], abilities: object = "", others: object = ""
) -> list[FakeAbility]:
    """Serve abilities.

    Args:
        codes: for some abilities, the error codes of successive goals; 0 succeeds.
        abilities: names of those to serve, see chosen_abilities; empty: all.
        others: names of those of them not to serve.

    Raises:
        ValueError: if one of them names no ability.
    """
    rows = read_abilities()
    unknown = sorted(set(codes) - set(rows))
    if unknown:
        raise ValueError(f"no such ability: {', '.join(unknown)}; there are {', '.join(rows)}")
    names = chosen_abilities(list(rows), abilities, others)
    fakes = [
        FakeAbility(rows[name], [FakeAnswer(code) for code in codes.get(name, [0])])
        for name in names
    ]
    rospy.loginfo("fake abilities serve: %s", ", ".join(names))
    return fakes
