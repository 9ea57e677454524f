"""Which responses to a fault are worth trying, by how often they helped.

The order of the responses is the policy's; learning only skips those that hardly ever help. What
is known about one that is skipped is forgotten by and by, until it gets another chance.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

from remodel_planning.core.use_case.fault import Do
from remodel_supervision.core.learning.belief import Belief
from remodel_supervision.core.learning.success_model import SuccessModel

# [1] A response that surely helps less often costs more time than it saves.
LEAST_HELP = 0.2

# [1], [responses] What is assumed of one that nothing is known about, and the weight of that.
_UNKNOWN, _UNKNOWN_WEIGHT = 0.5, 2.0

# [responses] to the same fault over which each is remembered.
_MEMORY = 100.0


@dataclass(frozen=True)
class TriedResponse:
    """A response that was given to a fault.

    Attributes:
        fault: its name.
        do: the response.
        helped: whether the task went on without this fault.
    """

    fault: str
    do: Do
    helped: bool


def tried_responses(
    decisions: Sequence[tuple[str, Do]], finished: bool
) -> tuple[TriedResponse, ...]:
    """Return the responses that the decisions about one task were.

    Args:
        decisions: fault and response, in their order; what follows one shows whether it helped.
        finished: whether the task was done after the last one; if not, it is still under way, and
            whether it helped is unknown.
    """
    later = [fault for fault, _ in decisions[1:]]
    responses = [
        TriedResponse(fault, do, following != fault)
        for (fault, do), following in zip(decisions, later, strict=False)
    ]
    if decisions and finished:
        responses.append(TriedResponse(*decisions[-1], helped=True))
    return tuple(response for response in responses if not response.do.is_lasting)


class LearnedResponses:
    """What is known about all faults and responses."""

    def __init__(self, responses: Iterable[TriedResponse] = ()) -> None:
        """Take in responses, in their order."""
        self._models = {do: SuccessModel(_MEMORY) for do in Do if not do.is_lasting}
        for response in responses:
            self.learn(response)

    def learn(self, response: TriedResponse) -> None:
        """Take in a response; lasting ones are ignored."""
        if response.do not in self._models:
            return
        for do, model in self._models.items():
            if do is response.do:
                model.learn((response.fault,), response.helped)
            else:
                model.age((response.fault,))

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
