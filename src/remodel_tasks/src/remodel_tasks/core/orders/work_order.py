"""What is to be done: the tasks of an order with what they say about themselves, no durations.

docs/use-cases.md describes the form. Lengths are integers in mm, as in core.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

from flexbe_synthesizer.core.chart.names import is_name
from remodel_run.findings import ByHand, OtherMethod
from remodel_run.whole_task import WholeTask, whole_tasks
from remodel_tasks.core.condition import Features, Value, is_number, terminal_features
from remodel_tasks.core.orders.order_format import FORMAT
from remodel_tasks.core.problem.fields import Fields
from remodel_tasks.core.problem.instance import (
    arm_from,
    characteristics_of,
    end_from,
    terminal_from,
)
from remodel_tasks.core.problem.problem import (
    End,
    PlannedArm,
    PlannedTerminal,
    Point,
    SoftConstraint,
    Under,
)

_HASH_DIGITS = 6
_NO_WORD = re.compile(r"\W+", re.ASCII)


def plain_name(name: str) -> str:
    """Return a name in letters, digits and `_`; one that is changed ends in digits of its hash.

    So `24#2` and `24+2` stay apart, in charts and in the files of their behaviors.
    """
    plain = _NO_WORD.sub("_", name)
    if plain == name and is_name(f"the {name}"):
        return name
    return f"{plain}_{hashlib.sha256(name.encode()).hexdigest()[:_HASH_DIGITS]}"


def take_name(name: str, taken: set[str]) -> str:
    """Return the name, with a number if it is taken, and take it.

    Names that differ in capitals alone are one: the files of behaviors have names in lower case.
    """
    found, number = name, 1
    while found.lower() in taken:
        number += 1
        found = f"{name}#{number}"
    taken.add(found.lower())
    return found


# Of the length of a direction, for what rounding leaves.
_UNIT_TOLERANCE = 1e-3


@dataclass(frozen=True)
class RouteClip:
    """A clip, or any place that holds what is routed through it."""

    name: str
    position_mm: Point


@dataclass(frozen=True)
class Route:
    """A course along which something may be routed, from end a to end b.

    Attributes:
        segments: names of the duct segments, which no two arms use at the same time.
    """

    path_mm: tuple[Point, ...]
    clips: tuple[RouteClip, ...] = ()
    segments: tuple[str, ...] = ()

    @cached_property
    def length_m(self) -> float:
        """Its length [m]."""
        return sum(math.dist(a, b) for a, b in pairwise(self.path_mm)) / 1e3

    @property
    def reversed(self) -> Route:
        """The same route from its end to its beginning."""
        return Route(self.path_mm[::-1], self.clips[::-1], self.segments)

    def legs(self) -> tuple[Route, ...]:
        """Return the parts from clip to clip, and the rest after the last clip."""
        legs, rest = [], replace(self, clips=())
        for clip in self.clips:
            leg, rest = rest.split(clip.position_mm)
            legs.append(leg)
        return (*legs, rest)

    def split(self, point: Point) -> tuple[Route, Route]:
        """Return the parts before and after the place of the route that is nearest to a point."""
        leg, place = min(
            ((i, _nearest(a, b, point)) for i, (a, b) in enumerate(pairwise(self.path_mm))),
            key=lambda found: math.dist(found[1], point),
        )
        before = Route((*self.path_mm[: leg + 1], place), (), self.segments)
        after = Route((place, *self.path_mm[leg + 1 :]), (), self.segments)
        nearer = [
            before.distance(c.position_mm) <= after.distance(c.position_mm) for c in self.clips
        ]
        clips = tuple(zip(self.clips, nearer, strict=True))
        return (
            replace(before, clips=tuple(clip for clip, is_before in clips if is_before)),
            replace(after, clips=tuple(clip for clip, is_before in clips if not is_before)),
        )

    def distance(self, point: Point) -> float:
        """Return how far [mm] a point is from the route."""
        return min(math.dist(_nearest(a, b, point), point) for a, b in pairwise(self.path_mm))


def _nearest(a: Point, b: Point, point: Point) -> Point:
    """Return the point of the leg from a to b that is nearest to a point, to the mm."""
    length = math.dist(a, b)
    along = sum((p - q) * (r - q) for p, q, r in zip(point, a, b, strict=True))
    part = min(1.0, max(0.0, along / length**2)) if length else 0.0
    return (round(a[0] + part * (b[0] - a[0])), round(a[1] + part * (b[1] - a[1])))


@dataclass(frozen=True)
class Refusal:
    """Why no robot does a task.

    Attributes:
        kind: what several tasks have in common, such as "shorter than 0.42 m".
        reason: in words.
    """

    kind: str
    reason: str


@dataclass(frozen=True)
class Task:
    """One thing to be placed: a wire, a cable, a branch of a harness, a hose.

    Attributes:
        terminals: names, of end a and of end b.
        slot_mm: where it is picked.
        routes: at least one.
        meeting_mm: where one arm may hand it to the other; None: nowhere.
        first: the end to be inserted first; None: the planner chooses.
        values: for the inputs and parameters of states, such as poses.
        by_hand: why no robot does it; None: one may.
    """

    name: str
    terminals: tuple[str, str]
    slot_mm: Point
    characteristics: dict[str, Value]
    routes: tuple[Route, ...]
    meeting_mm: Point | None = None
    preferred_arm: str | None = None
    first: End | None = None
    values: tuple[tuple[str, object], ...] = ()
    by_hand: Refusal | None = None

    @property
    def cable(self) -> str:
        """The cable, or twisted group, of which it is a core; empty for none."""
        return str(self.characteristics.get("cable") or "")


@dataclass(frozen=True)
class Access:
    """How an end goes into a terminal; what is not known is None.

    Attributes:
        force_limit_n: [N] that an insertion must not exceed.
        clearance_m: [m] around the opening, for the gripper.
        approach: unit vector along which an end goes in, in the component's frame.
        kind: of the terminal, such as the article of its contact; empty if it is not known.
    """

    force_limit_n: float | None = None
    clearance_m: float | None = None
    approach: tuple[float, float, float] | None = None
    kind: str = ""

    @property
    def features(self) -> Features:
        """What an end's success may depend on, as far as it is known."""
        return terminal_features(self.kind, self.approach)


