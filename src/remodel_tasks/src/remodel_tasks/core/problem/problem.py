"""The wiring of one panel by one or two arms, as a planning problem.

Lengths are integers in mm, times integers in ticks of 0.1 s, so that costs are exact and equal on
every machine. A wire is picked from its slot in the magazine, one end is inserted, the wire is
routed through ducts to the other terminal, that end is inserted and fixed. docs/planning.md lists
what each action needs.

Here too: which unfinished wire must be done before which (`wire_order`), and the modes of a wire,
that is, which arm starts, with which end, and whether it hands over (`possible_modes`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum, IntEnum
from functools import cached_property
from itertools import combinations, product

Point = tuple[int, int]
Characteristic = str | float | bool

TICKS_PER_S = 10


class End(IntEnum):
    """An end of a wire."""

    A = 0
    B = 1

    @property
    def other(self) -> End:
        """The opposite end."""
        return End(1 - self)

    @property
    def letter(self) -> str:
        """The end as files write it."""
        return "ab"[self]


class Stage(IntEnum):
    """How far a wire is, in the order in which a wire passes through."""

    STORED = 0  # in the magazine
    HELD = 1  # in an arm's hand, no end inserted
    FIRST_IN = 2
    HALF = 3  # routed to its handover point
    GIVEN = 4  # handed over
    ROUTED = 5
    SECOND_IN = 6
    FIXED = 7


@dataclass(frozen=True)
class PlannedArm:
    """An arm, and what it is doing when planning begins.

    Attributes:
        station_mm: where its tool is changed.
        reach_mm: the least and the greatest x of its working positions.
        limited_by: names of the requirements that have made its reach smaller.
    """

    name: str
    station_mm: Point
    reach_mm: tuple[int, int]
    position_mm: Point
    tool: str
    holding: str | None
    limited_by: tuple[str, ...] = ()

    def reaches(self, point: Point) -> bool:
        """Return whether the arm can work at a position."""
        return self.reach_mm[0] <= point[0] <= self.reach_mm[1]


@dataclass(frozen=True)
class PlannedTerminal:
    """A clamp of a component that takes one wire end."""

    name: str
    component: str
    position_mm: Point


@dataclass(frozen=True)
class Handover:
    """Where a wire may pass from one arm to the other, and the routing to there from each end."""

    position_mm: Point
    route_ticks: tuple[int, int]


@dataclass(frozen=True)
class Handling:
    """What a wire's own picking, inserting and fixing take [ticks].

    Attributes:
        insert_ticks: of end a and of end b.
    """

    pick_ticks: int
    insert_ticks: tuple[int, int]
    fix_ticks: int


@dataclass(frozen=True)
class Detour:
    """Another route for a wire, for where its own one is forbidden."""

    segments: tuple[str, ...]
    route_ticks: int
    handover: Handover | None = None


@dataclass(frozen=True)
class PlannedWire:
    """A wire to be placed, and how far it is when planning begins.

    Attributes:
        terminals: names, of end a and of end b.
        heavy: its gauge is laid before light ones.
        zone: 0 (left) to 3 (right); work proceeds to the right.
        insert_ticks: of each end.
        first: the end inserted first, once that is decided.
        jammed: the end whose insertion failed; it must be extracted.
        handling: its own durations, where they are not those of all wires.
        detours: other routes, the best one first.
        cable: of which it is a core, or a twisted group; empty for none.
        insert_force_n: [N] with which an end is pushed in, the greater of both; None: unknown.
        characteristics: names and values by which preferences can choose it.
    """

    name: str
    terminals: tuple[str, str]
    colour: str
    tool: str
    heavy: bool
    zone: int
    slot_mm: Point
    segments: tuple[str, ...]
    route_ticks: int
    insert_ticks: int
    handover: Handover | None = None
    preferred_arm: str | None = None
    stage: Stage = Stage.STORED
    first: End | None = None
    jammed: End | None = None
    handling: Handling | None = None
    detours: tuple[Detour, ...] = ()
    insert_force_n: float | None = None
    characteristics: tuple[tuple[str, Characteristic], ...] = ()
    cable: str = ""


@dataclass(frozen=True)
class Under:
    """Wire `after` lies over wire `before`, which must be routed when its routing starts.

    Attributes:
        reason: the user's name for it; empty for one of the design's.
        source: its place in the design's file, such as `precedence[3]`; empty if it has none.
    """

    before: str
    after: str
    reason: str = ""
    source: str = field(default="", compare=False)


@dataclass(frozen=True)
class Pin:
    """An end that would bar the access to another one, and is inserted after it.

    Attributes:
        source: its place in the design's file; empty if it has none.
    """

    before: str
    before_end: End
    after: str
    after_end: End
    source: str = field(default="", compare=False)


@dataclass(frozen=True)
class SoftConstraint:
    """Wire `before` should be picked before wire `after`; else the plan costs the weight.

    Attributes:
        reason: the user's name for it; empty for one of the design's.
    """

    before: str
    after: str
    weight: int
    reason: str = ""


@dataclass(frozen=True)
class Ranking:
    """Wires that should be picked group by group: each pair picked otherwise costs the weight.

    It stands for a soft constraint for each pair of wires of different groups, too many of them to
    be listed with hundreds of wires: the pairs that an order violates are counted.

    Attributes:
        groups: names of wires; those of the first group should come first.
        reason: the user's name for it; empty for one of the design's.
    """

    groups: tuple[tuple[str, ...], ...]
    weight: int
    reason: str = ""

    @cached_property
    def rank(self) -> dict[str, int]:
        """The number of each wire's group."""
        return {wire: i for i, group in enumerate(self.groups) for wire in group}

    @property
    def pairs(self) -> int:
        """How many pairs of wires of different groups there are."""
        sizes = [len(group) for group in self.groups]
        return (sum(sizes) ** 2 - sum(size**2 for size in sizes)) // 2

    def constraints(self) -> Iterator[SoftConstraint]:
        """Yield the soft constraints for which it stands."""
        for first, second in combinations(self.groups, 2):
            for before, after in product(first, second):
                yield SoftConstraint(before, after, self.weight, self.reason)


