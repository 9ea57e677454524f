"""The order in which wires are placed: simple, and valid for one arm.

Thick wires first, since thin ones give way to what lies there already; then channel by channel,
from the far end of the panel; then from right to left by the wires' left ends: a wire lies over
what is between its ends, and must not hide the labels of components that come later.
"""

from __future__ import annotations

from remodel_planner.core.panel_layout import CutWire


def sequence(wires: tuple[CutWire, ...]) -> tuple[CutWire, ...]:
    """Return the wires in the order of their tasks; equal ones stay as designed."""
    return tuple(
        sorted(
            wires,
            key=lambda wire: (
                -wire.wire.section_mm2,
                wire.channel,
                max(wire.first_y, wire.second_y),
            ),
        )
    )
