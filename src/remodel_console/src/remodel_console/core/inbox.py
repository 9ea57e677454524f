"""The inbox: all that waits for a person, as cards of one kind.

The supervisor asks questions, states ask for values and decisions, and the engine asks before
transitions. A page shows all of them in the same way.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

from remodel_console.core.run.decision import Decision
from remodel_console.core.run.order import TakeOutcome
from remodel_console.core.run.run_view import Phase, RunView
from remodel_console.core.use_case.use_case import Question
from remodel_console.core.world import World
from remodel_run.progress import Answer

_ATTACHING = "No operator supervises this run: your answer attaches to it, at full autonomy."


class Kind(Enum):
    """Who waits for what; the values are what an operator reads."""

    QUESTION = "The cell needs your answer"
    INPUT = "The behavior needs a value"
    DECISION = "The behavior needs your decision"
    CONFIRMATION = "The engine asks for confirmation"


@dataclass(frozen=True)
class Option:
    """One answer: its label, what it does, and what is sent for it."""

    words: str
    meaning: str
    act: Answer | TakeOutcome


@dataclass(frozen=True)
class Card:
    """One thing that waits for a person.

    Attributes:
        kind: who waits for what.
        about: names it among all cards of its kind.
        text: what is asked.
        details: what helps to answer; empty if there is nothing.
        options: the answers to choose from, the usual one first; of an input none.
        question: of the supervisor, for its time limit.
        must_attach: no operator supervises the run, so the console attaches before it answers.
    """

    kind: Kind
    about: str
    text: str
    details: str = ""
    options: tuple[Option, ...] = ()
    question: Question | None = None
    must_attach: bool = False

    def record(self, option: Option) -> str:
        """Return an answer for the record of commands."""
        if self.question is not None:
            where = f"question {self.question.number} about {self.question.task}"
            return f"answer {where}: {option.words}"
        if self.kind is Kind.DECISION:
            return f"decide '{option.words}' of {self.about}"
        return str(option.act)


def cards(world: World) -> tuple[Card, ...]:
    """Return what waits for a person, the most urgent first."""
    return tuple(_cards(world))


def _cards(world: World) -> Iterator[Card]:
    use_case = world.current_use_case
    question = use_case.question if use_case else None
    if question is not None:
        options = tuple(Option(each.words, each.meaning, each) for each in question.choices)
        yield Card(
            Kind.QUESTION,
            str(question.number),
            f"{question.task}: {question.text}",
            options=options,
            question=question,
        )
    for request in world.inputs:
        yield Card(Kind.INPUT, str(request.number), request.text)
    if world.run.phase is Phase.RUNNING:
        yield from _of_run(world)


def _of_run(world: World) -> Iterator[Card]:
    """Yield what the behavior that runs waits for: at most one decision or confirmation."""
    run = world.run
    path = run.asked.path if run.asked else run.active
    is_known = world.decisions.behavior_id == run.behavior_id
    decision = world.decisions.at(path) if is_known and path else None
    if decision is not None and (run.asked or decision.suggestion not in decision.outcomes):
        yield _decision(run, path, decision)
    elif run.asked is not None:
        yield _confirmation(run, path)


def _decision(run: RunView, path: str, decision: Decision) -> Card:
    order = run.outcomes(path) or decision.outcomes  # as the engine numbers them
    first = [each for each in decision.outcomes if each == decision.suggestion]
    options = tuple(
        Option(
            outcome,
            "the suggestion of the state" if outcome in first else "",
            TakeOutcome(path, order.index(outcome), outcome, is_forced=True),
        )
        for outcome in dict.fromkeys((*first, *decision.outcomes))
        if outcome in order
    )
    return Card(
        Kind.DECISION,
        path,
        decision.hint or f"How does '{run.chart_state(path).label}' end?",
        "" if run.is_supervised else _ATTACHING,
        options,
        must_attach=not run.is_supervised,
    )


def _confirmation(run: RunView, path: str) -> Card:
    found = confirmation_of(run)
    if found is None:
        text = f"Leave '{run.chart_state(path).label}'?"
        return Card(
            Kind.CONFIRMATION,
            path,
            text,
            "Its outcomes are not known here; attach to the run first.",
        )
    state = run.chart_state(path)
    words = f"Confirm '{state.answer(found.outcome)}'"
    return Card(
        Kind.CONFIRMATION,
        path,
        state.question(found.outcome),
        options=(Option(words, "", found),),
    )


def confirmation_of(run: RunView) -> TakeOutcome | None:
    """Return the answer to what the engine asks; None if it asks nothing that is known."""
    if run.asked is None:
        return None
    outcomes = run.outcomes(run.asked.path)
    if run.asked.index >= len(outcomes):
        return None
    outcome = outcomes[run.asked.index]
    return TakeOutcome(run.asked.path, run.asked.index, outcome, is_forced=False)
