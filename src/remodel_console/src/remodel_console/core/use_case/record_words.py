"""What a page says about the record of a run."""

from __future__ import annotations

from remodel_console.core.use_case.record import Entry, Kind
from remodel_console.core.use_case.use_case import decision_words, fault_words

KIND_WORDS = {
    Kind.RUN: "run",
    Kind.TASK: "task",
    Kind.STATE: "state",
    Kind.FEEDBACK: "feedback",
    Kind.RESULT: "result",
    Kind.FAILURE: "failure",
    Kind.DECISION: "decision",
    Kind.OPERATOR: "operator",
    Kind.PICTURE: "picture",
}


def entry_words(entry: Entry) -> str:
    """Return an entry as an operator reads it."""
    if entry.kind is Kind.STATE:
        return entry.state_path or "the behavior has ended"
    if entry.kind is Kind.FAILURE:
        return f"{fault_words(entry.fault)}: {entry.text}".removesuffix(": ")
    if entry.kind is Kind.DECISION:
        because = f", because {entry.because}" if entry.because else ""
        return f"The cell {decision_words(entry.text)}{because}."
    if entry.kind is Kind.OPERATOR:
        return f"{entry.because}: {entry.text}" if entry.because else entry.text
    if entry.kind is Kind.RUN and entry.because:
        return f"{entry.text}: {entry.because}"
    who = f"{entry.ability}: " if entry.ability else ""
    return f"{who}{entry.text}" or entry.kind.value