@dataclass(frozen=True)
class Durations:
    """Times of the actions that do not depend on the wire [ticks]."""

    pick: int
    locate: int
    fix: int
    change_tool: int
    extract: int
    hand_over: int


@dataclass(frozen=True)
class Weights:
    """What a plan pays besides its time [ticks].

    Attributes:
        colour: for each pick of another colour than the same arm's last one.
        zone: for each zone that an arm goes back to the left.
        start: for each zone between the left and the first arm's first wire.
        tool: for each change of tool.
        heavy: for each heavy wire picked after a light one.
        arm: for each wire picked by another arm than its preferred one.
        cable: each time that an arm takes up a cable again: picks a core after anything but another
            core of that cable, which is not the first of it that is picked.
    """

    colour: int
    zone: int
    start: int
    tool: int
    heavy: int
    arm: int
    cable: int = 0


@dataclass(frozen=True)
class Problem:
    """What is to be planned.

    Attributes:
        speed_mm: what an arm travels in a tick along x and at the same time along y.
        start_ticks: when the plan begins; the makespan counts from here.
        located: components whose place is known.
        history: wires picked before, and the arm of each.
    """

    name: str
    speed_mm: int
    durations: Durations
    weights: Weights
    tools: tuple[str, ...]
    arms: tuple[PlannedArm, ...]
    components: tuple[str, ...]
    terminals: tuple[PlannedTerminal, ...]
    wires: tuple[PlannedWire, ...]
    unders: tuple[Under, ...] = ()
    pins: tuple[Pin, ...] = ()
    soft_constraints: tuple[SoftConstraint, ...] = ()
    rankings: tuple[Ranking, ...] = ()
    start_ticks: int = 0
    located: frozenset[str] = frozenset()
    history: tuple[tuple[str, str], ...] = ()

    @cached_property
    def terminal(self) -> dict[str, PlannedTerminal]:
        """Terminals by name."""
        return {terminal.name: terminal for terminal in self.terminals}

    @cached_property
    def wire(self) -> dict[str, PlannedWire]:
        """Wires by name."""
        return {wire.name: wire for wire in self.wires}

    def end_terminal(self, wire: PlannedWire, end: End) -> PlannedTerminal:
        """Return the terminal of a wire's end."""
        return self.terminal[wire.terminals[end]]

    def pick_ticks(self, wire: PlannedWire) -> int:
        """Return how long picking a wire takes."""
        return wire.handling.pick_ticks if wire.handling else self.durations.pick

    def insert_ticks(self, wire: PlannedWire, end: End) -> int:
        """Return how long inserting a wire's end takes."""
        return wire.handling.insert_ticks[end] if wire.handling else wire.insert_ticks

    def fix_ticks(self, wire: PlannedWire) -> int:
        """Return how long fixing a wire takes."""
        return wire.handling.fix_ticks if wire.handling else self.durations.fix


class ActionKind(Enum):
    """What an arm does; the value is the word that files use."""

    CHANGE_TOOL = "tool"
    PICK = "pick"
    LOCATE = "locate"
    INSERT = "insert"
    ROUTE = "route"
    HAND_OVER = "handover"
    FIX = "fix"
    EXTRACT = "extract"


