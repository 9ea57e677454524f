r"""The solid shapes of a component and of a connector, and the colours of what is beside wires.

A component is boxes around its openings, a funnel at each, and its label. The half of it on each
side that has terminals is cut into pockets. A pocket is as wide as its opening with the funnel;
inside it four walls narrow it, and four inclined plates make the funnel:

      face   chamfer        depth
        |\\_____|______________|
        |       inside         | bottom
        | _____________________|
        |/      |              |

A connector is a flat body, a row of pins before it, and a mark on it, in the frame of the rigid
link that it is (cable.py), whose cap at the tip it has not: origin in its middle, z along the wire
towards end b, y along the row of pins; x is upright while it lies flat.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np
import numpy.typing as npt

from remodel_states.core.wires import Rgb, rgbs_of
from remodel_work.geometry import Array
from remodel_work.panel import Component, Connector, PanelTerminal, PanelWire, WireEnd

PLATE_THICKNESS_M = 0.0015
LABEL_THICKNESS_M = 0.0004
# The top of a screw's head above the component's.
SCREW_ABOVE_M = 0.0005
# White margin around the label's black square, in cells of it: ArUco needs one.
LABEL_MARGIN_CELLS = 1.0
LABEL_CELLS = 6  # DICT_4X4 with its black border

HOUSING = (0.33, 0.37, 0.43)
METAL = (0.80, 0.66, 0.36)
SCREW = (0.62, 0.63, 0.65)
WHITE = (1.0, 1.0, 1.0)
BLACK = (0.02, 0.02, 0.02)
# The collar that covers each ferrule: a hue that no wire has, so that loose ends are found among
# wires of any colour.
FERRULE_RGB: Rgb = (0.95, 0.02, 0.62)
# The mounting plate, near RAL 7035 (light grey).
PLATE_RGB: Rgb = (0.80, 0.82, 0.80)

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Box:
    """A box in the component's frame.

    Attributes:
        centre: [m].
        size: [m].
        rpy: fixed-axis rotation [rad].
        rgb: colour.
        solid: whether others collide with it.
    """

    centre: Vector
    size: Vector
    rgb: Vector
    rpy: Vector = (0.0, 0.0, 0.0)
    solid: bool = True


def component_boxes(component: Component, *, label: bool = True) -> tuple[Box, ...]:
    """Return all boxes of a component, with its label if it carries one."""
    sticker = _label(component) if label else ()
    return tuple([*_housing(component), *sticker, *_screws(component)])


def opens_forward(terminal: PanelTerminal) -> bool:
    """Return whether the opening is on the component's +x side and leads towards -x."""
    return math.cos(terminal.insertion_yaw) < 0


def _housing(component: Component) -> Iterator[Box]:
    depth, width, height = component.size
    cut = {}
    for side in (-1, 1):
        terminals = sorted(
            (bore for bore in _openings(component) if opens_forward(bore) == (side > 0)),
            key=lambda t: t.mouth[1],
        )
        cut[side] = max((t.depth for t in terminals), default=0.0)
        if terminals:
            yield from _side(side, terminals, cut[side], component.size)
    core = depth - cut[-1] - cut[1]
    yield Box(((cut[-1] - cut[1]) / 2, 0, height / 2), (core, width, height), HOUSING)


def _openings(component: Component) -> Iterator[PanelTerminal]:
    """Yield every opening, those of a header one by one."""
    for terminal in component.terminals:
        x, y, z = terminal.mouth
        for offset in terminal.offsets:
            yield replace(terminal, mouth=(x, y + offset, z), ways=1)


def _side(side: int, terminals: list[PanelTerminal], cut: float, size: Vector) -> Iterator[Box]:
    """Fill the outermost `cut` metres of one side around its pockets."""
    depth, width, height = size
    halves = [t.bore / 2 + t.chamfer for t in terminals]
    low = min(t.mouth[2] - h for t, h in zip(terminals, halves, strict=True))
    high = max(t.mouth[2] + h for t, h in zip(terminals, halves, strict=True))

    def block(
        u: tuple[float, float], y: tuple[float, float], z: tuple[float, float]
    ) -> Iterator[Box]:
        extent = (u[1] - u[0], y[1] - y[0], z[1] - z[0])
        if min(extent) > 1e-6:
            x = side * (depth / 2 - (u[0] + u[1]) / 2)
            yield Box((x, (y[0] + y[1]) / 2, (z[0] + z[1]) / 2), extent, HOUSING)

    yield from block((0, cut), (-width / 2, width / 2), (0, low))
    yield from block((0, cut), (-width / 2, width / 2), (high, height))
    left = -width / 2
    for terminal, half in zip(terminals, halves, strict=True):
        _, y, z = terminal.mouth
        bore = terminal.bore / 2
        yield from block((0, cut), (left, y - half), (low, high))
        left = y + half
        yield from block((0, cut), (y - half, y + half), (low, z - half))
        yield from block((0, cut), (y - half, y + half), (z + half, high))
        yield from block((terminal.depth, cut), (y - half, y + half), (z - half, z + half))
        inner = (terminal.chamfer, terminal.depth)
        yield from block(inner, (y - half, y - bore), (z - half, z + half))
        yield from block(inner, (y + bore, y + half), (z - half, z + half))
        yield from block(inner, (y - bore, y + bore), (z - half, z - bore))
        yield from block(inner, (y - bore, y + bore), (z + bore, z + half))
        yield from _funnel(terminal, side)
    yield from block((0, cut), (left, width / 2), (low, high))


