"""What the engine reports, in terms of the chart: of its states and their events.

Synthesis adds states to those of the chart: one that counts the attempts at a state (`X_attempts`),
one that parts its failures by code (`X_error`), and a container that keeps its time, with the state
as `run` and a timer beside it. An operator drew none of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto

from flexbe_synthesizer.core.chart.names import EXHAUSTED, FAILED, TIMED_OUT
from flexbe_synthesizer.core.machine.expanded_labels import (
    OTHER,
    RUN,
    TIMER,
    chooser_label,
    counter_label,
)
from remodel_console.core.editor.drawing import drawn_path
from remodel_console.core.run.structure import Structure

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
