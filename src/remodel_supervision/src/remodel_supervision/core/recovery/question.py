"""What an operator is asked about a task that its cell cannot do by itself."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import Enum

from remodel_run.progress import Answer
from remodel_supervision.core.recovery.decide import counted_deeds
from remodel_supervision.core.runs.events import Asked
from remodel_supervision.core.runs.state import RunState
from remodel_tasks.core.use_case.fault import FaultTable


def question_about(
    state: RunState, name: str, faults: FaultTable, at_s: float, timeout_s: float = 0.0
) -> Asked:
    """Return the question about a task whose last decision was to ask.

    Args:
        state: of the run.
        name: of the task.
        faults: that there are.
        at_s: [s] ROS time.
        timeout_s: [s] ROS time after which it escalates; 0: never.
    """
    task = state.tasks[name]
    last = task.decisions[-1]
    tried = [decision.do for decision in task.decisions[:-1]]
    parts = [
        f"{last.fault.replace('_', ' ').capitalize()}: {last.text}.",
        faults[last.fault].symptoms,
        f"Tried so far: {counted_deeds(tried)}." if tried else "",
        "The hand may hold a wire that could not be laid down." if task.stuck_hand else "",
        f"Connected: end {' and end '.join(task.connected)}." if task.connected else "",
    ]
    text = " ".join(filter(None, parts))
    # The usual one first: a person has seen to what the cell could not do, and the cell checks.
    choices = [Answer.FIXED, Answer.RETRY, Answer.MARK_DONE, Answer.SKIP]
    if state.waiting:
        choices.append(Answer.REPLAN)
    return Asked(
        state.questions + 1, name, text, (*choices, Answer.STOP), at_s=at_s, timeout_s=timeout_s
    )


class NoticeKind(Enum):
    """What has happened to a question."""

    ASKED = "question_asked"
    TIMED_OUT = "question_timed_out"


@dataclass(frozen=True)
class QuestionNotice:
    """A question that an operator is to answer, or has not answered in time.

    Attributes:
        event: what has happened.
        cell: that works on the order.
        run: number of the run.
        task: that the question is about.
        question: its number in the run.
        text: of the question.
        choices: that it has.
        timeout_s: [s] ROS time for an answer; 0: as long as it takes.
        then: what is done when it has passed, "set_aside" or "stop".
    """

    event: NoticeKind
    cell: str
    order: str
    run: int
    task: str
    question: int
    text: str
    choices: tuple[str, ...]
    timeout_s: float
    then: str

    def data(self) -> dict[str, object]:
        """Return it as plain data, for JSON."""
        return {**asdict(self), "event": self.event.value, "choices": list(self.choices)}
