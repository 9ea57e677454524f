"""The behavior engine in one process, and the synthesis of what it runs."""

from __future__ import annotations

import os
from functools import cache
from typing import Any

from flexbe_core.behavior import Behavior
from flexbe_core.engine.definitions import Kind, definitions_below
from flexbe_core.engine.engine import Engine, ErrorPolicy
from flexbe_core.engine.supervision import PREEMPTED, UNSUPERVISED, Entered, Preempt
from flexbe_core.engine.user_data import BehaviorFailure
from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.core.chart.names import behavior_class
from flexbe_synthesizer.core.chart.problem import ChartError
from flexbe_synthesizer.core.compile import Unit, check_units, compile_chart
from flexbe_synthesizer.core.export.layout import lay_out
from flexbe_synthesizer.core.export.render_python import render_python
from flexbe_synthesizer.core.library.signature import Library
from flexbe_synthesizer.edge.package_path import find_packages, read_library
from remodel_rehearsal.ros.cell import CellClock
from remodel_states.line import Line, by_line
from remodel_supervision.errors import CellError
from remodel_supervision.supervisors.ports import BehaviorEnd, EndKind

# Behaviors that are made here belong to no package.
_PACKAGE = "rehearsal_behaviors"


class BehaviorMaker:
    """Makes behaviors of charts, in memory; the supervisor's port."""

    def __init__(self) -> None:
        """Begin without behaviors."""
        self._classes: dict[str, type[Behavior]] = {}
        self._texts: dict[str, str] = {}

    def wait(self, limit_s: float) -> None:
        """It is there."""

    def make(self, chart: Chart) -> None:
        """Have a chart's behavior made, unless it exists with the same content.

        Raises:
            CellError: with every problem of the chart if it is refused.
        """
        xml = write_chart(chart)
        if self._texts.get(chart.name) == xml:
            return
        try:
            self._classes[chart.name] = made(xml, chart.name)
        except ChartError as error:
            raise CellError(f"synthesis of {chart.name} failed: {error}") from error
        self._texts[chart.name] = xml

    def behavior(self, name: str) -> Behavior:
        """Return a new behavior of a name; KeyError if none was made."""
        return self._classes[name]()


def made(xml: str, name: str) -> type[Behavior]:
    """Return the class of the behavior that a chart becomes, as the synthesizer writes it.

    Args:
        xml: text of the chart.
        name: of the chart, for problems.

    Raises:
        ChartError: if the chart has errors.
    """
    chart = parse_chart(xml, f"{name}.xml")
    (checked,) = check_units([Unit(chart, _PACKAGE)], library()).values()
    machine = compile_chart(checked, _PACKAGE)
    text = render_python(machine, lay_out(machine.root), {})
    namespace: dict[str, Any] = {"__name__": f"{_PACKAGE}.{name}"}
    exec(compile(text, f"{name}.py", "exec"), namespace)  # the synthesizer's own text
    found: type[Behavior] = namespace[behavior_class(chart.name)]
    return found


@cache
def library() -> Library:
    """Return the states and behaviors on the ROS package path, read once."""
    packages, _ = find_packages(os.environ.get("ROS_PACKAGE_PATH", ""))
    return read_library(packages)[0]


class LocalEngine:
    """Runs behaviors, one at a time; the supervisor's port, and a part of the loop.

    Attributes:
        state_path: of the state in which the engine is; empty if none is known.
        trouble: none, ever.
    """

    trouble = ""

    def __init__(self, clock: CellClock, maker: BehaviorMaker, line: Line) -> None:
        """Begin idle.

        Args:
            clock: the cell's time.
            maker: has the behaviors.
            line: by which their states reach abilities and supervisor.
        """
        self.state_path = ""
        self._clock, self._maker, self._line = clock, maker, line
        self._engine: Engine | None = None
        self._machine: Any = None
        self._end: BehaviorEnd | None = None
        self._path: list[str] = []

    @property
    def end(self) -> BehaviorEnd | None:
        """How the behavior started last has ended; None while it runs."""
        return self._end

    @property
    def is_idle(self) -> bool:
        """Whether no behavior runs."""
        return self._engine is None

    def wait(self, limit_s: float) -> None:
        """It is there."""

    def start(self, behavior: str) -> None:
        """Have a behavior run, without an operator."""
        found = self._maker.behavior(behavior)
        found.set_up(0, UNSUPERVISED, debug=False, on_error=ErrorPolicy.FAIL)
        with by_line(self._line):
            self._machine = machine = found.create()
        machine._name = behavior
        self._engine = engine = Engine(machine, ErrorPolicy.FAIL, machine.path)
        self._end, self._path = None, []
        for state in self._states():
            state.on_start()
        engine.begin()

    def cancel(self, *, own_only: bool = False) -> None:
        """Have the behavior stopped."""
        if self._engine is not None:
            self._engine.handle(Preempt())

    def path(self) -> tuple[str, ...]:
        """Return the paths of the states that the behavior started last has entered."""
        return tuple(self._path)

    def wake(self) -> None:
        """Execute the active state soon: what it waits for may have arrived."""
        if self._engine is not None:
            self._engine.root.wake()

    def turn(self) -> bool:
        """Execute what is due."""
        engine, now_s = self._engine, self._clock.now_s
        if engine is None or not (engine.supervision.preempt or engine.next_due() <= now_s):
            return False
        try:
            outcome = engine.run(now_s)
        except BehaviorFailure as error:
            self._stop(BehaviorEnd(EndKind.FAILED, str(error)))
            return True
        self._note(engine)
        if outcome == PREEMPTED:
            self._stop(BehaviorEnd(EndKind.PREEMPTED, "preempted"))
        elif outcome is not None:
            self._stop(BehaviorEnd(EndKind.FINISHED, outcome))
        return True

    def next_due_s(self) -> float:
        """Return when a state is due [s]."""
        return float("inf") if self._engine is None else self._engine.next_due()

    def _states(self) -> list[Any]:
        return [d for d in definitions_below(self._machine) if type(d).__kind__ is Kind.STATE]

    def _note(self, engine: Engine) -> None:
        for event in engine.take_events():
            if isinstance(event, Entered):
                self.state_path = event.path
                self._path.append(event.path)

    def _stop(self, end: BehaviorEnd) -> None:
        engine, self._engine = self._engine, None
        assert engine is not None, "it ran"
        engine.stop()
        self._note(engine)
        for state in self._states():
            state.on_stop()
        self._end = end
