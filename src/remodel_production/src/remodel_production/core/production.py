"""Production knowledge: what an order is made of, whatever file it came from.

    Order ─ Component ─ Terminal
          ├ Wire ─ a, b: TerminalRef; route: names of segments
          ├ Cable, of which wires are cores
          └ Segment ─ start, end: Node; Clip

A terminal takes one wire end. Where a design joins several wires at one point, the importer makes
one terminal of each.

Frames: positions of components, nodes and clips are in the frame of the design (the panel's for a
cabinet, the vehicle's or the formboard's for a harness), those of terminals in their component's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property


@dataclass(frozen=True)
class AbilityParameter:
    """A field of an ability's goal; `type` is that of the ROS message."""

    name: str
    type: str
    description: str


@dataclass(frozen=True)
class Ability:
    """Something that the cell can do; `name` is that of its action."""

    name: str
    description: str
    parameters: tuple[AbilityParameter, ...]


Vector = tuple[float, float, float]

# Kind of what holds twisted wires together without a sheath.
TWISTED = "twisted wires"
_WITH_SEAL = "with seal"


class Side(Enum):
    """The side of a component, as drawn, on which a terminal opens."""

    TOP = "top"
    BOTTOM = "bottom"


class Mount(Enum):
    """Where a component is mounted: wires are routed on the plate only."""

    PLATE = "plate"
    DOOR = "door"
    OUTSIDE = "outside"


class Role(Enum):
    """What a component is to its wires: clamps, cavities, or a splice that joins their ends."""

    DEVICE = "device"
    CONNECTOR = "connector"
    JOINT = "joint"


class SegmentKind(Enum):
    """What holds the wires of a segment: a duct of the cabinet, or nothing but themselves.

    Wires run straight over STRAIGHT ones, from connector to connector, wherever their nodes are.
    """

    DUCT = "duct"
    BUNDLE = "bundle"
    STRAIGHT = "straight"


@dataclass(frozen=True)
class Pose:
    """A frame in another one.

    Attributes:
        position: [m] of its origin.
        orientation: unit quaternion x, y, z, w.
    """

    position: Vector
    orientation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class TerminalRef:
    """A terminal by name."""

    component: str
    terminal: str

    def __str__(self) -> str:
        return f"{self.component}:{self.terminal}"


@dataclass(frozen=True)
class Terminal:
    """A clamp, or a connector's cavity, that takes one wire end; unique in its component by name.

    What the design does not say is None, or empty.

    Attributes:
        point: at which the drawing joins its wire, with the component's other clamps of that point;
            empty if the clamp is its only one.
        kind: its type, such as the article of the contact.
        pose: of its opening.
        approach: unit vector along which a wire end goes in.
        clearance_m: [m] that the gripper needs around the opening.
        insertion_force_limit_n: [N] that an insertion must not exceed.
    """

    name: str
    side: Side
    point: str = ""
    kind: str = ""
    pose: Pose | None = None
    approach: Vector | None = None
    clearance_m: float | None = None
    insertion_force_limit_n: float | None = None

    @property
    def is_sealed(self) -> bool:
        """Whether its wire end bears a seal."""
        return _WITH_SEAL in self.kind


def sealed_kind(kind: str, seal: str) -> str:
    """Return the type of a terminal whose wire end bears a seal: ends with and without differ."""
    return f"{kind} {_WITH_SEAL} {seal}".strip()


@dataclass(frozen=True)
class Component:
    """A device or a connector; `name` is unique in its order.

    Attributes:
        kind: for a person.
        part_number: of its article; empty if the design does not say.
        pose: None if the design does not say.
        node: of the harness at which it sits; empty if there is none.
    """

    name: str
    kind: str
    terminals: tuple[Terminal, ...]
    mount: Mount = Mount.PLATE
    role: Role = Role.DEVICE
    part_number: str = ""
    pose: Pose | None = None
    node: str = ""

    def terminal(self, name: str) -> Terminal:
        """Return the terminal of that name; KeyError if there is none."""
        return {terminal.name: terminal for terminal in self.terminals}[name]

    def type_of(self, terminal: Terminal) -> str:
        """Return the type of one of its terminals; experience with one holds for all of a type."""
        return terminal_type(terminal.kind, self.part_number, self.kind)


def terminal_type(kind: str, part_number: str, component_kind: str) -> str:
    """Return the type of a terminal: its own, else its component's article, else its kind."""
    return kind or part_number or component_kind


@dataclass(frozen=True)
class Cable:
    """A cable, whose cores and shield are wires of the order.

    Attributes:
        kind: such as its type or article.
        length_m: [m]; None if the design does not say.
    """

    name: str
    kind: str
    length_m: float | None
    shielded: bool
    source: str


@dataclass(frozen=True)
class Wire:
    """A wire between two terminals; `name` is unique in its order.

    Attributes:
        colour: code, such as "BU"; of several colours one after another, such as "WHBU".
        section_mm2: [mm^2] of the conductor.
        source: where the design file draws it, such as "folio 2, line 1234".
        length_m: [m]; None if the design does not say.
        cable: that it is a core of; empty if it is a single wire.
        core: its name in the cable.
        route: segments from a to b; empty if the design does not say.
        number: that the design gives it, such as on its markers; the wires of a potential have the
            same. Empty if the design gives none.
    """

    name: str
    a: TerminalRef
    b: TerminalRef
    colour: str
    section_mm2: float
    source: str
    length_m: float | None = None
    cable: str = ""
    core: str = ""
    route: tuple[str, ...] = ()
    number: str = ""


