"""A harness as an order of its branches: the trunk, the branches that leave it, their connectors.

Of each connected part, the trunk and the branches are the limbs of
remodel_production/core/board/formboard.py. A connector that sits beside a limb, or shares its end
with another one, has a branch of its own. A branch is joined already where it leaves its parent,
which is led before it. What is stated, if the use case has a characteristic for it: `part` (trunk,
branch) and `level` of a task; `kind` (connector, root), `role` and `part_number` of a component.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

from remodel_production.core.board.board import Board
from remodel_production.core.board.formboard import Limb, limbs
from remodel_production.core.board.formboard import Point as PointM
from remodel_production.core.imports.assembly import unique_name
from remodel_production.core.production import Clip, Component, Segment
from remodel_production.errors import OrderError
from remodel_tasks.core.condition import Value
from remodel_tasks.core.orders.work_order import Route, RouteClip, Task, WorkOrder, take_name
from remodel_tasks.core.problem.problem import End, PlannedArm, PlannedTerminal, Point, Under
from remodel_tasks.core.use_case.model import Designs, UseCase, declared


class Surroundings:
    """What a use case states of its cell, around the points that the arms must reach."""

    def __init__(self, points: Iterable[Point], designs: Designs, arms: int) -> None:
        """Take the points, and how many arms there are at most: 1 or 2."""
        points = list(points)
        self.left, self.right = min(x for x, _ in points), max(x for x, _ in points)
        low = min(y for _, y in points)
        self.slot_y = low - round(1e3 * designs.magazine_below_m)
        self._home_y = low - round(1e3 * designs.home_below_m)
        self.arms = self._placed(designs, min(arms, len(designs.arms)))

    def _placed(self, designs: Designs, count: int) -> tuple[PlannedArm, ...]:
        beside, beyond = (
            round(1e3 * length) for length in (designs.station_beside_m, designs.reach_beyond_m)
        )
        left, right = self.left, self.right
        sides = [(left, left - beside, (left - beyond, right + beyond))]
        if count == 2:
            reach = round((right - left) * designs.reach_of_two)
            sides = [
                (left, left - beside, (left - beyond, left + reach)),
                (right, right + beside, (right - reach, right + beyond)),
            ]
        return tuple(
            PlannedArm(
                name,
                (station, self.slot_y),
                reach,
                (home, self._home_y),
                tool=designs.tool,
                holding=None,
            )
            for name, (home, station, reach) in zip(designs.arms, sides, strict=False)
        )

    def able(self, *xs: int) -> tuple[PlannedArm, ...]:
        """Return the arms that reach all of some x."""
        return tuple(
            arm for arm in self.arms if arm.reach_mm[0] <= min(xs) and max(xs) <= arm.reach_mm[1]
        )

    def nearer(self, *xs: int) -> PlannedArm | None:
        """Return the arm on whose side the middle of some x is; None where there is one arm."""
        if len(self.arms) == 1:
            return None
        return self.arms[2 * sum(xs) >= len(xs) * (self.left + self.right)]

    def meeting(self, path: tuple[Point, ...]) -> Point:
        """Return where a route first crosses the middle of the board, or comes nearest to it."""
        middle = (self.left + self.right) / 2
        crossing = (
            (p, q) for p, q in pairwise(path) if min(p[0], q[0]) <= middle <= max(p[0], q[0])
        )
        p, q = next(crossing, (None, None))
        if p is None or q is None:
            return min(path, key=lambda point: abs(point[0] - middle))
        share = 0.0 if p[0] == q[0] else (middle - p[0]) / (q[0] - p[0])
        return round(middle), round(p[1] + share * (q[1] - p[1]))


def in_mm(point: PointM) -> Point:
    """Return a point of a board [m] in mm."""
    return round(1e3 * point[0]), round(1e3 * point[1])


def route_on(
    board: Board, path: tuple[Point, ...], clips: Iterable[Clip], segments: Iterable[str]
) -> Route:
    """Return a route [mm] with the places of its clips, and each of its segments once."""
    held = tuple(RouteClip(clip.name, in_mm(board.clips[clip.name])) for clip in clips)
    return Route(path, held, tuple(sorted(set(segments))))


def said_of(component: Component) -> dict[str, Value]:
    """Return what a design says of a component that a use case may have a characteristic for."""
    return {"role": component.role.value, "part_number": component.part_number}


_TRUNK, _BRANCH = "trunk", "branch"
_CONNECTOR, _ROOT = "connector", "root"


def branch_order(board: Board, use_case: UseCase, designs: Designs, arms: int) -> WorkOrder:
    """Return the order that mounts a harness with one or two arms.

    Raises:
        OrderError: if the board has no harness with branches, or a connector is at none of them.
    """
    order = board.order
    nodes = {node for segment in order.segments for node in (segment.start, segment.end)}
    loose = [component.name for component in order.components if component.node not in nodes]
    if board.is_cabinet or not order.segments:
        raise OrderError(
            f"use case {use_case.name} mounts the branches of harnesses, and order {order.name} "
            "has no segments that say them; choose another one by --use-case"
        )
    if loose:
        raise OrderError(
            f"order {order.name}: {', '.join(loose)} sit at no node of the harness's segments, and "
            f"use case {use_case.name} cannot know on which branch: give them nodes in the design"
        )
    ends = [point for line in board.lines.values() for point in line]
    points = map(in_mm, (*ends, *(device.centre for device in board.devices)))
    return _Mounting(board, use_case, Surroundings(points, designs, arms)).order()


@dataclass(frozen=True)
class _Branch:
    """A limb or a connector beside one.

    Attributes:
        nodes: along it, from its root.
        first: the connector at its beginning; empty for a fork.
        last: the connector at its end; empty for a free end.
        parent: name of the branch that it leaves; empty for a trunk.
    """

    name: str
    nodes: tuple[str, ...]
    first: str
    last: str
    parent: str
    level: int


class _Mounting:
    """Makes the order of the branches of one harness."""

    def __init__(self, board: Board, use_case: UseCase, surroundings: Surroundings) -> None:
        self._board = board
        self._use_case = use_case
        self._around = surroundings
        self._component = {component.name: component for component in board.order.components}
        self._centre = {d.component.name: in_mm(d.centre) for d in board.devices}
        self._segment: dict[tuple[str, str], tuple[Segment, bool]] = {}
        self._place: dict[str, Point] = {}
        for segment in board.order.segments:
            self._segment.setdefault((segment.start, segment.end), (segment, True))
            self._segment.setdefault((segment.end, segment.start), (segment, False))
            for node, point in zip(
                (segment.start, segment.end), board.lines[segment.name], strict=True
            ):
                self._place[node] = in_mm(point)
        self._components: dict[str, dict[str, Value]] = {}
        self._terminals: list[PlannedTerminal] = []

    def order(self) -> WorkOrder:
        branches = self._branches()
        tasks = tuple(self._task(branch) for branch in branches)
        return WorkOrder(
            name=self._board.order.name,
            use_case=self._use_case.name,
            arms=self._around.arms,
            components=self._components,
            terminals=tuple(self._terminals),
            tasks=tasks,
            unders=tuple(Under(b.parent, b.name) for b in branches if b.parent),
        )

    def _branches(self) -> list[_Branch]:
        order = self._board.order
        waiting: dict[str, list[str]] = {}
        for component in order.components:
            waiting.setdefault(component.node, []).append(component.name)
        branches: list[_Branch] = []
        taken: set[str] = set()

        def add(base: str, ends: tuple[str, str], limb: Limb) -> None:
            name = take_name(base, taken)
            parent = names[limb.parent] if limb.parent is not None else ""
            branches.append(_Branch(name, limb.nodes, *ends, parent, limb.level))

        names: list[str] = []
        found = limbs([node.name for node in order.nodes], order.segments)
        for limb in found:
            at_start = waiting.get(limb.nodes[0], []) if limb.parent is None else []
            first = at_start.pop(0) if at_start else ""
            at_end = waiting.get(limb.nodes[-1], [])
            last = at_end.pop(0) if at_end else ""
            base = _TRUNK if limb.parent is None else last or limb.nodes[-1]
            add(base, (first, last), limb)
            names.append(branches[-1].name)
        for number, limb in enumerate(found):
            for node in limb.nodes:
                for connector in waiting.pop(node, []):
                    add(connector, ("", connector), Limb((node,), limb.level + 1, number))
        return branches

    def _task(self, branch: _Branch) -> Task:
        begin = self._end(branch, branch.first, branch.nodes[0], "begin")
        end = self._end(branch, branch.last, branch.nodes[-1], "end")
        routes = [self._segment[pair] for pair in pairwise(branch.nodes)]
        clips = self._board.order.clips_along(routes)
        if branch.parent:
            # What holds the harness at a fork is the parent's.
            clips = tuple(clip for clip in clips if clip.node != branch.nodes[0])
        path = (begin.position_mm, *(self._place[node] for node in branch.nodes), end.position_mm)
        said: dict[str, Value] = {
            "part": _BRANCH if branch.parent else _TRUNK,
            "level": branch.level,
        }
        x, y = path[0]
        return Task(
            name=branch.name,
            terminals=(begin.name, end.name),
            slot_mm=(x, y if branch.parent else self._around.slot_y),
            characteristics=declared(said, self._use_case.task_characteristics),
            routes=(route_on(self._board, path, clips, (segment.name for segment, _ in routes)),),
            first=End.A,
        )

    def _end(self, branch: _Branch, connector: str, node: str, what: str) -> PlannedTerminal:
        """Add an end of a branch, with the connector there, or with the fork or the free end."""
        component = self._component.get(connector)
        said: dict[str, Value] = {"kind": _ROOT}
        name, position = f"{branch.name} {what}", self._place[node]
        if component is not None:
            name, position = component.name, self._centre[connector]
            said = {"kind": _CONNECTOR, **said_of(component)}
        name = unique_name(name, self._components)
        self._components[name] = declared(said, self._use_case.component_characteristics)
        terminal = PlannedTerminal(f"{name}:{branch.name}", name, position)
        self._terminals.append(terminal)
        return terminal