def _funnel(terminal: PanelTerminal, side: int) -> Iterator[Box]:
    """Four plates at 45 degrees from the face down to the opening's width."""
    chamfer = terminal.chamfer
    if chamfer <= 0:
        return
    opening_x, y, z = terminal.mouth
    half = terminal.bore / 2 + chamfer
    length = chamfer * math.sqrt(2)
    # The middle of the funnel's surface, moved outward by half the plate's thickness.
    inward = chamfer / 2 - PLATE_THICKNESS_M / 2 / math.sqrt(2)
    outward = terminal.bore / 2 + chamfer / 2 + PLATE_THICKNESS_M / 2 / math.sqrt(2)
    inward += PLATE_THICKNESS_M / math.sqrt(2)
    x = opening_x - side * inward
    for sign in (-1, 1):
        yield Box(
            (x, y + sign * outward, z),
            (length, PLATE_THICKNESS_M, 2 * half),
            METAL,
            rpy=(0, 0, side * sign * math.pi / 4),
        )
        yield Box(
            (x, y, z + sign * outward),
            (length, 2 * half, PLATE_THICKNESS_M),
            METAL,
            rpy=(0, -side * sign * math.pi / 4, 0),
        )


def screw_heads(component: Component) -> Iterator[tuple[Vector, float]]:
    """Yield the middle of the head of each clamp's screw, on the top, and its side [m]."""
    height = component.size[2]
    for terminal in component.terminals:
        if terminal.is_header:
            continue
        x, y, _ = terminal.mouth
        inward = -0.007 if opens_forward(terminal) else 0.007
        yield terminal.screw or (x + inward, y, height), min(0.006, terminal.bore)


def _screws(component: Component) -> Iterator[Box]:
    """A screw head on top of each clamp, to be seen only."""
    for head, side in screw_heads(component):
        yield Box(head, (side, side, 2 * SCREW_ABOVE_M), SCREW, solid=False)


def _label(component: Component) -> Iterator[Box]:
    """The ArUco label on top.

    A white plate with black cells, the marker's right along x, its up along y.
    """
    top = component.size[2]
    cell = component.marker_size / LABEL_CELLS
    white = component.marker_size + 2 * LABEL_MARGIN_CELLS * cell
    yield Box((0, 0, top), (white, white, LABEL_THICKNESS_M), WHITE, solid=False)
    black = marker_cells(component.marker_id) == 0
    for row in range(LABEL_CELLS):
        y = component.marker_size / 2 - (row + 0.5) * cell
        edges = np.flatnonzero(np.diff(np.r_[0, black[row].astype(int), 0]))
        for first, last in edges.reshape(-1, 2):
            x = -component.marker_size / 2 + (first + last) / 2 * cell
            size = ((last - first) * cell, cell, 2 * LABEL_THICKNESS_M)
            yield Box((float(x), y, top), size, BLACK, solid=False)


def marker_cells(marker_id: int) -> npt.NDArray[np.uint8]:
    """Return the label's cells (6, 6), 0 where black."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_250)
    return np.asarray(cv2.aruco.generateImageMarker(dictionary, marker_id, LABEL_CELLS), np.uint8)


def label_corners(component: Component) -> Array:
    """Return the corners of the black square in ArUco's order, (4, 3) [m], component frame."""
    half = component.marker_size / 2
    top = component.size[2] + LABEL_THICKNESS_M
    return np.array(
        [[-half, half, top], [half, half, top], [half, -half, top], [-half, -half, top]]
    )


# The mark is as long as a ferrule, begins at the body's face, and stands so far out of the body.
MARK_WIDTH_M = 0.004
MARK_THICKNESS_M = 0.0002
# Of polyamide, ribbed to be gripped by; estimated.
BODY_FRICTION = 0.8


@dataclass(frozen=True)
class Solid:
    """A box, or a capsule along z.

    Attributes:
        centre: [m].
        size: of the box; of the capsule (diameter, diameter, length with its caps) [m].
        rgb: colour.
        capsule: whether it is one.
        solid: whether things collide with it.
    """

    centre: Vector
    size: Vector
    rgb: Rgb
    capsule: bool = False
    solid: bool = True


def connector_solids(wire: PanelWire, connector: Connector) -> tuple[Solid, ...]:
    """Return the parts of a connector."""
    # Towards the tip.
    out = -1 if connector.end is WireEnd.A else 1
    tip = out * (connector.length + wire.radius) / 2
    face = tip - out * connector.pin_length

    def behind_face(length: float) -> float:
        return face - out * length / 2

    body = Solid(
        (0.0, 0.0, behind_face(connector.body_length)),
        (wire.diameter, connector.body_width, connector.body_length),
        rgbs_of(wire.colour)[0],
    )
    mark = Solid(
        (0.0, 0.0, behind_face(wire.ferrule_length)),
        (wire.diameter + 2 * MARK_THICKNESS_M, MARK_WIDTH_M, wire.ferrule_length),
        FERRULE_RGB,
        solid=False,
    )
    # A pin's rear cap lies in the body.
    length = connector.pin_length + connector.pin_diameter / 2
    pins = tuple(
        Solid(
            (0.0, y, tip - out * length / 2),
            (connector.pin_diameter, connector.pin_diameter, length),
            METAL,
            capsule=True,
        )
        for y in connector.offsets
    )
    return body, mark, *pins