@dataclass(frozen=True)
class Node:
    """Where segments meet or end; position [m], None if the design does not say."""

    name: str
    position: Vector | None


@dataclass(frozen=True)
class Segment:
    """A piece of the route of wires, such as of a duct or a bundle, between two nodes."""

    name: str
    start: str
    end: str
    length_m: float
    kind: SegmentKind = SegmentKind.BUNDLE


@dataclass(frozen=True)
class Clip:
    """What holds the wires that pass it, on a segment or at a node.

    Attributes:
        segment: that it sits on; empty if it sits at a node.
        along: its place on the segment, from 0 at its start to 1 at its end.
        node: that it sits at; empty if it sits on a segment.
    """

    name: str
    kind: str
    segment: str = ""
    along: float = 0.0
    node: str = ""
    position: Vector | None = None


@dataclass(frozen=True)
class Order:
    """What is to be wired, in the design's order.

    Attributes:
        title: of the design.
        source: the design's file name.
        notes: what the import assumed and left out, a line each.
    """

    name: str
    title: str
    source: str
    components: tuple[Component, ...]
    wires: tuple[Wire, ...]
    notes: tuple[str, ...] = ()
    cables: tuple[Cable, ...] = ()
    nodes: tuple[Node, ...] = ()
    segments: tuple[Segment, ...] = ()
    clips: tuple[Clip, ...] = ()

    def in_cabinet(self) -> Order:
        """Return the order cut down to the wires with both ends on the plate."""
        plate = {c.name for c in self.components if c.mount is Mount.PLATE}
        wires = [wire for wire in self.wires if {wire.a.component, wire.b.component} <= plate]
        ends = {end for wire in wires for end in (wire.a, wire.b)}
        components = []
        for component in self.components:
            used = tuple(
                t for t in component.terminals if TerminalRef(component.name, t.name) in ends
            )
            if used:
                components.append(replace(component, terminals=used))
        return replace(self, components=tuple(components), wires=tuple(wires))

    def leaving(self) -> dict[str, str]:
        """Return the wires that leave the plate, each with the end that says why."""
        mounts = {component.name: component.mount for component in self.components}
        found = {}
        for wire in self.wires:
            away = [end for end in (wire.a, wire.b) if mounts[end.component] is not Mount.PLATE]
            if away:
                in_door = mounts[away[0].component] is Mount.DOOR
                found[wire.name] = f"{away[0]} is {'in the door' if in_door else 'outside'}"
        return found

    def clips_of(self, wire: Wire) -> tuple[Clip, ...]:
        """Return the clips along a wire's route, from its end a to its end b."""
        return self.clips_along(self.directed_route(wire))

    def clips_along(self, route: Sequence[tuple[Segment, bool]]) -> tuple[Clip, ...]:
        """Return the clips along segments, of each whether it is passed from start to end."""
        passed: list[Clip] = []
        for index, (segment, is_forward) in enumerate(route):
            first, last = (segment.start, segment.end)[:: 1 if is_forward else -1]
            if not index:
                passed += self._clips_at.get(first, ())
            clips = sorted(self._clips_on.get(segment.name, ()), key=lambda clip: clip.along)
            passed += clips if is_forward else clips[::-1]
            passed += self._clips_at.get(last, ())
        return tuple(passed)

    def directed_route(self, wire: Wire) -> list[tuple[Segment, bool]]:
        """Return the segments of a wire's route, and whether each is passed from start to end."""
        segments = [self._segment[name] for name in wire.route]
        if len(segments) == 1:
            (only,) = segments
            leaves_end = self._node_of.get(wire.a.component, "") == only.end
            reaches_start = self._node_of.get(wire.b.component, "") == only.start
            return [(only, not (leaves_end or reaches_start))]
        route = []
        for index, segment in enumerate(segments):
            if index + 1 < len(segments):
                following = segments[index + 1]
                is_forward = segment.end in (following.start, following.end)
            else:
                before = segments[index - 1]
                is_forward = segment.start in (before.start, before.end)
            route.append((segment, is_forward))
        return route

    @cached_property
    def _segment(self) -> dict[str, Segment]:
        return {segment.name: segment for segment in self.segments}

    @cached_property
    def _node_of(self) -> dict[str, str]:
        return {component.name: component.node for component in self.components}

    @cached_property
    def _clips_on(self) -> dict[str, list[Clip]]:
        clips: dict[str, list[Clip]] = {}
        for clip in self.clips:
            if clip.segment:
                clips.setdefault(clip.segment, []).append(clip)
        return clips

    @cached_property
    def _clips_at(self) -> dict[str, list[Clip]]:
        clips: dict[str, list[Clip]] = {}
        for clip in self.clips:
            if clip.node:
                clips.setdefault(clip.node, []).append(clip)
        return clips
