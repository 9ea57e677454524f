"""From a picture to the live wire's loose ends and its centreline, in world coordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import numpy.typing as npt

from remodel_sim.core.belief.belief_state import TipObservation
from remodel_sim.core.camera import Picture
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Array
from remodel_sim.core.vision.cables.curves.polyline import arc_lengths
from remodel_sim.core.vision.colour import wire_likelihood
from remodel_sim.core.vision.ferrules import Ferrule, find_ferrules
from remodel_sim.core.vision.tracing import trace
from remodel_sim.core.workpiece.panel import PanelWire, WireEnd
from remodel_states.core.codes import Code

# An end is searched for within this distance of where the cell left it [m].
SEARCH_M = 0.15
# Two candidates nearer to each other than this cannot be distinguished [m].
AMBIGUOUS_M = 0.020
# At least this share of a ferrule must be seen.
MIN_FERRULE_SHARE = 0.55
MIN_COLOUR = 0.25
# Half of the depth picture's window over a ferrule [px].
DEPTH_WINDOW_PX = 2
# Lines traced from both ends meet within so many widths: a fork hides that much. A pixel of length
# too much or too little counts as so many of a gap.
MEETING_WIDTHS, LENGTH_PRICE = 6.0, 0.2
# A wire seen this far above the plate does not lie on it [m].
LIFTED_M = 0.002


@dataclass(frozen=True, eq=False)
class EndObservation:
    """A loose end in a picture and in the world.

    Attributes:
        tip: what it is in the world.
        ferrule: what it is in the picture.
    """

    tip: TipObservation
    ferrule: Ferrule

    def ahead(self, length: float) -> EndObservation:
        """Return the sighting of a tip so far before the mark [m]: a connector's pins."""
        yaw = self.tip.out_yaw
        out = np.array([math.cos(yaw), math.sin(yaw), 0.0])
        return replace(self, tip=TipObservation(self.tip.tip + length * out, yaw))


def find_ends(
    picture: Picture, wire: PanelWire, expected: dict[WireEnd, Array]
) -> tuple[dict[WireEnd, EndObservation], npt.NDArray[np.float32]]:
    """Return the expected ends that are seen, and the likelihood picture of the wire's colour.

    Args:
        picture: from above.
        wire: whose ends are searched for.
        expected: roughly where each loose end lies, (2,) [m], world frame.

    Raises:
        AbilityError: CABLE_TRUNCATED when an end leaves the picture, CABLE_AMBIGUOUS when two may
            be meant.
    """
    likelihood = wire_likelihood(picture.rgb, wire.colour)
    scale = picture.view.metres_per_pixel(wire.radius)
    shortest = MIN_FERRULE_SHARE * wire.ferrule_length / scale
    observations = [
        EndObservation(_in_world(f, picture, wire), f)
        for f in find_ferrules(picture.rgb, likelihood, shortest)
        if f.wire_likelihood >= MIN_COLOUR
    ]
    found: dict[WireEnd, EndObservation] = {}
    for end, place in expected.items():
        near = sorted(
            (s for s in observations if _apart(s, place) <= SEARCH_M),
            key=partial(_apart, place=place),
        )
        if not near:
            continue
        if near[0].ferrule.truncated:
            raise AbilityError(
                Code.CABLE_TRUNCATED,
                f"end {end.value} of {wire.id!r} leaves the picture; feed the wire again",
            )
        rivals = [s for s in near[1:] if _apart(s, place) - _apart(near[0], place) < AMBIGUOUS_M]
        if rivals and len(expected) == 1:
            raise AbilityError(
                Code.CABLE_AMBIGUOUS,
                f"{1 + len(rivals)} ends of that colour lie where end {end.value} of {wire.id!r} "
                "may be",
            )
        connector = wire.connector_at(end)
        found[end] = near[0] if connector is None else near[0].ahead(connector.pin_length)
    if len(found) == 2 and found[WireEnd.A].ferrule is found[WireEnd.B].ferrule:
        worse = max(found, key=lambda e: _apart(found[e], expected[e]))
        del found[worse]
    return found, likelihood


def _apart(observation: EndObservation, place: Array) -> float:
    return float(np.linalg.norm(observation.tip.tip[:2] - place))


def _in_world(ferrule: Ferrule, picture: Picture, wire: PanelWire) -> TipObservation:
    """Return the tip half a ferrule ahead of the blob's centre.

    Its outline blurs, its centre does not.
    """
    view, z = picture.view, wire.radius
    if picture.depth is not None:
        column, row = np.rint(ferrule.centre).astype(int)
        rows = slice(max(0, row - DEPTH_WINDOW_PX), row + DEPTH_WINDOW_PX + 1)
        columns = slice(max(0, column - DEPTH_WINDOW_PX), column + DEPTH_WINDOW_PX + 1)
        window = picture.depth[rows, columns]
        # The nearest quarter is the ferrule's crest; its median is free of the plate beside it.
        crest = float(np.quantile(window, 0.25))
        top = float(view.at_depth(ferrule.centre, np.array([crest]))[0, 2])
        if top - wire.radius > z + LIFTED_M:
            z = top - wire.radius
    half = ferrule.length / 2
    points = np.array([ferrule.centre, ferrule.centre + half * ferrule.out])
    centre, ahead = view.on_plane(points, z)
    out = (ahead - centre) / np.linalg.norm(ahead - centre)
    yaw = math.atan2(out[1], out[0])
    return TipObservation(centre + out * wire.ferrule_length / 2, yaw)


def trace_from(
    observation: EndObservation,
    picture: Picture,
    likelihood: npt.NDArray[np.float32],
    wire: PanelWire,
) -> Array:
    """Return the wire's centreline (n, 2) [px] from the tip on.

    It is no longer than the wire: on a plate of the wire's colour nothing stops the tracer.
    """
    ferrule = observation.ferrule
    width = max(2.0, wire.diameter / picture.view.metres_per_pixel(wire.radius))
    tail = ferrule.centre - ferrule.out * (ferrule.length / 2 + 0.5 * width)
    behind = trace(likelihood, tail, -ferrule.out, width)
    tip = picture.view.project(observation.tip.tip)
    line = np.vstack([tip, ferrule.centre[None], behind])
    longest = wire.length / picture.view.metres_per_pixel(wire.radius)
    return line[: int(np.searchsorted(arc_lengths(line), longest, side="right"))]


def trace_between(
    observations: tuple[EndObservation, EndObservation],
    picture: Picture,
    likelihood: npt.NDArray[np.float32],
    wire: PanelWire,
) -> Array | None:
    """Return the wire's centreline (n, 2) [px] from one tip to the other.

    It is traced from both, and joined where the two lines meet and the whole is as long as the
    wire; None where they do not meet.
    """
    first, last = (
        trace_from(observation, picture, likelihood, wire) for observation in observations
    )
    gaps = np.linalg.norm(first[:, None] - last[None], axis=2)
    longest = wire.length / picture.view.metres_per_pixel(wire.radius)
    lengths = arc_lengths(first)[:, None] + arc_lengths(last)[None] + gaps
    cost = gaps + LENGTH_PRICE * np.abs(lengths - longest)
    i, j = np.unravel_index(int(np.argmin(cost)), cost.shape)
    if gaps[i, j] > MEETING_WIDTHS * wire.diameter / picture.view.metres_per_pixel(wire.radius):
        return None
    return np.vstack([first[: i + 1], last[j::-1]])
