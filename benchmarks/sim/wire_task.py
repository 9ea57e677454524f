"""The task of one wire as its charts run it, without ROS: Place Wire, and in it Place Connector."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from flexbe_synthesizer.core.chart.error_routes import codes_of_routes
from flexbe_synthesizer.core.chart.model import Chart, State
from remodel_skills.abilities.ability import Goal
from remodel_skills.abilities.extracting import ExtractGoal, extract_cable
from remodel_skills.abilities.inserting import (
    ConnectGoal,
    FixGoal,
    InsertGoal,
    fix_cable,
    insert_cable,
)
from remodel_skills.abilities.inserting import place_connector as mate_connector
from remodel_skills.abilities.inspection import LocateGoal, locate_gearbox_component
from remodel_skills.abilities.picking import DetectGoal, PickGoal, detect_cable, pick_cable
from remodel_skills.abilities.route_wire import RouteGoal, route_wire
from remodel_skills.cell import Cell
from remodel_skills.robot_context import RobotContext, Steps
from remodel_supervision.edge.known_behaviors import nested_charts
from remodel_tasks.edge.fault_file import read_error_names
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, PanelWire, WireEnd

ROBOT = "robot_1"

G = TypeVar("G", bound=Goal)
T = TypeVar("T")

# How often an observation is tried, as in charts of tasks.
ATTEMPTS = 3
FINISHED = "finished"
# What the states of the charts ask for when the chart says nothing [N].
FORCE_LIMIT_N = 8.0
PULL_TEST_N = 5.0
MATING_LIMIT_N = 30.0
# End b is carried to beside its terminal: so far beyond it along the channel, and so high [m].
BESIDE_M = 0.030
CARRY_Z_M = 0.040


EXHAUSTED, FAILED, REFUSED = "exhausted", "failed", "command_error"
# What a state returns: FAILED or REFUSED with the error code, else the empty event of success.
Perform = Callable[[State], tuple[str, int]]


class ChartRun:
    """One run of a chart; time limits are left to the abilities.

    Attributes:
        visits: how often each state was entered.
    """

    def __init__(self, chart: Chart, error_names: Mapping[str, tuple[int, ...]]) -> None:
        self._chart = chart
        self._error_names = error_names
        self.visits: Counter[str] = Counter()

    def run(self, perform: Perform) -> str:
        """Return the outcome with which the chart ends."""
        nodes = {node.id: node for node in self._chart.nodes}
        current = self._chart.initial
        while current in nodes:
            node = nodes[current]
            if not isinstance(node, State):
                raise TypeError(f"{current} is no state")
            current = self._after(node, perform)
        return current

    def _after(self, node: State, perform: Perform) -> str:
        """Return where a visit to a state leads."""
        targets = {transition.event: transition.target for transition in node.transitions}
        if node.attempts is not None and self.visits[node.id] >= node.attempts:
            return targets[EXHAUSTED]
        self.visits[node.id] += 1
        event, code = perform(node)
        if not event:
            return next(t for e, t in targets.items() if e not in (EXHAUSTED, FAILED, REFUSED))
        if event == FAILED:
            routed = codes_of_routes(node.on_error, self._error_names)
            for route, codes in zip(node.on_error, routed, strict=True):
                if code in codes:
                    return route.target
        return targets[event]


def connector_run() -> ChartRun:
    """Return a run of Place Connector (Figure 3 of Deliverable 5.1) by the chart that ships."""
    return ChartRun(nested_charts()["Place Connector"], read_error_names())


class RejectedError(AbilityError):
    """The cell does not take a goal as it is now: what a chart calls command_error."""


@dataclass
class History:
    """What happened to the ends of a wire.

    Attributes:
        attempts: at connecting each end, as many as were made.
        failures: what went wrong on the way, whether it was mended or not.
    """

    attempts: dict[WireEnd, int] = field(default_factory=dict)
    failures: list[AbilityError] = field(default_factory=list)


def do(cell: Cell, ability: Callable[[RobotContext, G], Steps[T]], goal: G) -> T:
    """Check a goal and run it; raises AbilityError, RejectedError before anything has moved."""
    try:
        goal.check(cell.context.panel, cell.context.belief, cell.context.parameters)
    except AbilityError as error:
        raise RejectedError(error.code, str(error), **error.found) from error
    return cell.run(ability(cell.context, goal))


def channel_of(cell: Cell, wire: PanelWire) -> str:
    """Return the channel in front of end a's terminal, where the wire is laid."""
    panel = cell.context.panel
    return panel.channel_in_front_of(panel.panel_from_socket(*wire.goes_to(WireEnd.A)).position).id


