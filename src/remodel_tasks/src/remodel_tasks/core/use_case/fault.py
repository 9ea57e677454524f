"""Kinds of faults, as data, and a use case's responses to them.

remodel_msgs/config/faults.yaml describes each field. Nothing is tried forever: see `Limits`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

from remodel_tasks.errors import UseCaseError


class Do(Enum):
    """What may be done about a failure."""

    RETRY = "retry"
    RETRY_WITH = "retry_with"
    LOOK_AGAIN = "look_again"
    OTHER_METHOD = "other_method"
    NEW_PART = "new_part"
    OTHER_END = "other_end"
    REPLAN = "replan"
    SET_ASIDE = "set_aside"
    ASK_OPERATOR = "ask_operator"
    STOP = "stop"

    @property
    def is_lasting(self) -> bool:
        """Whether the task is not begun again by itself after it."""
        return self in (Do.SET_ASIDE, Do.ASK_OPERATOR, Do.STOP)


@dataclass(frozen=True)
class Change:
    """How a parameter changes with each attempt.

    Attributes:
        by: what is added to it, > 0.
        bound: what it never exceeds.
    """

    by: float
    bound: float


@dataclass(frozen=True)
class Response:
    """One thing to do.

    Attributes:
        times: how often before the next response has its turn.
        change: parameter -> change; only with Do.RETRY_WITH.
    """

    do: Do
    times: int = 1
    change: tuple[tuple[str, Change], ...] = ()


@dataclass(frozen=True)
class Fault:
    """A kind of fault.

    Attributes:
        codes: error codes (remodel_msgs/ErrorCode) that report it.
        after: how often in a row one of its codes must have come in one task.
        symptoms: what can be seen, felt or heard, a sentence.
        responses: tried in this order; the last is lasting.
        is_geometry: whether the same text again, with what was measured, is no chance: what was
            done in between is not done once more.
        stops_unattended: whether nothing may move after it until a person has inspected the cell.
    """

    name: str
    codes: frozenset[int]
    after: int
    symptoms: str
    responses: tuple[Response, ...]
    stops_unattended: bool = False
    is_geometry: bool = False


class FaultTable:
    """All kinds of faults."""

    def __init__(self, faults: Sequence[Fault]) -> None:
        """Take the faults in the order in which they are tried."""
        self._faults: Mapping[str, Fault] = {fault.name: fault for fault in faults}

    def __getitem__(self, name: str) -> Fault:
        """Return the fault of this name."""
        return self._faults[name]

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all faults, in order."""
        return tuple(self._faults)

    def of(self, code: int) -> Fault:
        """Return the fault that an error code reports by itself; KeyError if none does."""
        fault = self.diagnose([code])
        if fault is None:
            raise KeyError(f"no fault has error code {code}")
        return fault

    def diagnose(self, codes: Sequence[int]) -> Fault | None:
        """Return the fault that a task's error codes report; None if no fault has the last one.

        Of the faults with the last code, the one that needs the longest row of its codes wins.

        Args:
            codes: of the task's failures so far, the latest last.
        """
        found = [
            fault
            for fault in self._faults.values()
            if fault.after <= _row(codes, fault.codes) and codes[-1] in fault.codes
        ]
        return max(found, key=lambda fault: fault.after, default=None)


def _row(codes: Sequence[int], wanted: frozenset[int]) -> int:
    """Return how many of the latest codes, without a gap, are among those wanted."""
    count = 0
    for code in reversed(codes):
        if code not in wanted:
            break
        count += 1
    return count


@dataclass(frozen=True)
class Limits:
    """After which no more is tried by itself.

    Attributes:
        task_attempts: how often a task may be begun, interruptions not counted.
        task_s: [s] ROS time of all its attempts together.
        run_failures: failures of one run, after which it stops.
        run_s: [s] ROS time of one run, after which it stops.
    """

    task_attempts: int = 6
    task_s: float = 1800.0
    run_failures: int = 200
    run_s: float = 86400.0


@dataclass(frozen=True)
class QuestionLimit:
    """How long an operator has for an answer.

    Attributes:
        timeout_s: [s] ROS time from the question; 0: as long as it takes.
        escalate: what is done when it has passed, SET_ASIDE or STOP; None: what Policy.unattended
            says.
    """

    timeout_s: float = 0.0
    escalate: Do | None = None


@dataclass(frozen=True)
class Policy:
    """What to do about faults.

    Attributes:
        responses: fault name -> responses, where a use case responds otherwise than the table.
        unattended: what to do instead of asking an operator when there is none: SET_ASIDE or STOP.
    """

    responses: Mapping[str, tuple[Response, ...]] = field(default_factory=dict)
    limits: Limits = Limits()
    unattended: Do = Do.SET_ASIDE
    question: QuestionLimit = QuestionLimit()

    def responses_to(self, fault: Fault) -> tuple[Response, ...]:
        """Return what to do about a fault, in order."""
        return self.responses.get(fault.name, fault.responses)

    def unattended_for(self, fault: Fault) -> Do:
        """Return what to do about a fault where an operator would be asked and none is there."""
        return Do.STOP if fault.stops_unattended else self.unattended

    def unanswered_for(self, fault: Fault) -> Do:
        """Return what to do about a fault when a question about it was not answered in time."""
        return Do.STOP if fault.stops_unattended else self.question.escalate or self.unattended

    def require_known(self, faults: FaultTable) -> None:
        """Return if there is every fault that is answered.

        Raises:
            UseCaseError: naming one that there is not.
        """
        unknown = sorted(set(self.responses) - set(faults.names))
        if unknown:
            raise UseCaseError(
                f"recovery.responses.{unknown[0]}: there is no such fault; there are "
                f"{', '.join(faults.names)}"
            )


def policy_from(data: Mapping[str, Any]) -> Policy:
    """Return the policy of a document's `recovery`, which has the form of the use cases' schema."""
    return Policy(
        {
            fault: tuple(response_from(response) for response in responses)
            for fault, responses in data.get("responses", {}).items()
        },
        Limits(**data.get("limits", {})),
        Do(data.get("unattended", Do.SET_ASIDE.value)),
        _question_limit(data.get("question", {})),
    )


def _question_limit(data: Mapping[str, Any]) -> QuestionLimit:
    escalate = data.get("escalate")
    return QuestionLimit(float(data.get("timeout_s", 0.0)), Do(escalate) if escalate else None)


def response_from(data: Mapping[str, Any]) -> Response:
    """Return a response, as the table of faults and the use cases write it."""
    change = tuple(
        (name, Change(float(step["by"]), float(step["at_most"])))
        for name, step in data.get("change", {}).items()
    )
    return Response(Do(data["do"]), data.get("times", 1), change)