@dataclass(frozen=True)
class Action:
    """One action of a plan; what its kind does not use is None.

    Attributes:
        end: inserted, extracted, or routed to; None for a route to the handover point.
        target: the tool changed to, the terminal located, or the receiving arm.
    """

    kind: ActionKind
    arm: str
    start_ticks: int
    wire: str | None = None
    end: End | None = None
    target: str | None = None


@dataclass(frozen=True)
class Plan:
    """The actions of all arms in the order of their starts."""

    problem: str
    actions: tuple[Action, ...]


def wire_order(problem: Problem) -> Iterator[tuple[str, str]]:
    """Yield the pairs of unfinished wires of which the first must be done before the second.

    Constraints speak of routes and ends. With a list of whole wires that satisfies these pairs, the
    arms satisfy the constraints, whatever they do at the same time.
    """
    for under in problem.unders:
        before, after = problem.wire[under.before], problem.wire[under.after]
        if before.stage < Stage.ROUTED and after.stage < Stage.ROUTED:
            yield under.before, under.after
    for pin in problem.pins:
        if (
            pin.before != pin.after
            and not is_inserted(problem.wire[pin.before], pin.before_end)
            and not is_inserted(problem.wire[pin.after], pin.after_end)
        ):
            yield pin.before, pin.after


def directly_before(problem: Problem) -> dict[str, list[str]]:
    """Return of each unfinished wire those that must be done before it, without theirs."""
    return grouped((later, earlier) for earlier, later in wire_order(problem))


def grouped(pairs: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """Return of each first name of some pairs the second ones, in their order."""
    found: dict[str, list[str]] = {}
    for first, second in pairs:
        found.setdefault(first, []).append(second)
    return found


def reached(names: Iterable[str], following: Mapping[str, Iterable[str]]) -> set[str]:
    """Return names, and all that follow one of them, also over others."""
    found = set(names)
    frontier = list(found)
    while frontier:
        fresh = set(following.get(frontier.pop(), ())) - found
        found |= fresh
        frontier += fresh
    return found


def is_inserted(wire: PlannedWire, end: End) -> bool:
    """Return whether an end is in its terminal when planning begins."""
    if wire.stage >= Stage.SECOND_IN:
        return True
    return wire.stage >= Stage.FIRST_IN and wire.first is end


@dataclass(frozen=True)
class Mode:
    """How a wire is placed.

    Attributes:
        arm: index of the arm that picks the wire, or that holds it at the start.
        first: the end inserted first.
    """

    arm: int
    first: End
    hands_over: bool

    @property
    def number(self) -> int:
        """The kernel's name for the mode."""
        return self.arm * 4 + self.first * 2 + self.hands_over

    @classmethod
    def numbered(cls, number: int) -> Mode:
        """Return the mode of a number."""
        return cls(number >> 2, End(number >> 1 & 1), bool(number & 1))


def possible_modes(problem: Problem) -> dict[str, tuple[Mode, ...]]:
    """Return the modes that reach, stage and own pins leave to each unfinished wire, by name."""
    barred: dict[str, set[End]] = {}
    for pin in problem.pins:
        if pin.before == pin.after:
            barred.setdefault(pin.after, set()).add(pin.after_end)
    return {
        wire.name: tuple(_modes(problem, wire, barred.get(wire.name, set())))
        for wire in problem.wires
        if wire.stage is not Stage.FIXED
    }


def _modes(problem: Problem, wire: PlannedWire, barred: set[End]) -> Iterator[Mode]:
    ends = [wire.first] if wire.first is not None else [end for end in End if end not in barred]
    for index, arm in enumerate(problem.arms):
        if not _starts(arm, wire):
            continue
        for first in ends:
            at_first, at_second = (
                problem.end_terminal(wire, end).position_mm for end in (first, first.other)
            )
            if wire.stage <= Stage.FIRST_IN and not arm.reaches(at_first):
                continue
            if wire.stage is not Stage.HALF and arm.reaches(at_second):
                yield Mode(index, first, False)
            if wire.handover and wire.stage <= Stage.HALF:
                meeting = wire.handover.position_mm
                receives = any(
                    other.reaches(meeting) and other.reaches(at_second)
                    for other in problem.arms
                    if other is not arm
                )
                if receives and arm.reaches(meeting):
                    yield Mode(index, first, True)


def _starts(arm: PlannedArm, wire: PlannedWire) -> bool:
    """Return whether an arm can pick the wire, or holds it already."""
    if wire.stage is Stage.STORED:
        return arm.reaches(wire.slot_mm)
    return arm.holding == wire.name
