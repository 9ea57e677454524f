"""What pages show of the live system, and the inbox: all that waits for a person.

The supervisor asks questions, states ask for values and decisions, and the engine asks before
transitions. A page shows all of them in the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from enum import Enum

from remodel_console.core.run_view import Phase, RunView
from remodel_console.core.running import Decision, Decisions, TakeOutcome
from remodel_console.core.use_case import Question, UseCase
from remodel_run.progress import Answer
from remodel_run.progress import Phase as UseCasePhase


class Part(Enum):
    """What can run, and what starts it."""

    ENGINE = "engine"
    MIRROR = "mirror"
    SUPERVISOR = "supervisor"
    CELL = "cell"


@dataclass(frozen=True)
class Notice:
    """What does not run or answer, None for ROS: what that means, and what starts it."""

    part: Part | None
    what: str
    meaning: str
    remedy: str


@dataclass(frozen=True)
class InputRequest:
    """A value that a state waits for; `number` counts the requests of this console."""

    number: int
    text: str


class CellKind(Enum):
    """What ability servers move, as their nodes say; without a word, they are taken for real."""

    REAL = "real"
    SIMULATED = "simulated"
    FAKE = "fake"


# What pages about orders need.
ALL_PARTS = tuple(Part)

_STARTED_BY = {
    Part.ENGINE: "roslaunch flexbe_onboard behavior_onboard.launch",
    Part.MIRROR: "roslaunch flexbe_mirror behavior_mirror.launch",
    Part.SUPERVISOR: "roslaunch remodel_planner supervision.launch attended:=true "
    "output:=$HOME/remodel database:=sqlite:///$HOME/remodel/production.db",
    Part.CELL: "roslaunch remodel_sim cell.launch",
}
_STARTING = "The supervisor is starting."
_WITHOUT = {
    Part.ENGINE: "no behavior can run",
    Part.MIRROR: "the active state of a supervised run is not known",
    Part.SUPERVISOR: "no order can run, and the state of a running order is not known",
    Part.CELL: "no ability server answers, so states that move the robot will fail",
}


@dataclass(frozen=True)
class World:
    """Which nodes are running, and the run.

    Attributes:
        has_master: the ROS master answers.
        has_mirror: a mirror follows what runs.
        servers: how many ability servers answer.
        cell_kind: what they move; None without any.
        can_reset: the cell can rebuild its panel.
        has_supervisor: a use case supervisor is there.
        silent: what is registered at the master and does not answer.
        use_case: what it published last; None before that.
        outdated_s: wall time since which that is only what was known last [s]; None: it is current.
        trouble: why a supervisor that is starting cannot go on with that.
        inputs: values that states wait for, the oldest first.
        breakpoints: paths of states, as the engine names them, before whose end it asks.
        decisions: states of the running behavior in which an operator chooses the outcome.
    """

    run: RunView = field(default_factory=RunView)
    has_master: bool = False
    has_mirror: bool = False
    servers: int = 0
    cell_kind: CellKind | None = None
    can_reset: bool = False
    has_supervisor: bool = False
    silent: frozenset[Part] = frozenset()
    use_case: UseCase | None = None
    outdated_s: float | None = None
    trouble: str = ""
    inputs: tuple[InputRequest, ...] = ()
    decisions: Decisions = field(default_factory=Decisions)
    breakpoints: frozenset[str] = frozenset()

    @property
    def is_silent(self) -> bool:
        """Return whether the supervisor is there, but does not answer."""
        return Part.SUPERVISOR in self.silent

    @property
    def has_engine(self) -> bool:
        """Return whether a behavior engine is running."""
        return self.run.phase is not Phase.AWAY

    @property
    def current_use_case(self) -> UseCase | None:
        """Return what the supervisor publishes now; None if what is known is out of date."""
        return self.use_case if self.outdated_s is None else None

    @property
    def can_be_put_back(self) -> bool:
        """Return whether nothing real moves, so that a run may start in the middle."""
        return self.cell_kind is not CellKind.REAL

    @property
    def has_lost_run(self) -> bool:
        """Return whether an order was under way when its supervisor went away."""
        now = self.use_case
        return self.outdated_s is not None and now is not None and now.is_under_way

    @property
    def takes_sample(self) -> bool:
        """Return whether a sample order may begin: nothing real moves, and no order runs."""
        now = self.current_use_case
        return self.can_be_put_back and not (now is not None and now.is_under_way)

    def has(self, part: Part) -> bool:
        """Return whether it runs and answers."""
        there = {
            Part.ENGINE: self.has_engine,
            Part.MIRROR: self.has_mirror,
            Part.SUPERVISOR: self.has_supervisor,
            Part.CELL: self.servers > 0,
        }
        return self.has_master and there[part] and part not in self.silent


def with_use_case(world: World, use_case: UseCase, now_s: float) -> World:
    """Return the world after a supervisor has published a state, at a wall time [s].

    One that is starting knows nothing of the run yet: what was known of it stays.
    """
    known = world.use_case
    if use_case.phase is UseCasePhase.STARTING and known is not None and known.run:
        outdated_s = now_s if world.outdated_s is None else world.outdated_s
        return replace(world, outdated_s=outdated_s, trouble=use_case.message)
    return replace(world, use_case=use_case, outdated_s=None, trouble="")


def with_supervisor(world: World, *, answers: bool, now_s: float) -> World:
    """Return the world after it was checked whether a supervisor answers, at a wall time [s].

    What one that is gone has published last stays, out of date until one publishes again.
    """
    if answers or world.use_case is None or world.outdated_s is not None:
        return world
    return replace(world, outdated_s=now_s)


def supervisor_words(world: World, since: Callable[[float], str]) -> str:
    """Return why no order can be started or commanded; empty if one can.

    Args:
        world: what there is.
        since: returns a wall time [s] as an operator reads it.
    """
    now, trouble = world.current_use_case, world.trouble
    if now is not None:
        if now.phase is not UseCasePhase.STARTING:
            return ""
        trouble = now.message
    if world.has(Part.SUPERVISOR):
        words = f"The supervisor cannot take an order: {trouble}." if trouble else _STARTING
    else:
        words = f"The supervisor {'does not answer' if world.is_silent else 'is not running'}."
    if world.outdated_s is None:
        return words
    return f"{words} This is the last known state, out of date since {since(world.outdated_s)}."


def notices(world: World, parts: Iterable[Part]) -> Iterator[Notice]:
    """Yield which of these parts do not run or answer; without ROS, only that."""
    if not world.has_master:
        yield Notice(
            None,
            "ROS is not running",
            "the master does not answer, so the console cannot show or command the cell",
            "roscore",
        )
        return
    for part in parts:
        if part is Part.MIRROR and not world.has(Part.ENGINE):
            continue  # which the mirror follows
        if part in world.silent:
            meaning = "its process is stopped or hangs: let it go on, or end it and start it again"
            yield Notice(part, f"The {part.value} does not answer", meaning, _STARTED_BY[part])
        elif not world.has(part):
            what = f"The {part.value} is not running"
            yield Notice(part, what, _WITHOUT[part], _STARTED_BY[part])


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