@dataclass(frozen=True)
class WorkOrder:
    """Tasks, and where they are to be done.

    Attributes:
        components: their characteristics, by name.
        access: to terminals, by name.
        by_hand: what the design has besides the tasks.
        other_methods: by which some of the tasks are done.
        outside: the design's wires that leave the plate, and are no tasks.
    """

    name: str
    use_case: str
    arms: tuple[PlannedArm, ...]
    components: dict[str, dict[str, Value]]
    terminals: tuple[PlannedTerminal, ...]
    tasks: tuple[Task, ...]
    unders: tuple[Under, ...] = ()
    soft_constraints: tuple[SoftConstraint, ...] = ()
    access: dict[str, Access] = field(default_factory=dict)
    by_hand: tuple[ByHand, ...] = ()
    other_methods: tuple[OtherMethod, ...] = ()
    outside: tuple[ByHand, ...] = ()

    def with_tasks(self, tasks: Sequence[Task]) -> WorkOrder:
        """Return the order with these tasks alone, and the constraints between them."""
        names = {task.name for task in tasks}
        return replace(
            self,
            tasks=tuple(tasks),
            unders=tuple(under for under in self.unders if {under.before, under.after} <= names),
            soft_constraints=tuple(
                soft for soft in self.soft_constraints if {soft.before, soft.after} <= names
            ),
        )

    @property
    def whole_tasks(self) -> tuple[WholeTask, ...]:
        """The tasks as they are counted: the cores of a cable, or twisted group, are one."""
        return whole_tasks((task.name, task.cable) for task in self.tasks)

    @property
    def wires_by_hand(self) -> frozenset[str]:
        """The names of the wires that no robot places."""
        return frozenset(wire for each in self.by_hand for wire in each.wires)

    @property
    def cables(self) -> dict[str, tuple[str, ...]]:
        """The names of the tasks of each cable, or twisted group, that has several."""
        return {task.name: task.wires for task in self.whole_tasks if task.is_cable}


