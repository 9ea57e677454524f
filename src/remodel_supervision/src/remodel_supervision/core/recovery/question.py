"""What an operator is asked about a task that its cell cannot do by itself."""

from __future__ import annotations

from remodel_planning.core.use_case.fault import FaultTable
from remodel_run.progress import Answer
from remodel_supervision.core.recovery.decide import counted_deeds
from remodel_supervision.core.runs.events import Asked
from remodel_supervision.core.runs.state import RunState


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
