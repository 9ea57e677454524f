"""An order, its plan, and charts for the simulated engine."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

from flexbe_synthesizer.core.chart.model import Chart, Outcome, Param, State, Transition
from remodel_production.core.board.board import board_of
from remodel_production.core.board.panel import panel_of as board_panel
from remodel_production.core.production import Component, Order, Side, Terminal, TerminalRef, Wire
from remodel_production.edge.design_files import read_catalogue
from remodel_states.testing.cell_ability import panel_from
from remodel_states.testing.world import Panel
from remodel_supervision.core.learning.experience import Experience
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import Chosen, Decided, Part
from remodel_supervision.edge.work_planner import WorkPlanner
from remodel_supervision.ros.peers.board_message import board_message
from remodel_tasks.core.orders.board_order import board_order, kind_of
from remodel_tasks.core.orders.work_order import WorkOrder
from remodel_tasks.core.problem.problem import End
from remodel_tasks.core.task_charts.planned_tasks import Demands, PlannedTask
from remodel_tasks.core.use_case.fault import Do, FaultTable, Limits, Policy
from remodel_tasks.edge.fault_file import read_faults
from remodel_tasks.edge.use_case_files import use_case_for

WIRES = 5
ORDER = Order(
    "house",
    "",
    "house.qet",
    (
        Component("Q1", "fuse", tuple(Terminal(f"B{n}", Side.BOTTOM) for n in range(1, WIRES + 1))),
        Component("Q2", "relay", tuple(Terminal(f"T{n}", Side.TOP) for n in range(1, WIRES + 1))),
    ),
    wires=tuple(
        Wire(
            f"W{n}",
            TerminalRef("Q1", f"B{n}"),
            TerminalRef("Q2", f"T{n}"),
            "BU",
            section_mm2=1.5,
            source=f"{n}",
        )
        for n in range(1, WIRES + 1)
    ),
)
_CATALOGUE = Path(__file__).parents[3] / "remodel_production" / "config" / "catalogue.yaml"


@dataclass(frozen=True)
class Plant:
    """What all schedules share.

    Attributes:
        order: with all tasks.
        tasks: as the real planner plans them, by name.
    """

    panel: Panel
    order: WorkOrder
    tasks: dict[str, PlannedTask]
    faults: FaultTable


@cache
def plant() -> Plant:
    catalogue = read_catalogue(_CATALOGUE)
    board = board_of(ORDER, catalogue)
    use_case = use_case_for(kind_of(board))
    order = board_order(board, use_case, arms=1)
    real = WorkPlanner(order, use_case, Experience(use_case, ()), 0.0)
    names = real.plan([task.name for task in order.tasks])
    return Plant(
        panel_from(board_message(board_panel(board, catalogue), order)),
        order,
        {name: real.task(name) for name in names},
        read_faults(),
    )


class _NoExperience:
    """Nothing was learned."""

    def unpromising(self, *_: object) -> tuple[Do, ...]:
        return ()


@dataclass(frozen=True)
class _UseCase:
    name: str
    recovery: Policy


class SimulatedPlanner:
    """Plans the first tasks of the order."""

    experience = _NoExperience()
    demands = Demands()

    def __init__(self, count: int, question_timeout_s: float) -> None:
        order = plant().order
        self.order = replace(order, tasks=order.tasks[:count])
        limits = Limits(run_s=1e6)
        question = replace(Policy().question, timeout_s=question_timeout_s)
        recovery = Policy(limits=limits, question=question)
        self.use_case = _UseCase(order.use_case, recovery)

    def plan(self, names: Collection[str], *_: object) -> tuple[str, ...]:
        return tuple(sorted(names))

    def task(
        self, name: str, decisions: Sequence[Decided] = (), connected: Collection[str] = ()
    ) -> PlannedTask:
        return plant().tasks[name]

    def expected_s(self, name: str) -> float:
        return 20.0

    def has_other_method(self, name: str, decisions: Sequence[Decided], state_path: str) -> bool:
        """Return whether a step can be done otherwise: one of each task can, once."""
        return all(decision.do is not Do.OTHER_METHOD for decision in decisions)

    def has_other_end(self, name: str, decisions: Sequence[Decided]) -> bool:
        """Return whether the other end may come first: of each task, once."""
        return all(decision.do is not Do.OTHER_END for decision in decisions)

    def learn(self, name: str, operation: Operation) -> None:
        """Learn nothing."""

    def choose(self, name: str, decisions: Sequence[Decided], seed: str) -> tuple[Chosen, ...]:
        return ()

    def chart(
        self,
        name: str,
        part: Part,
        connected: Collection[str],
        decisions: Sequence[Decided],
        chosen: Sequence[Chosen] = (),
    ) -> Chart:
        view, force_n = 0, 10.0
        for decision in decisions:
            changes = dict(decision.change)
            view += decision.do is Do.LOOK_AGAIN
            force_n = float(changes.get("force_limit", force_n))
        is_rest = part is Part.REST
        return _chart(
            name, part, tuple(sorted(connected)) if is_rest else (), view, force_n=force_n
        )


@cache
def _chart(name: str, part: Part, connected: tuple[str, ...], view: int, force_n: float) -> Chart:
    title = f"Place Wire {name}"
    if part is Part.CLEAR:
        return _sequence(f"{title} Clear", [("Lay down", "PlaceCable", {})])
    if part is Part.DISCARD:
        return _sequence(f"{title} Discard", [("Discard", "DiscardCable", {"cable_id": name})])
    suffix = " Rest" if part is Part.REST else ""
    steps = [("Find wire", "DetectCable", {"cable_id": name, "view": view})]
    for letter in _ends_left(name, connected):
        steps += list(_connecting(name, letter, view, force_n))
    return _sequence(f"{title}{suffix}", steps, name)


def _ends_left(name: str, connected: tuple[str, ...]) -> tuple[str, ...]:
    letters = []
    for step in plant().tasks[name].left(connected):
        if step.end is not None and step.end.letter not in letters:
            letters.append(step.end.letter)
    return tuple(letters)


def _connecting(
    name: str, letter: str, view: int, force_n: float
) -> Iterator[tuple[str, str, dict[str, object]]]:
    planned = plant().tasks[name]
    task = planned.decomposition.task
    terminal = next(task.terminals[end] for end in End if end.letter == letter)
    component = planned.component_of[terminal]
    where = {"component_id": component, "terminal_id": terminal.removeprefix(f"{component}:")}
    wire = {"cable_id": name, "cable_end": letter}
    yield f"Locate {letter}", "LocateGearboxComponent", {**where, "view": view}
    yield f"Pick {letter}", "PickCable", wire
    yield f"Insert {letter}", "InsertCable", {**wire, **where, "force_limit": force_n}
    yield f"Fix {letter}", "FixCable", {"cable_id": name, **where}


def _sequence(
    title: str, steps: Sequence[tuple[str, str, dict[str, object]]], wire: str = ""
) -> Chart:
    """Return a chart of states in a row; once something may be held, failures lay it down."""
    nodes, up = [], "failed"
    for number, (name, ability, values) in enumerate(steps):
        up = "Lay down" if wire and ability == "PickCable" else up
        following = steps[number + 1][0] if number + 1 < len(steps) else "finished"
        tries = 2 if ability == "InsertCable" else None
        targets = {"done": following, "failed": name if tries else up, "command_error": up}
        targets |= {"exhausted": up} if tries else {}
        nodes.append(_state(name, ability, values, targets, tries=tries))
    if up == "Lay down" and wire:
        ended = dict.fromkeys(("done", "failed", "command_error"), "failed")
        nodes.append(_state("Lay down", "PlaceCable", {"cable_id": wire}, ended, tries=None))
    outcomes = (Outcome("finished"), Outcome("failed"))
    return Chart(title, nodes[0].id, outcomes, tuple(nodes))


def _state(
    name: str, ability: str, values: dict[str, object], targets: dict[str, str], tries: int | None
) -> State:
    return State(
        name,
        ability,
        tuple(Transition(event, target) for event, target in targets.items()),
        params=tuple(Param(key, value) for key, value in values.items()),  # type: ignore[arg-type]
        attempts=tries,
    )


def panel_of(serial: str) -> Panel:
    return replace(plant().panel, serial=serial)
