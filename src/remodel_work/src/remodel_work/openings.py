"""Where the terminals' openings are: as last observed, else as drawn on the panel."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from remodel_work.geometry import Array, Pose
from remodel_work.panel import Panel

# Component and terminal.
TerminalKey = tuple[str, str]


def opening_of(terminal: TerminalKey, panel: Panel, seen: Mapping[str, Pose]) -> Pose:
    """Return the frame of a terminal's opening in the world, x into the terminal.

    Args:
        terminal: whose opening.
        panel: the panel as drawn.
        seen: frames of components in the world, as they were last seen.
    """
    component_id, terminal_id = terminal
    component = panel.component(component_id)
    drawn = panel.world_from_panel @ component.panel_from_component
    stands = seen.get(component_id, drawn)
    return stands @ component.terminal(terminal_id).component_from_socket


def nearest_terminal(point: Array, panel: Panel, seen: Mapping[str, Pose]) -> TerminalKey:
    """Return the terminal whose opening is nearest to a point (3,) [m], world frame."""

    def away(terminal: TerminalKey) -> float:
        opening = opening_of(terminal, panel, seen)
        return float(np.linalg.norm(opening.position - point))

    return min(_terminals(panel), key=away)


def _terminals(panel: Panel) -> Iterator[TerminalKey]:
    for component in panel.components:
        for terminal in component.terminals:
            yield component.id, terminal.id