def locate(cell: Cell, component: str, terminal: str) -> Pose:
    """Return the opening of a terminal as the cameras see it, in the world."""
    found = do(cell, locate_gearbox_component, LocateGoal(component, terminal))
    assert found.socket_pose is not None, "a terminal was asked for"
    return found.socket_pose


def locate_again(cell: Cell, component: str, terminal: str) -> Pose:
    """Return the opening of a terminal as `locate`, with up to three attempts as in charts."""
    return _again(History(), lambda: locate(cell, component, terminal))


def route(cell: Cell, wire: PanelWire, path: tuple[Pose, ...]) -> None:
    """Carry the held end along a path, or lay the wire into the clips on it."""
    do(cell, route_wire, RouteGoal(ROBOT, wire.id, path))


def insert(
    cell: Cell,
    wire: PanelWire,
    end: WireEnd,
    terminal: tuple[str, str],
    socket: Pose,
    force_limit: float = FORCE_LIMIT_N,
) -> None:
    """Push an end into a terminal, with at most so much force [N]."""
    goal = InsertGoal(ROBOT, wire.id, end, *terminal, socket, force_limit)
    do(cell, insert_cable, goal)


def place_connector(cell: Cell, wire: PanelWire, header: tuple[str, str], socket: Pose) -> None:
    """Push the connector at end a into a header."""
    connector = wire.connector_at(WireEnd.A)
    assert connector is not None, "the wire has one"
    fields = (ROBOT, connector.id, wire.id, *header, socket, MATING_LIMIT_N)
    do(cell, mate_connector, ConnectGoal(*fields))


def pick(cell: Cell, wire: PanelWire, end: WireEnd) -> None:
    """Grasp an end."""
    do(cell, pick_cable, PickGoal(ROBOT, wire.id, end, 0.0))


def connect(cell: Cell, wire: PanelWire, end: WireEnd, history: History) -> None:
    """Place an end by running the chart Place Connector; raises the last failure if it fails."""
    terminal = wire.goes_to(end)
    run = connector_run()
    sockets: list[Pose] = []
    failures: list[AbilityError] = []

    def act(state: State) -> None:
        if state.type == "LocateGearboxComponentState":
            sockets.append(locate(cell, *terminal))
        elif state.type == "InsertCableState":
            insert(cell, wire, end, terminal, sockets[-1])
        elif state.type == "FixCableState":
            do(cell, fix_cable, FixGoal(ROBOT, wire.id, *terminal, PULL_TEST_N))
        elif state.type == "ExtractCableState":
            goal = ExtractGoal(ROBOT, wire.id, *terminal, sockets[-1])
            do(cell, extract_cable, goal)
        else:
            raise KeyError(f"{state.id} is of type {state.type}, which the cell cannot run")

    def perform(state: State) -> tuple[str, int]:
        try:
            act(state)
        except AbilityError as error:
            failures.append(error)
            is_refused = isinstance(error, RejectedError)
            return REFUSED if is_refused else FAILED, error.code
        return "", 0

    outcome = run.run(perform)
    history.attempts[end] = run.visits["InsertCable"]
    last = failures.pop() if outcome != FINISHED else None
    history.failures += failures
    if last is not None:
        raise last


def place(cell: Cell, wire: PanelWire, history: History) -> None:
    """Feed a wire and place it as its chart does; raises what ended it."""
    cell.feed(wire.id, channel_of(cell, wire))
    _again(history, lambda: do(cell, detect_cable, DetectGoal(wire.id)))
    connect(cell, wire, WireEnd.A, history)
    _again(history, lambda: carry(cell, wire))
    connect(cell, wire, WireEnd.B, history)


def carry(cell: Cell, wire: PanelWire) -> None:
    """Pick end b and route it along its channel to beside its terminal."""
    pick(cell, wire, WireEnd.B)
    panel, belief = cell.context.panel, cell.context.belief
    assert belief.feed is not None, "a wire was picked"
    direction = belief.feed.direction
    lane = float(BOARD.position[0]) + panel.channel(channel_of(cell, wire)).x
    opening = BOARD @ panel.panel_from_socket(*wire.goes_to(WireEnd.B))
    beside = float(opening.position[1]) + BESIDE_M * direction
    target = Pose.level(lane, beside, CARRY_Z_M, direction * math.pi / 2)
    route(cell, wire, (target,))


def _again(history: History, work: Callable[[], T]) -> T:
    """Do something until it succeeds, at most three times; a rejected goal is not tried again."""
    for _ in range(ATTEMPTS - 1):
        try:
            return work()
        except RejectedError:
            raise
        except AbilityError as error:
            history.failures.append(error)
    return work()
