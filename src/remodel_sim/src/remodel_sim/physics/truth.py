"""Ground truth: where the wires really are. Only tests, reports and scores use it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from remodel_sim.physics.plant import SimulatedPlant
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Duct, PanelClip, WireEnd
from remodel_work.routes import places_in, step_in, world_from_clip

# A tip that is so near to the bottom sits at it; InsertCable judges by the same distance. The
# clamp's jaw is further out.
BOTTOM_M = 0.002
# A wire in a clip has some play, and bends a little beside it.
IN_CLIP_M = 0.001


@dataclass(frozen=True)
class EndTruth:
    """One end of a wire.

    Attributes:
        at: "component/terminal" whose opening holds it; empty: none.
        depth: of the tip in that opening [m].
        fixed: whether that clamp is closed on it.
        seated: whether it sits at the bottom of its own terminal.
    """

    at: str
    depth: float
    fixed: bool
    seated: bool


@dataclass(frozen=True)
class WireTruth:
    """A wire that was fed.

    Attributes:
        duct_length: of its planned route in ducts [m].
        in_ducts: share of that length at which it lies below the rims; 0 without ducts.
    """

    wire_id: str
    a: EndTruth
    b: EndTruth
    duct_length: float
    in_ducts: float

    @property
    def placed(self) -> bool:
        """Whether both ends sit at the bottom of their own terminals, held by closed clamps."""
        return all(end.seated and end.fixed for end in (self.a, self.b))


def ground_truth(plant: SimulatedPlant, wire_ids: list[str]) -> list[WireTruth]:
    """Return the truth about these wires, each of them live or parked."""
    truths = []
    for wire_id in wire_ids:
        if plant.live is not None and plant.live.wire.id == wire_id:
            fixed = plant.live.fixed
        elif wire_id in plant.parked:
            fixed = plant.parked[wire_id].fixed
        else:
            continue
        nodes = _nodes(plant, wire_id)
        a = _end_truth(plant, wire_id, WireEnd.A, nodes[0], fixed=fixed)
        b = _end_truth(plant, wire_id, WireEnd.B, nodes[-1], fixed=fixed)
        planned, found = _lengths_in_ducts(plant, wire_id)
        share = found / planned if planned else 0.0
        truths.append(WireTruth(wire_id, a, b, duct_length=planned, in_ducts=share))
    return truths


def lies_in(plant: SimulatedPlant, wire_id: str, clip: PanelClip) -> bool:
    """Return whether a wire that was fed runs through a clip, below its lips."""
    x, y, z = world_from_clip(clip, plant.panel).inverse().apply(_nodes(plant, wire_id)).T
    order = np.argsort(x)
    aside, height = (float(np.interp(0.0, x[order], v[order])) for v in (y, z))
    return bool(x.min() < 0 < x.max()) and max(abs(aside), abs(height - clip.height)) < IN_CLIP_M


def share_in_ducts(plant: SimulatedPlant, wire_id: str) -> float:
    """Return at which share of its route in ducts a wire that was fed lies below their rims."""
    planned, found = _lengths_in_ducts(plant, wire_id)
    return found / planned if planned else 0.0


def _lengths_in_ducts(plant: SimulatedPlant, wire_id: str) -> tuple[float, float]:
    """Return how long a wire's planned route in ducts is, and how much of it is kept [m]."""
    nodes, wire = _nodes(plant, wire_id), plant.panel.wire(wire_id)
    board = plant.panel.world_from_panel
    route = tuple(Pose.level(*board.apply(np.array(p)).tolist()) for p in wire.route)
    ducts = [duct for duct in plant.panel.ducts if duct.id in wire.ducts]
    planned = found = 0.0
    for duct in ducts:
        places = places_in(duct, route, plant.panel)
        inside = [_passes_below(nodes, place, duct, ducts, board) for place in places]
        planned += len(inside) * step_in(duct)
        found += sum(inside) * step_in(duct)
    return planned, found


def _nodes(plant: SimulatedPlant, wire_id: str) -> Array:
    """Return the nodes of a wire that was fed, live or parked, from tip to tip; (n, 3) [m]."""
    if plant.live is not None and plant.live.wire.id == wire_id:
        return plant.live.cable.nodes()
    return plant.parked[wire_id].nodes


def _passes_below(
    nodes: Array, place: Pose, duct: Duct, ducts: Sequence[Duct], board: Pose
) -> bool:
    """Return whether a wire crosses a place's plane between walls, below their rim.

    Args:
        nodes: of the wire, (n, 3) [m], world frame.
        place: in the duct.
        duct: the wire passes no further aside of the place than this one is wide.
        ducts: of its route; where two meet, a wire in the one crosses planes of the other.
        board: where the panel lies.
    """
    local = place.inverse().apply(nodes)
    x = local[:, 0]
    for i in np.flatnonzero(x[:-1] * x[1:] <= 0):
        share = x[i] / (x[i] - x[i + 1]) if x[i] != x[i + 1] else 0.0
        crossing = local[i] + share * (local[i + 1] - local[i])
        if abs(crossing[1]) < duct.width and any(
            _is_in(board @ each.panel_from_duct, each, place.apply(crossing)) for each in ducts
        ):
            return True
    return False


def _is_in(place: Pose, duct: Duct, point: Array) -> bool:
    """Return whether a point (3,) [m], world frame, is in a duct at a place, below its rim."""
    x, y, z = place.inverse().apply(point)
    return bool(abs(x) < duct.length / 2 and abs(y) < duct.width / 2 and z < duct.height)


def _end_truth(
    plant: SimulatedPlant, wire_id: str, end: WireEnd, tip: Array, fixed: frozenset[WireEnd]
) -> EndTruth:
    wire = plant.panel.wire(wire_id)
    own, connector = wire.goes_to(end), wire.connector_at(end)
    for component in plant.panel.components:
        for terminal in component.terminals:
            socket = plant.world_from_socket(component.id, terminal.id)
            depth, *aside = socket.inverse().apply(tip)
            if 0 < depth <= terminal.depth + BOTTOM_M and np.abs(aside).max() < terminal.bore / 2:
                bottom = terminal.depth if connector is None else connector.pin_length
                at_bottom = depth >= bottom - BOTTOM_M
                seated = at_bottom and (component.id, terminal.id) == own
                at = f"{component.id}/{terminal.id}"
                return EndTruth(at, float(depth), end in fixed, bool(seated))
    return EndTruth("", 0.0, False, False)
