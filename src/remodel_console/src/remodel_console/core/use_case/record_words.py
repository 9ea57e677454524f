"""What a page says about the record of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

from remodel_console.core.run.chart_terms import recorded_state
from remodel_console.core.use_case.record import Entry, Kind, Record
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


def in_chart_terms(record: Record, paths_of: Callable[[str], frozenset[str]]) -> Record:
    """Return a record whose entries name states of the charts; `paths_of` a behavior's chart."""
    paths_of = cache(paths_of)
    named, behavior = [], ""
    for entry in record.entries:
        behavior = entry.behavior or behavior
        if entry.state_path:
            state = recorded_state(entry.state_path, paths_of(behavior)).words
            named.append(replace(entry, state=state))
        else:
            named.append(entry)
    return Record(tuple(named))


def entry_words(entry: Entry) -> str:
    """Return an entry as an operator reads it."""
    if entry.kind is Kind.STATE:
        return entry.state or entry.state_path or "the behavior has ended"
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
