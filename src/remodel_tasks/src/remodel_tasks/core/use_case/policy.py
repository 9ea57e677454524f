"""A use case's responses to faults, and its limits: nothing is tried forever."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from remodel_tasks.core.use_case.fault import Change, Do, Fault, FaultTable, Response
from remodel_tasks.errors import UseCaseError


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
        limits: see Limits.
        unattended: what to do instead of asking an operator when there is none: SET_ASIDE or STOP.
        question: see QuestionLimit.
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