def order_from(data: object) -> WorkOrder:
    """Build the order that a parsed document describes.

    Raises:
        InstanceError: naming the first field that is missing or malformed.
    """
    fields = Fields(data, "")
    fields.only(
        *("format", "name", "use_case", "arms", "components", "terminals", "tasks"),
        *("under", "soft_before"),
    )
    fields.choice("format", (FORMAT,))
    return WorkOrder(
        fields.text("name"),
        fields.text("use_case"),
        tuple(arm_from(item, item) for item in fields.objects("arms")),
        _components(fields),
        terminals=tuple(terminal_from(item) for item in fields.objects("terminals")),
        tasks=tuple(_task(item) for item in fields.objects("tasks")),
        unders=tuple(
            Under(item.text("before"), item.text("after"), source=item.where)
            for item in (fields.objects("under") if fields.has("under") else ())
        ),
        soft_constraints=tuple(
            SoftConstraint(item.text("before"), item.text("after"), item.number("weight"))
            for item in (fields.objects("soft_before") if fields.has("soft_before") else ())
        ),
        access={item.text("id"): _access(item) for item in fields.objects("terminals")},
    )


def _access(item: Fields) -> Access:
    return Access(
        _amount(item, "force_limit_n"),
        _amount(item, "clearance_m"),
        _direction(item) if item.has("approach") else None,
        item.text("kind") if item.has("kind") else "",
    )


def _amount(item: Fields, key: str) -> float | None:
    if not item.has(key):
        return None
    value = item.value(key)
    if not is_number(value) or not 0 < value < math.inf:
        raise item.fail(key, "a number above 0")
    return float(value)


def _direction(item: Fields) -> tuple[float, float, float]:
    value = item.value("approach")
    is_vector = isinstance(value, list) and len(value) == 3 and all(map(is_number, value))
    if not is_vector or abs(math.hypot(*value) - 1) > _UNIT_TOLERANCE:
        raise item.fail("approach", "three numbers, of a vector of length 1")
    x, y, z = map(float, value)
    return x, y, z


def _components(fields: Fields) -> dict[str, dict[str, Value]]:
    components: dict[str, dict[str, Value]] = {}
    for item in fields.objects("components"):
        item.only("id", "characteristics")
        if item.text("id") in components:
            raise item.fail("id", "a name of its own")
        components[item.text("id")] = dict(characteristics_of(item))
    return components


def _task(item: Fields) -> Task:
    item.only(
        *("id", "a", "b", "slot", "characteristics", "ways", "meeting", "prefer_arm", "first"),
        "values",
    )
    routes = tuple(_route(route) for route in item.objects("ways"))
    if not routes:
        raise item.fail("ways", "at least one route")
    values = item.inner("values") if item.has("values") else None
    return Task(
        item.text("id"),
        (item.text("a"), item.text("b")),
        item.pair("slot"),
        dict(characteristics_of(item)),
        routes=routes,
        meeting_mm=item.pair("meeting") if item.has("meeting") else None,
        preferred_arm=item.text("prefer_arm") if item.has("prefer_arm") else None,
        first=end_from(item, "first") if item.has("first") else None,
        values=tuple((key, values.value(key)) for key in values.keys()) if values else (),  # noqa: SIM118 - not a dict
    )


def _route(item: Fields) -> Route:
    item.only("path", "clips", "segments")
    clips = item.objects("clips") if item.has("clips") else []
    return Route(
        item.pairs("path"),
        tuple(RouteClip(clip.text("id"), clip.pair("at")) for clip in clips),
        item.texts("segments") if item.has("segments") else (),
    )
