"""Which responses to a fault are worth trying, by how often they helped.

The order of the responses is the policy's; learning only passes over those that hardly ever help.
One that is passed over is forgotten about, and gets another chance when that has gone far enough.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

from remodel_planner.core.learning.belief import Belief
from remodel_planner.core.learning.success_model import SuccessModel
from remodel_planner.core.recovery.fault import Do

# [1] A response that surely helps less often costs more time than it saves.
LEAST_HELP = 0.2

# [1], [answers] What is assumed of a response that nothing is known about, and the weight of that.
_UNKNOWN, _UNKNOWN_WEIGHT = 0.5, 2.0

# [answers] to the same fault over which each is remembered.
_MEMORY = 100.0


@dataclass(frozen=True)
class Answer:
    """A response that was given to a fault.

    Attributes:
        fault: its name.
        do: the response.
        helped: whether the task went on without this fault.
    """

    fault: str
    do: Do
    helped: bool


def answers_of(decisions: Sequence[tuple[str, Do]], finished: bool) -> tuple[Answer, ...]:
    """Return the answers that the decisions about one task were.

    Args:
        decisions: fault and response, in their order; what follows one tells whether it helped.
        finished: whether the task was done after the last one; if it is still under way, leave
            that one out.
    """
    later = [fault for fault, _ in decisions[1:]]
    answers = [
        Answer(fault, do, following != fault)
        for (fault, do), following in zip(decisions, later, strict=False)
    ]
    if decisions:
        answers.append(Answer(*decisions[-1], finished))
    return tuple(answer for answer in answers if not answer.do.is_lasting)


class LearnedResponses:
    """What is known about all faults and responses."""

    def __init__(self, answers: Iterable[Answer] = ()) -> None:
        """Take in answers, in their order."""
        self._models = {do: SuccessModel(_MEMORY) for do in Do if not do.is_lasting}
        for answer in answers:
            self.learn(answer)

    def learn(self, answer: Answer) -> None:
        """Take in an answer; lasting ones tell nothing."""
        if answer.do not in self._models:
            return
        for do, model in self._models.items():
            if do is answer.do:
                model.learn((answer.fault,), answer.helped)
            else:
                model.age((answer.fault,))

    def belief(self, fault: str, do: Do) -> Belief:
        """Return what is believed about how often a response that is not lasting helps."""
        return self._models[do].belief((fault,), _UNKNOWN, _UNKNOWN_WEIGHT)

    def promising(self, fault: str, possible: Collection[Do]) -> frozenset[Do]:
        """Return those of the possible responses to a fault that are worth trying."""
        return frozenset(
            do
            for do in possible
            if do.is_lasting or self.belief(fault, do).interval()[1] >= LEAST_HELP
        )
