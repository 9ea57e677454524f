"""What is different in the cell between two moments, for people."""

from __future__ import annotations

from collections.abc import Iterator
from math import dist

from remodel_console.core.cell.cell_state import CellState

_TURNED = 0.02  # [rad], or [m] of a joint that slides
_MOVED_M = 0.005


def differences(then: CellState, now: CellState) -> tuple[str, ...]:
    """Return what is not now as it was then; empty if nothing is."""
    return tuple(_differences(then, now))


def _differences(then: CellState, now: CellState) -> Iterator[str]:
    turned = {
        name: abs(now.joints[name] - angle)
        for name, angle in then.joints.items()
        if name in now.joints
    }
    if turned and max(turned.values()) > _TURNED:
        name = max(turned, key=lambda one: turned[one])
        yield f"The robot stands elsewhere: joint {name} differs by {turned[name]:.2f}."
    missing = sorted(set(then.wires) - set(now.wires))
    if missing:
        yield f"Not in the cell now: {', '.join(missing)}."
    more = sorted(set(now.wires) - set(then.wires))
    if more:
        yield f"Only in the cell now: {', '.join(more)}."
    for name in sorted(set(then.wires) & set(now.wires)):
        pairs = zip(then.wires[name].points, now.wires[name].points, strict=False)
        moved_m = max((dist(a, b) for a, b in pairs), default=0.0)
        if moved_m > _MOVED_M:
            yield f"{name} lies up to {1000 * moved_m:.0f} mm elsewhere."
    boxes = set(then.boxes) & set(now.boxes)
    if set(then.boxes) != set(now.boxes):
        yield "Another panel is in the cell."
    moved = sorted(
        name
        for name in boxes
        if dist(then.boxes[name].position, now.boxes[name].position) > _MOVED_M
    )
    if moved:
        yield f"Moved: {', '.join(moved)}."
