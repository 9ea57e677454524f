"""The panel and its wires, as values. Fields, units and frames are those of remodel_msgs/Panel."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol, TypeVar

import numpy as np

from remodel_states.core.cell import Passage
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose


class Named(Protocol):
    """An item that its id distinguishes from others of its kind."""

    @property
    def id(self) -> str:
        """The id."""


Item = TypeVar("Item", bound=Named)
# Pitches that differ by less are the same [m].
PITCH_TOLERANCE_M = 1e-5


class WireEnd(Enum):
    """One of the two ends of a wire."""

    A = "a"
    B = "b"

    @property
    def other(self) -> WireEnd:
        """The end that this one is not."""
        return WireEnd.B if self is WireEnd.A else WireEnd.A


@dataclass(frozen=True)
class PanelTerminal:
    """A clamp: a square, chamfered opening; a header: a row of them; component frame.

    `mouth` is the middle of the opening or row, `bore` the width of an opening [m]. `screw` is the
    middle of the head of the screw that closes it [m]; None where there is none. `insertion_force`
    is that of a spring clamp [N]; 0 where a screw or a lever closes it.
    """

    id: str
    mouth: tuple[float, float, float]
    insertion_yaw: float
    bore: float
    depth: float
    chamfer: float
    retention_force: float
    ways: int = 1
    pitch: float = 0.0
    screw: tuple[float, float, float] | None = None
    insertion_force: float = 0.0

    @property
    def component_from_socket(self) -> Pose:
        """The opening's frame, in the middle of a row: x points into the terminal."""
        return Pose.level(*self.mouth, self.insertion_yaw)

    @property
    def closes_itself(self) -> bool:
        """Whether a spring holds an end as soon as it is in."""
        return self.insertion_force > 0.0

    @property
    def is_header(self) -> bool:
        """Whether it takes a connector."""
        return self.ways > 1

    @property
    def offsets(self) -> tuple[float, ...]:
        """Where its openings are along y from the middle of the row [m]."""
        return row(self.ways, self.pitch)


@dataclass(frozen=True)
class Component:
    """A component on the plate; `pose` is (x, y, yaw) of its base centre in the panel frame."""

    id: str
    kind: str
    marker_id: int
    marker_size: float
    pose: tuple[float, float, float]
    size: tuple[float, float, float]
    terminals: tuple[PanelTerminal, ...]

    @property
    def panel_from_component(self) -> Pose:
        """The component's nominal frame."""
        x, y, yaw = self.pose
        return Pose.level(x, y, 0.0, yaw)

    def terminal(self, terminal_id: str) -> PanelTerminal:
        """Return the terminal of that name, or say which there are."""
        return _named(self.terminals, terminal_id, f"terminal of component {self.id!r}")


@dataclass(frozen=True)
class Channel:
    """A free lane between two rows, along y; panel frame."""

    id: str
    x: float
    width: float
    y_min: float
    y_max: float


@dataclass(frozen=True)
class PanelClip:
    """A clip that the wire runs through along its x; `pose` is (x, y, yaw) in the panel frame."""

    id: str
    pose: tuple[float, float, float]
    wire_diameter: float
    height: float
    length: float
    retention_force: float

    @property
    def panel_from_clip(self) -> Pose:
        """Its frame: x along the wire, z away from the plate, the origin on the plate."""
        x, y, yaw = self.pose
        return Pose.level(x, y, 0.0, yaw)


@dataclass(frozen=True)
class Duct:
    """A trough between two walls, along its x; `pose` is (x, y, yaw) in the panel frame.

    The walls are combs above `slot_bottom` if there is a `slot_pitch`, else solid [m].
    """

    id: str
    pose: tuple[float, float, float]
    length: float
    width: float
    height: float
    slot_pitch: float = 0.0
    slot_width: float = 0.0
    slot_bottom: float = 0.0

    @property
    def passage(self) -> Passage:
        """What a wire's route passes."""
        return Passage(self.id, self.length, self.slot_pitch, self.slot_width)

    @property
    def is_fork(self) -> bool:
        """Whether it is no trough, but the posts of a fork."""
        return self.passage.is_fork

    @property
    def panel_from_duct(self) -> Pose:
        """Its frame: x along the duct, z away from the plate, the origin on the plate."""
        x, y, yaw = self.pose
        return Pose.level(x, y, 0.0, yaw)


@dataclass(frozen=True)
class Rail:
    """A mounting rail on the plate, along its x; `pose` is (x, y, yaw) in the panel frame."""

    id: str
    pose: tuple[float, float, float]
    length: float
    width: float
    height: float

    @property
    def panel_from_rail(self) -> Pose:
        """Its frame: x along the rail, z away from the plate, the origin on the plate."""
        x, y, yaw = self.pose
        return Pose.level(x, y, 0.0, yaw)


