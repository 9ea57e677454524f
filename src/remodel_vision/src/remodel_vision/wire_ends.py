"""From a picture to the live wire's loose ends and its centreline, in world coordinates.

Ends are blobs of the ferrules' colour, each with the direction in which its wire leaves.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

import cv2
import numpy as np
import numpy.typing as npt

from remodel_states.core.codes import Code
from remodel_vision.cables.lines import arc_lengths
from remodel_vision.colour import ferrule_mask, wire_likelihood
from remodel_vision.laid_wire import WireLines, follow, joined
from remodel_work.camera import Picture
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array
from remodel_work.panel import PanelWire, WireEnd

# A uniform bar of length l has the variance l^2 / 12 along its axis.
BAR = np.sqrt(12.0)
# How far behind the ferrule the wire is searched for, in ferrule widths.
BEHIND_WIDTHS = (0.8, 2.0)


@dataclass(frozen=True, eq=False)
class Ferrule:
    """A ferrule in a picture.

    Attributes:
        centre: (2,) [px].
        out: (2,) unit vector out of the wire, towards the tip.
        length: along the axis [px].
        width: across it [px].
        wire_likelihood: of the colour asked for, 0 to 1, just behind the ferrule.
        truncated: whether it touches the border of the picture.
    """

    centre: Array
    out: Array
    length: float
    width: float
    wire_likelihood: float
    truncated: bool


def find_ferrules(
    rgb: npt.NDArray[np.uint8], likelihood: npt.NDArray[np.float32], min_length_px: float
) -> list[Ferrule]:
    """Return the ferrules in a picture, best match of the wire's colour first.

    Args:
        rgb: (height, width, 3).
        likelihood: (height, width) of the wire's colour.
        min_length_px: shorter blobs are no whole ferrule: most of it hides in an opening.
    """
    mask = ferrule_mask(rgb)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    found = []
    for i in range(1, count):
        x, y, w, h, area = stats[i]
        if area < 4:
            continue
        rows, columns = np.nonzero(labels[y : y + h, x : x + w] == i)
        ferrule = _fit(np.column_stack([columns + x, rows + y]).astype(np.float64), likelihood)
        if ferrule.length >= min_length_px:
            found.append(ferrule)
    return sorted(found, key=lambda f: -f.wire_likelihood)


def _fit(pixels: Array, likelihood: npt.NDArray[np.float32]) -> Ferrule:
    centre = pixels.mean(axis=0)
    # A pixel is itself a square of variance 1/12.
    values, vectors = np.linalg.eigh(np.cov(pixels.T, bias=True) + np.eye(2) / 12)
    width, length = BAR * np.sqrt(values)
    axis = vectors[:, 1]
    behind = {
        sign: _strip(centre, -sign * axis, length, width, likelihood=likelihood) for sign in (-1, 1)
    }
    sign = max(behind, key=lambda s: behind[s])
    height, columns = likelihood.shape
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    truncated = bool(low.min() <= 1 or high[0] >= columns - 2 or high[1] >= height - 2)
    return Ferrule(
        centre=centre,
        out=sign * axis,
        length=float(length),
        width=float(width),
        wire_likelihood=behind[sign],
        truncated=truncated,
    )


def _strip(
    centre: Array,
    direction: Array,
    length: float,
    width: float,
    likelihood: npt.NDArray[np.float32],
) -> float:
    """Return the mean likelihood on the axis just beyond one end of the ferrule."""
    reach = length / 2 + np.linspace(*BEHIND_WIDTHS, 12) * max(width, 2.0)
    points = (centre + reach[:, None] * direction).astype(np.float32)
    values = cv2.remap(likelihood, points[None, :, 0], points[None, :, 1], cv2.INTER_LINEAR)
    return float(values.mean())


# An end is searched for within this distance of where the cell left it [m].
SEARCH_M = 0.15
# Two candidates nearer to each other than this cannot be distinguished [m].
AMBIGUOUS_M = 0.020
# At least this share of a ferrule must be seen.
MIN_FERRULE_SHARE = 0.55
MIN_COLOUR = 0.25
# Half of the depth picture's window over a ferrule [px].
DEPTH_WINDOW_PX = 2
# A wire seen this far above the plate does not lie on it [m].
LIFTED_M = 0.002
# The height of an end in the air is measured over so much of it [m], along its crest, to both
# sides of that [radii]; what is further from the middle of the measurements is something else [m].
STRAIGHT_M = 0.034
CREST_SHARE = 0.4
OUTLIER_M = 0.006


@dataclass(frozen=True, eq=False)
class TipObservation:
    """A loose end as a camera saw it.

    Attributes:
        tip: apex of the ferrule, (3,) [m], world frame.
        out_yaw: direction of the wire out of the tip [rad].
        pitch: by which the wire rises towards the tip [rad].
    """

    tip: Array
    out_yaw: float
    pitch: float = 0.0


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
) -> tuple[dict[WireEnd, EndObservation], WireLines]:
    """Return the expected ends that are seen, and the lines of the wire.

    Args:
        picture: from above.
        wire: whose ends are searched for.
        expected: roughly where each loose end is, (3,) [m], world frame.

    Raises:
        AbilityError: CABLE_TRUNCATED when an end leaves the picture, CABLE_AMBIGUOUS when two may
            be meant.
    """
    lines = WireLines(picture, wire, tuple(float(place[2]) for place in expected.values()))
    likelihood = wire_likelihood(picture.rgb, wire.colour)
    scale = picture.view.metres_per_pixel(wire.radius)
    shortest = MIN_FERRULE_SHARE * wire.ferrule_length / scale
    ferrules = [
        _out_of(lines, f)
        for f in find_ferrules(picture.rgb, likelihood, shortest)
        if f.wire_likelihood >= MIN_COLOUR
    ]
    found: dict[WireEnd, EndObservation] = {}
    for end, place in expected.items():
        observations = [
            EndObservation(_in_world(f, picture, wire, float(place[2])), f) for f in ferrules
        ]
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
        best = near[0]
        if picture.depth is not None and best.tip.tip[2] > wire.radius + LIFTED_M:
            best = _levelled(best, lines)
        connector = wire.connector_at(end)
        found[end] = best if connector is None else best.ahead(connector.pin_length)
    if len(found) == 2 and found[WireEnd.A].ferrule is found[WireEnd.B].ferrule:
        worse = max(found, key=lambda e: _apart(found[e], expected[e]))
        del found[worse]
    return found, lines


def _out_of(lines: WireLines, ferrule: Ferrule) -> Ferrule:
    """Return a ferrule, turned around where the wire is seen to go on at its other end only."""
    half = ferrule.length / 2 * ferrule.out
    if lines.continue_from(ferrule.centre - half, -ferrule.out):
        return ferrule
    ahead = lines.continue_from(ferrule.centre + half, ferrule.out)
    return replace(ferrule, out=-ferrule.out) if ahead else ferrule


def _apart(observation: EndObservation, place: Array) -> float:
    return float(np.linalg.norm((observation.tip.tip - place)[:2]))


def _in_world(ferrule: Ferrule, picture: Picture, wire: PanelWire, z: float) -> TipObservation:
    """Return the tip half a ferrule ahead of the blob's centre, its axis at about z [m].

    Its outline blurs, its centre does not.
    """
    view = picture.view
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


def _levelled(observation: EndObservation, lines: WireLines) -> EndObservation:
    """Return an end that does not lie on the plate, its height and pitch measured by depth."""
    wire, picture = lines.wire, lines.picture
    view, depth = picture.view, picture.depth
    assert depth is not None, "the overhead camera measures depth"
    line = line_from(observation, lines)
    scale = view.metres_per_pixel(float(observation.tip.tip[2]))
    along = np.arange(0.0, STRAIGHT_M, scale / 2)
    middle = np.column_stack([np.interp(along / scale, arc_lengths(line), c) for c in line.T])
    ferrule = observation.ferrule.out
    aside = CREST_SHARE * wire.radius / scale * np.array([-ferrule[1], ferrule[0]])
    pixels = np.vstack([middle - aside, middle, middle + aside])
    columns, rows = np.rint(pixels).astype(int).T
    inside = (rows >= 0) & (columns >= 0) & (rows < depth.shape[0]) & (columns < depth.shape[1])
    depths = depth[rows[inside], columns[inside]]
    heights = view.at_depth(pixels[inside], depths)[:, 2] - wire.radius
    back = np.tile(along, 3)[inside]
    near = np.abs(heights - np.median(heights)) < OUTLIER_M
    slope, height = np.polyfit(back[near], heights[near], 1)
    tip = _in_world(observation.ferrule, picture, wire, float(height))
    return replace(observation, tip=replace(tip, pitch=math.atan(-slope)))


def line_from(observation: EndObservation, lines: WireLines) -> Array:
    """Return the wire's centreline (n, 2) [px] from the tip on, no longer than the wire."""
    ferrule = observation.ferrule
    tail = ferrule.centre - ferrule.out * ferrule.length / 2
    tip = lines.picture.view.project(observation.tip.tip)
    behind = follow(lines.pieces, tail, -ferrule.out, lines.width, lines.length - ferrule.length)
    return np.vstack([tip, ferrule.centre[None], behind])


def line_between(
    observations: tuple[EndObservation, EndObservation], lines: WireLines
) -> Array | None:
    """Return the wire's centreline (n, 2) [px] from one tip to the other.

    None where what is seen from one end on does not meet what is seen from the other.
    """
    first, last = (line_from(observation, lines) for observation in observations)
    return joined(first, last, lines.width, lines.length)
