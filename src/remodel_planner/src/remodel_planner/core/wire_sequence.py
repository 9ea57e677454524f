"""The order in which wires are placed: simple, and valid for one arm.

Thick wires first, since thin ones give way to what lies there already; then channel by channel,
from the far end of the panel; then as designed.
"""

from __future__ import annotations

from remodel_planner.core.panel_layout import CutWire


def sequence(wires: tuple[CutWire, ...]) -> tuple[CutWire, ...]:
    """Return the wires in the order of their tasks."""
    position = {wire.wire.name: index for index, wire in enumerate(wires)}
    return tuple(
        sorted(
            wires,
            key=lambda wire: (-wire.wire.section_mm2, wire.channel, position[wire.wire.name]),
        )
    )