@dataclass(frozen=True)
class Connector:
    """A connector at a wire's end, as thick as the wire: a row of pins before a body."""

    id: str
    end: WireEnd
    ways: int
    pitch: float
    pin_diameter: float
    pin_length: float
    body_length: float
    body_width: float
    mating_force: float

    @property
    def length(self) -> float:
        """From the pins' tips to where the wire begins [m]."""
        return self.pin_length + self.body_length

    @property
    def offsets(self) -> tuple[float, ...]:
        """Where its pins are across the wire, from the middle [m]."""
        return row(self.ways, self.pitch)

    def fits(self, terminal: PanelTerminal) -> bool:
        """Return whether a terminal is a header with an opening for each pin."""
        return self.ways == terminal.ways and abs(self.pitch - terminal.pitch) < PITCH_TOLERANCE_M


def row(count: int, pitch: float) -> tuple[float, ...]:
    """Return the places of items in a row around its middle [m]."""
    return tuple((i - (count - 1) / 2) * pitch for i in range(count))


@dataclass(frozen=True)
class PanelWire:
    """A wire with a ferrule or a connector on each end; all properties known.

    `route` is a polyline [m] in the panel frame from one opening to the other, along the `ducts` it
    passes; empty if any route will do. `presented_at` is (x, y, yaw) in the panel frame; None if
    the cell decides it.
    """

    id: str
    a_component: str
    a_terminal: str
    b_component: str
    b_terminal: str
    colour: str
    section: float
    diameter: float
    length: float
    linear_density: float
    bending_stiffness: float
    ferrule_length: float
    torsional_stiffness: float
    friction: float
    rest_curvature: float
    yield_curvature: float
    hardening: float
    connectors: tuple[Connector, ...] = ()
    route: tuple[tuple[float, float, float], ...] = ()
    ducts: tuple[str, ...] = ()
    presented_at: tuple[float, float, float] | None = None

    @property
    def radius(self) -> float:
        """Half the diameter over the insulation [m]."""
        return self.diameter / 2

    def goes_to(self, end: WireEnd) -> tuple[str, str]:
        """Return the component and the terminal that the end belongs in."""
        if end is WireEnd.A:
            return self.a_component, self.a_terminal
        return self.b_component, self.b_terminal

    def connector_at(self, end: WireEnd) -> Connector | None:
        """Return the connector at an end; None where a ferrule is."""
        return next((c for c in self.connectors if c.end is end), None)

    def connector(self, connector_id: str) -> Connector:
        """Return the connector of that name, or say which there are."""
        return _named(self.connectors, connector_id, f"connector of wire {self.id!r}")

    def rigid_length(self, end: WireEnd) -> float:
        """Return the length of the ferrule or the connector at an end [m]."""
        connector = self.connector_at(end)
        return self.ferrule_length if connector is None else connector.length


# Where a board stands unless its cell says otherwise.
BOARD = Pose.level(0.50, 0.0, 0.0)


@dataclass(frozen=True)
class Panel:
    """A mounting plate and all that belongs on it.

    Attributes:
        serial: the product's serial number.
        world_from_panel: where the cell that has it holds it, level: the middle of its surface.
    """

    name: str
    size: tuple[float, float, float]
    components: tuple[Component, ...]
    channels: tuple[Channel, ...]
    wires: tuple[PanelWire, ...]
    clips: tuple[PanelClip, ...] = ()
    ducts: tuple[Duct, ...] = ()
    serial: str = ""
    rails: tuple[Rail, ...] = ()
    world_from_panel: Pose = field(default=BOARD, compare=False)

    def component(self, component_id: str) -> Component:
        """Return the component of that name, or say which there are."""
        return _named(self.components, component_id, "component")

    def channel(self, channel_id: str) -> Channel:
        """Return the channel of that name, or say which there are."""
        return _named(self.channels, channel_id, "channel")

    def wire(self, wire_id: str) -> PanelWire:
        """Return the wire of that name, or say which there are."""
        return _named(self.wires, wire_id, "wire")

    def panel_from_socket(self, component_id: str, terminal_id: str) -> Pose:
        """Return the nominal frame of a terminal's opening; x points into the terminal."""
        component = self.component(component_id)
        terminal = component.terminal(terminal_id)
        return component.panel_from_component @ terminal.component_from_socket

    def channel_in_front_of(self, opening: Array) -> Channel:
        """Return the channel whose edge is nearest to an opening, (3,) [m], panel frame."""
        return min(self.channels, key=lambda c: abs(abs(opening[0] - c.x) - c.width / 2))


def _named(items: tuple[Item, ...], wanted: str, noun: str) -> Item:
    for item in items:
        if item.id == wanted:
            return item
    there_are = ", ".join(item.id for item in items) or "none"
    raise AbilityError(Code.UNKNOWN_NAME, f"no {noun} {wanted!r}; there are: {there_are}")


def unit_x(pose: Pose) -> Array:
    """Return the x axis of a frame in its parent, (3,)."""
    return np.asarray(pose.rotation[:, 0])
