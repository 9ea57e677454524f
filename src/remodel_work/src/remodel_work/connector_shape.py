"""The solid shape of a connector: a flat body, a row of pins before it, and a mark on it.

Frame of the rigid link that it is (cable.py), whose cap at the tip it has not: origin in its
middle, z along the wire towards end b, y along the row of pins; x is upright while it lies flat.
"""

from __future__ import annotations

from dataclasses import dataclass

from remodel_states.core.wires.wire_colours import Rgb, rgbs_of
from remodel_work.component_shape import METAL, Vector
from remodel_work.panel import Connector, PanelWire, WireEnd
from remodel_work.wire_colours import FERRULE_RGB

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
