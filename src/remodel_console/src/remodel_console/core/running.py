"""The running behavior in terms of its chart, and what an operator can order the engine to do.

Of the chart: structure, active path, operator decisions; of the engine: orders, lines of its log.

Synthesis adds states to those of the chart: one that counts the attempts at a state (`X_attempts`),
one that parts its failures by code (`X_error`), and a container that keeps its time, with the state
as `run` and a timer beside it. An operator drew none of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum, auto
from functools import cached_property
from typing import TypeAlias

from flexbe_synthesizer.core.chart.model import Chart, State
from flexbe_synthesizer.core.chart.names import EXHAUSTED, FAILED, TIMED_OUT
from flexbe_synthesizer.core.machine.lower import OTHER, RUN, TIMER, chooser_label, counter_label
from remodel_console.core.drawing import drawn_path, drawn_paths
from remodel_console.core.editing import walk_paths


@dataclass(frozen=True)
class Level:
    """A state, or a container if it has children; the first child is the initial one.

    `outcomes` are in the engine's order, `transitions` say where each leads.
    """

    path: str
    children: tuple[str, ...]
    outcomes: tuple[str, ...]
    transitions: tuple[str, ...]


@dataclass(frozen=True)
class Structure:
    """All levels of a behavior; the path of its root is empty."""

    behavior_id: int
    levels: tuple[Level, ...]

    @cached_property
    def by_path(self) -> Mapping[str, Level]:
        """Return the levels by path."""
        return {level.path: level for level in self.levels}

    def following(self, path: str, outcome: str) -> str | None:
        """Return the state that is active after one was left; empty at the end of the behavior.

        None if it is not known, as in a container whose children run at the same time.
        """
        while path:
            level = self.by_path.get(path)
            above = path.rpartition("/")[0]
            container = self.by_path.get(above)
            if level is None or container is None or outcome not in level.outcomes:
                return None
            index = level.outcomes.index(outcome)
            target = level.transitions[index] if index < len(level.transitions) else ""
            if target in container.children:
                return self._first_in(f"{above}/{target}")
            if target not in container.outcomes:
                return None
            path, outcome = above, target
        return ""

    def _first_in(self, path: str) -> str:
        """Return the state that is entered first when a path is."""
        level = self.by_path.get(path)
        while level is not None and level.children:
            path = f"{path}/{level.children[0]}"
            level = self.by_path.get(path)
        return path


# Events that say that a state, or a behavior, did not do what it should.
FAILURES = frozenset({FAILED, TIMED_OUT, EXHAUSTED})


class Helper(Enum):
    """What synthesis adds to a state."""

    COUNTER = auto()
    CHOOSER = auto()
    TIMER = auto()


@dataclass(frozen=True)
class ChartState:
    """A state of the chart: its path, `Place/Insert`, and what stands for it in the engine.

    Attributes:
        helper: None if that is the state itself.
    """

    path: str
    helper: Helper | None = None

    @property
    def label(self) -> str:
        """Return its name."""
        return self.path.rpartition("/")[2]

    @property
    def words(self) -> str:
        """Return its path as a person reads it."""
        return f"{self.path.replace('/', ' / ')}{_WHERE[self.helper]}"

    def event(self, outcome: str) -> str:
        """Return the event of the chart that an outcome stands for; empty if it is entered."""
        match self.helper:
            case Helper.COUNTER:
                return EXHAUSTED if outcome == EXHAUSTED else ""
            case Helper.CHOOSER:
                return FAILED if outcome == OTHER else outcome
            case Helper.TIMER:
                return TIMED_OUT
        return outcome

    def question(self, outcome: str) -> str:
        """Return what is asked before an outcome is taken."""
        event = self.event(outcome)
        return f"Leave '{self.label}' with '{event}'?" if event else f"Enter '{self.label}'?"

    def answer(self, outcome: str) -> str:
        """Return the word for taking an outcome."""
        return self.event(outcome) or f"enter {self.label}"


_WHERE = {
    None: "",
    Helper.COUNTER: ", before an attempt",
    Helper.CHOOSER: ", after a failure",
    Helper.TIMER: ", its time limit",
}


def recorded_state(engine_path: str, drawn: frozenset[str]) -> ChartState:
    """Return which state of a chart is meant in the record of a run, which has no structure.

    Args:
        engine_path: as the engine published it, `/Place/Insert_attempts`.
        drawn: the paths of the chart, `Place/Insert`; without any, the names stay as they are.
    """
    path = drawn_path(engine_path, drawn)
    if not path:
        return ChartState(engine_path.strip("/"))
    label, own = engine_path.rpartition("/")[2], path.rpartition("/")[2]
    helpers = {
        counter_label(own): Helper.COUNTER,
        chooser_label(own): Helper.CHOOSER,
        TIMER: Helper.TIMER,
    }
    return ChartState(path, None if label == own else helpers.get(label))


def chart_state(engine_path: str, structure: Structure | None) -> ChartState:
    """Return which state of the chart is meant.

    Args:
        engine_path: as the engine publishes it, `/Place/Insert_attempts`.
        structure: of the running behavior; without one, the names stay as they are.
    """
    found: list[str] = []
    helper, above = None, ""
    for part in filter(None, engine_path.split("/")):
        beside = _children(above, structure)
        above = f"{above}/{part}"
        if beside == {RUN, TIMER}:
            helper = Helper.TIMER if part == TIMER else None
            continue
        outcomes = _outcomes(above, structure)
        name, helper = part, None
        for base in beside:
            if part == counter_label(base) and EXHAUSTED in outcomes:
                name, helper = base, Helper.COUNTER
            elif part == chooser_label(base) and OTHER in outcomes:
                name, helper = base, Helper.CHOOSER
        found.append(name)
    return ChartState("/".join(found), helper)


def _children(path: str, structure: Structure | None) -> frozenset[str]:
    level = structure.by_path.get(path) if structure else None
    return frozenset(level.children) if level else frozenset()


def _outcomes(path: str, structure: Structure | None) -> tuple[str, ...]:
    level = structure.by_path.get(path) if structure else None
    return level.outcomes if level else ()


_CLASS = "OperatorDecisionState"


@dataclass(frozen=True)
class Decision:
    """What a state lets an operator choose.

    Attributes:
        outcomes: to choose from, in the order of the state.
        hint: what the state says to the operator; empty without one.
        suggestion: the outcome that is taken if autonomy allows; empty if the state always waits.
    """

    outcomes: tuple[str, ...]
    hint: str = ""
    suggestion: str = ""


@dataclass(frozen=True)
class Decisions:
    """The decisions of the behavior whose source has a checksum, by their paths in its chart."""

    behavior_id: int = 0
    by_path: Mapping[str, Decision] = field(default_factory=dict)
    paths: frozenset[str] = frozenset()

    def at(self, engine_path: str) -> Decision | None:
        """Return the decision of a state, as the engine names it; None if it is of another kind."""
        return self.by_path.get(drawn_path(engine_path, self.paths)) if self.by_path else None


def decisions_of(chart: Chart, behavior_id: int) -> Decisions:
    """Return the decisions in a chart, in its containers too."""
    found = {}
    for path, node in walk_paths(chart):
        given = {param.name: param.value for param in node.params}
        outcomes = given.get("outcomes")
        is_decision = isinstance(node, State) and node.type.rpartition(".")[2] == _CLASS
        if is_decision and isinstance(outcomes, tuple):
            found["/".join(path)] = Decision(
                tuple(map(str, outcomes)),
                str(given.get("hint") or ""),
                str(given.get("suggestion") or ""),
            )
    return Decisions(behavior_id, found, drawn_paths(chart))


# What an operator can order the engine to do, and the lines of its log


STEP, FULL = 0, 3  # autonomy levels: the engine asks before each transition, or as good as none
UNATTENDED = 255  # the autonomy level that asks no operator, from FlexBE's wire protocol
LEVELS = {STEP: "off", 1: "low", 2: "high", FULL: "full", UNATTENDED: "unattended"}

Pairs: TypeAlias = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Start:
    """Run a behavior.

    Attributes:
        name: display name, for the record.
        behavior_id: checksum of `package.module`.
        source_checksum: checksum of its source, so that the engine runs the version shown.
        level: autonomy level.
        parameters: (key, literal) pairs.
        inputs: (key, literal) pairs of userdata.
        start_at: path of the state to start at, `/Place/Insert`; empty: the first.
    """

    name: str
    behavior_id: int
    source_checksum: int
    level: int
    parameters: Pairs = ()
    inputs: Pairs = ()
    start_at: str = ""

    def __str__(self) -> str:
        given = " ".join(f"{key}={value}" for key, value in (*self.parameters, *self.inputs))
        where = f" at {self.start_at}" if self.start_at else ""
        level = LEVELS.get(self.level, self.level)
        return f"start '{self.name}'{where} level {level} {given}".rstrip()


@dataclass(frozen=True)
class Switch:
    """Go on in another version of the behavior that runs; its active state is locked there.

    Attributes:
        name: display name, for the record.
        behavior_id: checksum of `package.module`.
        source_checksum: checksum of the source of that version.
        level: autonomy level, which stays.
    """

    name: str
    behavior_id: int
    source_checksum: int
    level: int

    def __str__(self) -> str:
        return f"switch to the saved version of '{self.name}'"


@dataclass(frozen=True)
class Attach:
    """Supervise the running behavior at an autonomy level."""

    level: int

    def __str__(self) -> str:
        return f"attach at level {LEVELS.get(self.level, self.level)}"


@dataclass(frozen=True)
class SetAutonomy:
    """Change the autonomy level of what runs."""

    level: int

    def __str__(self) -> str:
        return f"autonomy {LEVELS.get(self.level, self.level)}"


@dataclass(frozen=True)
class TakeOutcome:
    """Leave the active state with an outcome.

    Attributes:
        path: path of the state.
        index: place of the outcome among those of the state, from 0.
        outcome: its name, for the record.
        is_forced: the engine had not asked for it.
        is_by_path: the engine is given the state's path, as states of one name ask at breakpoints.
    """

    path: str
    index: int
    outcome: str
    is_forced: bool
    is_by_path: bool = False

    def __str__(self) -> str:
        return f"{'force' if self.is_forced else 'confirm'} '{self.outcome}' of {self.path}"


@dataclass(frozen=True)
class Hold:
    """Lock a level of the active path: it is not left until it is released."""

    path: str

    def __str__(self) -> str:
        return f"lock {self.path}"


@dataclass(frozen=True)
class Release:
    """Unlock what is locked."""

    path: str = ""

    def __str__(self) -> str:
        return f"unlock {self.path}".rstrip()


class SimpleOrder(Enum):
    """An order without data; its value is what the record says.

    PAUSE executes the active state no further until RESUME. REPEAT leaves it and enters it again.
    PREEMPT stops the behavior. SHOW_STRUCTURE has the engine publish the states and their outcomes.
    """

    PAUSE = "pause"
    RESUME = "resume"
    REPEAT = "repeat"
    PREEMPT = "stop"
    SHOW_STRUCTURE = "show structure"

    def __str__(self) -> str:
        return self.value


Order: TypeAlias = (
    Start | Switch | Attach | SetAutonomy | TakeOutcome | Hold | Release | SimpleOrder
)


_SEVERITIES = {0: "info", 1: "warning", 2: "hint", 3: "error", 10: "debug"}


@dataclass(frozen=True)
class LogLine:
    """One line: when [s, wall time], its code in flexbe_msgs/BehaviorLog, and the text."""

    time_s: float
    code: int
    text: str

    @property
    def severity(self) -> str:
        """Return the word for its code."""
        return _SEVERITIES.get(self.code, "info")
