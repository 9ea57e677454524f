"""Where wires go on a panel, their openings, slots and routes, and where placed ones lie."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from remodel_work.geometry import Array, Pose, wrap_angle
from remodel_work.panel import Duct, Panel, PanelClip, WireEnd

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


# A duct's wall that stands so near before an opening is the one that its wire passes [m].
BEFORE_M = 0.060
# A wall stands across an opening's axis if their directions differ from a right angle by less.
ACROSS_RAD = math.radians(20.0)


@dataclass(frozen=True)
class Slot:
    """A slot in a duct's wall, seen from an opening.

    Attributes:
        aside: from the opening's axis, along the opening's y [m].
        before: from the opening, against its axis [m].
    """

    aside: float
    before: float

    @property
    def slant(self) -> float:
        """Yaw of a wire that runs straight from the slot to the opening, from its axis [rad]."""
        return -math.atan2(self.aside, self.before)


def slot_before(panel: Panel, opening: Pose) -> Slot | None:
    """Return the slot nearest to an opening's axis; None where no slotted duct stands before it.

    Args:
        panel: with its ducts.
        opening: its frame, x into the terminal, panel frame.
    """
    found = [slot for duct in panel.ducts if (slot := _slot_of(duct, opening)) is not None]
    return min(found, key=lambda slot: abs(slot.aside), default=None)


def _slot_of(duct: Duct, opening: Pose) -> Slot | None:
    if not duct.slot_pitch:
        return None
    into_duct = duct.panel_from_duct.inverse() @ opening
    out = -into_duct.rotation[:, 0]
    along, across, _ = (float(v) for v in into_duct.position)
    if abs(out[0]) > math.sin(ACROSS_RAD) or across * out[1] >= 0:
        return None
    away = abs(across) - duct.width / 2
    if not 0 <= away <= BEFORE_M or abs(along) > duct.length / 2:
        return None
    slot = round(along / duct.slot_pitch) * duct.slot_pitch
    aside = np.array([slot - along, 0.0, 0.0])
    return Slot(float(aside @ into_duct.rotation[:, 1]), away)


# A clip whose middle is so near to a wire's line, and that points so nearly along it, is its clip.
CLIP_ASIDE_M = 0.010
CLIP_TURN_RAD = math.radians(15.0)
# Places in a duct that are checked are so far apart [m].
DUCT_STEP_M = 0.02


def world_from_clip(clip: PanelClip, panel: Panel) -> Pose:
    """Return a clip's frame in the world."""
    return panel.world_from_panel @ clip.panel_from_clip


def clips_along(path: tuple[Pose, ...], panel: Panel) -> tuple[PanelClip, ...]:
    """Return the clips that straight lines from pose to pose of a path pass, in their order.

    A clip may point either way along the wire; those returned point along the path.
    """
    lines = tuple(_lines(path))
    found = [passing for clip in panel.clips if (passing := _first_passing(clip, lines, panel))]
    return tuple(clip for _, _, clip in sorted(found, key=lambda passing: passing[:2]))


def _first_passing(
    clip: PanelClip, lines: Sequence[_Line], panel: Panel
) -> tuple[int, float, PanelClip] | None:
    """Return the first line that passes a clip, how far along it, and the clip along the line."""
    place = world_from_clip(clip, panel)
    for i, line in enumerate(lines):
        x, y, _ = line.frame.inverse().apply(place.position)
        turned = abs(wrap_angle(place.yaw - line.frame.yaw))
        if not 0 <= x < line.length or abs(y) > CLIP_ASIDE_M:
            continue
        if turned < CLIP_TURN_RAD:
            return i, float(x), clip
        if math.pi - turned < CLIP_TURN_RAD:
            return i, float(x), _turned(clip)
    return None


def _turned(clip: PanelClip) -> PanelClip:
    x, y, yaw = clip.pose
    return replace(clip, pose=(x, y, yaw + math.pi))


def step_in(duct: Duct) -> float:
    """Return how far apart the places are that are checked in a duct [m], about DUCT_STEP_M."""
    return duct.length / max(1, round(duct.length / DUCT_STEP_M))


def places_in(duct: Duct, path: tuple[Pose, ...], panel: Panel) -> tuple[Pose, ...]:
    """Return frames along the middle of a duct, where the path runs in it; x along it, world frame.

    They are `step_in` the duct apart.
    """
    middle = panel.world_from_panel @ duct.panel_from_duct
    step = step_in(duct)
    along = np.arange(step / 2, duct.length, step) - duct.length / 2
    places = [middle @ Pose.level(float(x), 0.0, 0.0) for x in along]
    middles = np.array([place.position for place in places])
    passed = [_passes(line, middles, middle.yaw, duct) for line in _lines(path)]
    return tuple(place for place, *by in zip(places, *passed, strict=True) if any(by))


@dataclass(frozen=True, eq=False)
class _Line:
    """A straight part of a path: x along it from its start."""

    frame: Pose
    length: float


def _lines(path: tuple[Pose, ...]) -> Iterator[_Line]:
    for start, end in pairwise(path):
        x, y = (float(v) for v in (end.position - start.position)[:2])
        if x or y:
            here = Pose.level(0.0, 0.0, 0.0, math.atan2(y, x))
            yield _Line(Pose(start.position, here.quaternion), math.hypot(x, y))


def _passes(line: _Line, places: Array, yaw: float, duct: Duct) -> npt.NDArray[np.bool_]:
    """Return which places (n, 3) [m] in a duct, all turned by a yaw, a line passes along it."""
    x, y, _ = line.frame.inverse().apply(places).T
    turned = abs(wrap_angle(2 * (yaw - line.frame.yaw)) / 2)
    return (x >= 0) & (x < line.length) & (abs(y) < duct.width / 2) & (turned < math.pi / 4)


@dataclass(frozen=True, eq=False)
class ParkedWire:
    """A wire that stays where it is.

    Attributes:
        nodes: (n, 3) from tip to tip [m], world frame.
        fixed: the ends that closed clamps held when it was parked.
    """

    nodes: Array
    fixed: frozenset[WireEnd]


@dataclass(frozen=True, eq=False)
class PlacedWires:
    """All that lies on a panel beside the live wire.

    Attributes:
        parked: by the wire's name.
        occupied: the wire end that each terminal holds.
    """

    parked: Mapping[str, ParkedWire] = field(default_factory=dict)
    occupied: Mapping[TerminalKey, tuple[str, WireEnd]] = field(default_factory=dict)
