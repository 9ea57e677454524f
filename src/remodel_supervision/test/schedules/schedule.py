"""One schedule, from its seed to its verdict."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import select

from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart
from remodel_production.edge.database.production_models import RunRow, TaskRow, WireRow
from remodel_supervision.core.runs.event_table import attempts_of
from remodel_supervision.core.runs.events import Event
from remodel_supervision.core.runs.replay import path_difference, replayed
from remodel_supervision.core.runs.state import RunState, Stage
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.supervisors import task_executor
from schedules.database import Memory
from schedules.disturbances import CALM_AFTER_S, Disturbances
from schedules.invariants import Invariants
from schedules.life import Setting
from schedules.people import People
from schedules.planner import ORDER, plant
from schedules.simulation import Simulation, ViolationError
from schedules.site import Site
from schedules.station import Station

# [s] that everything gets to be done once nothing goes wrong any more.
_LIMIT_S = 1500.0

_KEPT = {"done": Stage.DONE, "set aside": Stage.SET_ASIDE}


@dataclass(frozen=True)
class Verdict:
    """How a schedule ended.

    Attributes:
        violation: what did not hold; empty if everything did.
        trace: what happened, if that was kept.
        took_s: [s] simulated.
        events: of all runs.
    """

    seed: int
    violation: str
    trace: tuple[str, ...]
    took_s: float
    events: int


class _Charts:
    """Writes each chart once, and knows which chart a text is."""

    def __init__(self) -> None:
        self._texts: dict[int, tuple[Chart, str]] = {}
        self.of: dict[str, Chart] = {}

    def write(self, chart: Chart) -> str:
        known = self._texts.get(id(chart))
        if known is None:
            known = self._texts[id(chart)] = chart, write_chart(chart)
            self.of[known[1]] = chart
        return known[1]


class Schedules:
    """Runs schedules, one after the other."""

    def __init__(self) -> None:
        plant()
        self._memory = Memory(ORDER)
        self._charts = _Charts()
        task_executor.write_chart = self._charts.write

    def run(self, seed: int, *, tracing: bool = False) -> Verdict:
        simulation = Simulation(seed, tracing=tracing)
        self._memory.restore(simulation)
        violation = ""
        try:
            self._run(simulation)
        except ViolationError as error:
            violation = str(error)
        with self._memory.door.reading() as connection:
            events = sum(connection.scalars(select(RunRow.events)))
        return Verdict(seed, violation, tuple(simulation.trace), simulation.now_s, events=events)

    def _run(self, simulation: Simulation) -> None:
        random = simulation.random
        count = random.randint(2, 5)
        setting = Setting(
            count,
            random.random() < 0.7,
            random.choice((0.0, 20.0)),
            random.choice((30.0, 120.0)),
        )
        site = Site(simulation, plant().panel)
        invariants = Invariants(simulation, site, RunLog(self._memory.door))
        cells = random.choice((("cell",),) * 5 + (("cell", "other"),) * 3 + (("cell", "cell"),))
        stations = [
            Station(
                simulation,
                site,
                self._memory,
                setting,
                invariants=invariants,
                name=f"station{n}",
                cell=cell,
            )
            for n, cell in enumerate(cells, 1)
        ]
        calm_s = CALM_AFTER_S * count
        again_s = random.uniform(0.0, calm_s) if random.random() < 0.15 else None
        people = People(
            simulation, site, stations, invariants, count=count, calm_s=calm_s, again_s=again_s
        )
        disturbances = Disturbances(simulation, site, self._memory, stations, people=people)
        disturbances.draw(random.randint(0, 8), calm_s)
        simulation.at(calm_s, self._calm, simulation)
        if not simulation.run(calm_s + _LIMIT_S, lambda: people.is_done):
            doing = [
                f"{s.name}: {s.supervisor.doing if s.supervisor else 'no run'}" for s in stations
            ]
            simulation.violated(f"nothing ends: {'; '.join(doing)}")
            raise simulation.violation  # type: ignore[misc]
        self._check(simulation, invariants, site)
        if simulation.violation is not None:
            raise simulation.violation

    def _calm(self, simulation: Simulation) -> None:
        simulation.note("schedule", "nothing goes wrong from now on")
        self._memory.lost_answers = 0
        simulation.duplicates = 0.0

    # --- at the end

    def _check(self, simulation: Simulation, invariants: Invariants, site: Site) -> None:
        log = RunLog(self._memory.door)
        for head in log.heads():
            events = [kept.event for kept in log.events(head.number)]
            state = self._check_replay(simulation, head.number, events)
            if state != invariants.states.get(head.number):
                simulation.violated(f"run {head.number}: the log is not what its supervisor knew")
            if not head.ended or state.ended is None:
                simulation.violated(f"run {head.number} has no end")
        with self._memory.door.reading() as connection:
            rows = connection.execute(
                select(WireRow.name, TaskRow.state).join(TaskRow, TaskRow.wire_id == WireRow.id)
            ).all()
        latest = invariants.states[max(invariants.states)]
        done = {
            name
            for state in invariants.states.values()
            if state.serial == latest.serial
            for name in state.in_stage(Stage.DONE)
        }
        for name, kept in rows:
            if name in latest.tasks:
                self._check_task(simulation, latest, site, name, kept=kept, done=done)

    def _check_replay(self, simulation: Simulation, run: int, events: list[Event]) -> RunState:
        """Check that the events of a run follow from each other; return the state after them."""
        state = RunState()
        for number, frame in enumerate(replayed(events)):
            if frame.differs:
                simulation.violated(
                    f"run {run}, event {number} does not replay: {frame.differs}: {frame.event}"
                )
            state = frame.after
        for attempt in attempts_of(events):
            difference = path_difference(attempt, self._charts.of[attempt.chart], {}, {})
            if difference:
                simulation.violated(f"run {run}: {attempt.execution.behavior}: {difference}")
        return state

    @staticmethod
    def _check_task(
        simulation: Simulation,
        latest: RunState,
        site: Site,
        name: str,
        kept: str,
        done: set[str],
    ) -> None:
        task = latest.tasks[name]
        # What a run of another cell has done stays done, whatever this one has skipped.
        stage = Stage.DONE if name in done else task.stage
        if _KEPT.get(kept) is not stage:
            simulation.violated(f"{name} is {task.stage.value} by the log, {kept} by its table")
        if not site.world.is_placed(name):
            simulation.violated(f"{name} is {task.stage.value}, and not placed")
