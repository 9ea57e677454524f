"""What persons who are not at the console are notified of."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from enum import Enum


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
