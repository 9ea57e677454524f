"""Components as cameras see them; the pose of a device without label by outline and screws.

The design gives outline and screws. A picture is searched around where the device should stand
for the pose at which most of these edges lie on edges of the picture; there must be one such
place only. Then each point of an edge is measured across the edge, and the pose is moved until
all fit best (Gauss and Newton, Tukey's weights). The edge of the top is the first one that is met
on the way out of the device: behind it come its neighbours, ducts and wires. A device stands
upright on its rail or the plate, so it has three degrees of freedom, and its height is that of
the design: with two pictures from different places another height shows, as they do not agree.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from remodel_work.camera import Picture, View
from remodel_work.component_shape import SCREW_ABOVE_M, screw_heads
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Component, Panel

# Keeps normal equations solvable when pictures do not determine all motions.
DAMPING = 1e-9


@dataclass(frozen=True)
class Deviations:
    """How far a pose can be relied on.

    Attributes:
        shift: standard deviation of the component's corners [m], leaving out part after part.
        turn: the same of its direction [rad].
        apart: how far single pictures would move the component along the plate [m].
    """

    shift: float
    turn: float
    apart: float

    def within(self, limits: Deviations) -> bool:
        """Return whether the pose follows from all parts and pictures alike."""
        certain = self.shift <= limits.shift and self.turn <= limits.turn
        return certain and self.apart <= limits.apart


@dataclass(frozen=True, eq=False)
class ComponentObservation:
    """A component as seen.

    Attributes:
        world_from_component: upright on the plate, unless two views or more show otherwise.
        residual: RMS distance of the edges seen from those of the pose [m].
        shown: share of what should be seen that is, 0 to 1.
        corners: (4, 2) of its label, or of its top, in the last picture [px].
        clear: whether it is seen well enough for more pictures to be added.
        reliable: whether it is, and the pose follows from all its parts and pictures.
    """

    world_from_component: Pose
    residual: float
    shown: float
    corners: Array
    clear: bool
    reliable: bool


def solved(normal: Array, pull: Array) -> Array:
    """Return the least motion (k,) that normal equations (k, k), (k,) ask for."""
    damping = DAMPING * np.trace(normal) * np.eye(len(pull))
    return np.asarray(np.linalg.lstsq(normal + damping, pull, rcond=None)[0])


def deviations_of(
    parts: Array, pictures: Array, along: list[int], motions: Array, arms: Array
) -> Deviations:
    """Return how far parts and pictures are apart at a pose, each in one step of Gauss and Newton.

    The covariance is that of the jackknife, which needs no model of the noise: what covers a
    component is none. Reference: B. Efron and C. Stein, The jackknife estimate of variance, 1981.

    Args:
        parts: (p, k, k + 1) normal equations of each part, and what they pull with.
        pictures: (q, k, k + 1) the same of each picture.
        along: which of the k motions lead along the plate, or turn on it: x, y, yaw.
        motions: (k, 6) shift [m] and turn [rad], world frame, of a step of each motion.
        arms: (n, 3) from the turn's centre to points whose shifts count [m], world frame.
    """
    whole = parts.sum(axis=0)
    steps = [solved(left[:, :-1], left[:, -1]) @ motions for left in whole - parts]
    moved = np.array(steps) * math.sqrt((len(parts) - 1) / len(parts))
    shifts = moved[:, None, :3] + np.cross(moved[:, None, 3:], arms)
    apart = [solved(own[np.ix_(along, along)], own[along, -1]) @ motions[along] for own in pictures]
    return Deviations(
        shift=float(np.sqrt(np.sum(np.square(shifts), axis=(0, 2))).max()),
        turn=float(np.linalg.norm(moved[:, 3:])),
        apart=max(float(np.linalg.norm(step[:2])) for step in apart),
    )


# Points on edges are so far apart, and from corners [m].
STEP_M, OFF_CORNER_M = 0.001, 0.001
# Around its expected place a device is searched this far along y and x [m], and about z [rad].
SEARCH_Y_M, SEARCH_X_M, SEARCH_STEP_M = 0.008, 0.006, 0.0005
TURNS = np.radians(np.arange(-2.5, 2.6, 0.5))
# Along a row it is searched no further than this share of the way to the next device like it.
TO_NEXT = 0.45
# Blur of pictures for the search and for measuring, standard deviations [px].
SEARCH_BLUR_PX, BLUR_PX = 1.5, 1.0
# An edge that counts fully in the search, and the least one that is measured [levels/px].
FULL_EDGE, LEAST_EDGE = 8.0, 3.0
# The least mean over all points at the best place, from 0 to 1; and how much less it is at any
# other place, further away than this [m].
LEAST_SCORE, UNIQUE, APART_M = 0.45, 0.85, 0.0025
# Points of so many that a picture must show.
LEAST_IN_PICTURE = 0.6
# How far across an edge it is measured, round after round [px], in steps of this.
ACROSS_PX, SAMPLE_PX = (6.0, 4.0, 3.0, 3.0, 3.0, 3.0), 0.5
# Tukey's biweight [px].
TUKEY_PX = 1.5
# A point is on its edge when it is so near [px].
FITS_PX = 0.8
# A device is seen well when so much of its outline and of its screws fits.
LEAST_OUTLINE, LEAST_SCREWS = 0.5, 0.7
# A pose is relied on up to these deviations.
MOST = Deviations(shift=0.00025, turn=math.radians(0.25), apart=0.0003)
# Motions of a round: shifts [m] and a turn [rad], and the same as motions of the world.
STEPS = np.array([1e-4, 1e-4, 1e-3])
MOTIONS = np.zeros((3, 6))
MOTIONS[[0, 1, 2], [0, 1, 5]] = STEPS
# The top and the picture's measured height of it differ by no more than this [m], over this share.
HEIGHT_M, LEAST_TOP = 0.0025, 0.6
TOP_MARGIN_M = 0.004

Levels = npt.NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Edges:
    """Points on the edges of a device, in its frame.

    Attributes:
        points: (n, 3) [m].
        outward: (n, 2) directions in the plane of the top, out of what the edge belongs to.
        of_screw: (n,) whether a point is on a screw's head, which is brighter than the top.
        part: (n,) number of the part that is left out together.
    """

    points: Array
    outward: Array
    of_screw: npt.NDArray[np.bool_]
    part: npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class DeviceView:
    """A picture that shows a device, and the pose at which it was found there."""

    picture: Picture
    pose: Pose


def device_edges(component: Component) -> Edges:
    """Return the outline of a device's top and those of its screws."""
    depth, width, height = component.size
    squares = [((0.0, 0.0, height), depth, width)]
    squares += [
        ((x, y, z + SCREW_ABOVE_M), side, side) for (x, y, z), side in screw_heads(component)
    ]
    points, outward, screw, part = [], [], [], []
    for i, ((x, y, z), along, across) in enumerate(squares):
        for side in range(4):
            c, s = ((1, 0), (0, 1), (-1, 0), (0, -1))[side]
            out, length = (along, across) if side % 2 == 0 else (across, along)
            run = np.arange(-length / 2 + OFF_CORNER_M, length / 2 - OFF_CORNER_M + 1e-9, STEP_M)
            points += [(x + c * out / 2 - s * r, y + s * out / 2 + c * r, z) for r in run]
            outward += [(c, s)] * len(run)
            screw += [i > 0] * len(run)
            # Halves of each side, and the screws by where they are.
            part += [2 * side + int(r > 0) if i == 0 else 8 + (i - 1) % 4 for r in run]
    return Edges(np.array(points), np.array(outward, float), np.array(screw), np.array(part))


def search_device(
    picture: Picture, panel: Panel, component: Component, near: Pose
) -> DeviceView | None:
    """Return the one place in a picture where a device is found; None when there is none.

    Args:
        picture: from above.
        panel: on which the device stands, for what else looks like it.
        component: the device.
        near: where it should stand, world frame.
    """
    edges = device_edges(component)
    reach_y = min(SEARCH_Y_M, TO_NEXT * _to_next(panel, component))
    grey = _blurred(picture, SEARCH_BLUR_PX)
    slope_x, slope_y = (
        np.asarray(cv2.Scharr(grey, cv2.CV_32F, *way) / 32, np.float32) for way in ((1, 0), (0, 1))
    )
    dx, dy = np.meshgrid(
        np.arange(-SEARCH_X_M, SEARCH_X_M + 1e-9, SEARCH_STEP_M),
        np.arange(-reach_y, reach_y + 1e-9, SEARCH_STEP_M),
        indexing="ij",
    )
    shifts = np.column_stack([dx.ravel(), dy.ravel()])
    # From straight above, a shift on the plate is one of the picture.
    centre = near.apply(np.array([0.0, 0.0, component.size[2]]))
    moved = picture.view.project(centre + np.array([[0, 0, 0], [1e-3, 0, 0], [0, 1e-3, 0]]))
    pixels_per_m = (moved[1:] - moved[0]) / 1e-3
    offsets = shifts @ pixels_per_m
    scores = []
    for turn in TURNS:
        pose = near @ Pose.level(0.0, 0.0, 0.0, turn)
        pixels, normals = _seen(edges, picture.view, pose)
        scores.append(_scores(slope_x, slope_y, pixels, normals, edges.of_screw, offsets))
    score = np.array(scores)
    turn_at, shift_at = np.unravel_index(int(score.argmax()), score.shape)
    best, found = float(score.max()), shifts[shift_at]
    far = np.linalg.norm(shifts - found, axis=1) > APART_M
    at_border = np.any(np.abs(found) > np.array([SEARCH_X_M, reach_y]) - SEARCH_STEP_M)
    if best < LEAST_SCORE or at_border or score[:, far].max(initial=0.0) > UNIQUE * best:
        return None
    x, y, z = (float(v) for v in near.position)
    yaw = near.yaw + float(TURNS[turn_at])
    return DeviceView(picture, Pose.level(x + found[0], y + found[1], z, yaw))


def _blurred(picture: Picture, sigma_px: float) -> Levels:
    grey = cv2.cvtColor(picture.rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
    return np.asarray(cv2.GaussianBlur(grey, (0, 0), sigma_px), np.float32)


def _to_next(panel: Panel, component: Component) -> float:
    """Return how far away the next device of that size is [m]; infinite if there is none."""
    return min(
        (
            math.dist(other.pose[:2], component.pose[:2])
            for other in panel.components
            if other.id != component.id and np.allclose(other.size, component.size, atol=1e-3)
        ),
        default=math.inf,
    )


def _seen(edges: Edges, view: View, pose: Pose) -> tuple[Array, Array]:
    """Return edges in a picture: points (n, 2) [px], and unit directions out of them (n, 2)."""
    pixels = view.project(pose.apply(edges.points))
    beyond = edges.points + 1e-3 * np.column_stack([edges.outward, np.zeros(len(edges.points))])
    normals = view.project(pose.apply(beyond)) - pixels
    return pixels, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def _scores(
    slope_x: Levels,
    slope_y: Levels,
    pixels: Array,
    normals: Array,
    of_screw: npt.NDArray[np.bool_],
    offsets: Array,
) -> Array:
    """Return how well edges fit a picture at each offset (m, 2) [px]: 0 to 1."""
    height, width = slope_x.shape
    columns = np.rint(pixels[None, :, 0] + offsets[:, None, 0]).astype(np.int32)
    rows = np.rint(pixels[None, :, 1] + offsets[:, None, 1]).astype(np.int32)
    inside = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    columns, rows = columns.clip(0, width - 1), rows.clip(0, height - 1)
    slope = slope_x[rows, columns] * normals[:, 0] + slope_y[rows, columns] * normals[:, 1]
    fits = np.where(of_screw, -slope, np.abs(slope)) / FULL_EDGE
    fits = np.where(inside, fits.clip(0.0, 1.0), 0.0)
    kinds = [fits[:, kind].mean(axis=1) for kind in (of_screw, ~of_screw) if kind.any()]
    return np.asarray(np.mean(kinds, axis=0))


def locate_device(component: Component, views: Sequence[DeviceView]) -> ComponentObservation:
    """Return the pose of a device at which its edges lie on those of all pictures."""
    edges = device_edges(component)
    greys = [_blurred(view.picture, BLUR_PX) for view in views]
    pose = views[-1].pose
    for across in ACROSS_PX:
        measured = [
            _measure(grey, view.picture.view, edges, pose, across)
            for grey, view in zip(greys, views, strict=True)
        ]
        terms = sum(m.terms.sum(axis=0) for m in measured)
        x, y, yaw = solved(terms[:, :-1], terms[:, -1]) * STEPS
        px, py, pz = (float(v) for v in pose.position)
        pose = Pose.level(px + float(x), py + float(y), pz, pose.yaw + float(yaw))
    parts = np.zeros((int(edges.part.max()) + 1, 3, 4))
    for m in measured:
        np.add.at(parts, edges.part, m.terms)
    half = np.array(component.size[:2]) / 2
    corners = np.array([[1, 1], [1, -1], [-1, -1], [-1, 1]]) * half
    top = np.column_stack([corners, np.full(4, component.size[2])])
    arms = np.column_stack([corners, np.zeros(4)]) @ pose.rotation.T
    pictures = np.array([m.terms.sum(axis=0) for m in measured])
    deviations = deviations_of(parts, pictures, [0, 1, 2], MOTIONS, arms)
    inside = np.concatenate([m.inside for m in measured])
    fits = np.concatenate([m.fits for m in measured])
    screw = np.tile(edges.of_screw, len(views))
    shares = [
        float(np.mean(fits[kind & inside])) >= least
        for kind, least in ((screw, LEAST_SCREWS), (~screw, LEAST_OUTLINE))
        if np.any(kind & inside)
    ]
    clear = all(shares) and float(np.mean(inside)) >= LEAST_IN_PICTURE
    metres = views[-1].picture.view.metres_per_pixel(component.size[2])
    away = np.concatenate([m.away for m in measured])[fits]
    return ComponentObservation(
        world_from_component=pose,
        residual=metres * float(np.sqrt(np.mean(np.square(away)))) if len(away) else math.inf,
        shown=float(np.mean(fits[inside])) if np.any(inside) else 0.0,
        corners=views[-1].picture.view.project(pose.apply(top)),
        clear=clear,
        reliable=clear and deviations.within(MOST),
    )


@dataclass(frozen=True, eq=False)
class _Measured:
    """The edges of a device as measured in one picture.

    Attributes:
        away: (n,) from where they should be, outward [px].
        inside: (n,) whether a point lies in the picture.
        fits: (n,) whether its edge is seen there.
        terms: (n, 3, 4) normal equations of each point, and what it pulls with.
    """

    away: Array
    inside: npt.NDArray[np.bool_]
    fits: npt.NDArray[np.bool_]
    terms: Array


def _measure(grey: Levels, view: View, edges: Edges, pose: Pose, across: float) -> _Measured:
    pixels, normals = _seen(edges, view, pose)
    along = np.arange(-across, across + SAMPLE_PX / 2, SAMPLE_PX)
    # One sample more at each end, for the slope.
    reach = np.concatenate([[along[0] - SAMPLE_PX], along, [along[-1] + SAMPLE_PX]])
    places = (pixels[:, None] + reach[None, :, None] * normals[:, None]).astype(np.float32)
    levels = cv2.remap(grey, places[..., 0], places[..., 1], cv2.INTER_LINEAR)
    slope = (levels[:, 2:] - levels[:, :-2]) / (2 * SAMPLE_PX)
    strength = np.where(edges.of_screw[:, None], -slope, np.abs(slope)).astype(np.float64)
    peak = _peaks(strength, edges.of_screw)
    rows = np.arange(len(strength))
    at = peak.clip(1, len(along) - 2)
    before, middle, after = (strength[rows, at + k] for k in (-1, 0, 1))
    bend = before - 2 * middle + after
    finer = np.where(bend < 0, (before - after) / np.where(bend < 0, 2 * bend, 1.0), 0.0)
    away = along[at] + SAMPLE_PX * finer.clip(-1, 1)
    height, width = grey.shape
    limit = np.array([width, height]) - 1 - across
    inside = np.all((pixels >= across) & (pixels <= limit), axis=1)
    found = (peak >= 0) & inside
    change = np.empty((len(pixels), 3))
    for k, (x, y, yaw) in enumerate(np.diag(STEPS)):
        px, py, pz = (float(v) for v in pose.position)
        moved = Pose.level(px + x, py + y, pz, pose.yaw + yaw)
        change[:, k] = np.sum((view.project(moved.apply(edges.points)) - pixels) * normals, axis=1)
    weight = found * np.square(np.clip(1 - np.square(away / max(TUKEY_PX, across / 2)), 0.0, None))
    beside = np.column_stack([change, away])
    terms = (weight[:, None] * change)[:, :, None] * beside[:, None, :]
    return _Measured(away, inside, found & (np.abs(away) < FITS_PX), terms)


def _peaks(strength: Array, of_screw: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Return where each row has its edge: a screw's strongest, else the first; -1: none."""
    peaks = np.zeros(strength.shape, bool)
    inner = strength[:, 1:-1]
    peaks[:, 1:-1] = (inner >= strength[:, :-2]) & (inner > strength[:, 2:]) & (inner > LEAST_EDGE)
    strongest = np.where(peaks, strength, 0.0).argmax(axis=1)
    first = peaks.argmax(axis=1)
    return np.where(peaks.any(axis=1), np.where(of_screw, strongest, first), -1)


def stands_there(picture: Picture, component: Component, pose: Pose) -> bool:
    """Return whether depth shows the flat top of a device at a pose, as high as it should be."""
    assert picture.depth is not None, "the camera from above measures depth"
    depth, width, height = component.size
    x = np.arange(-depth / 2 + TOP_MARGIN_M, depth / 2 - TOP_MARGIN_M + 1e-9, STEP_M)
    y = np.arange(-width / 2 + TOP_MARGIN_M, width / 2 - TOP_MARGIN_M + 1e-9, STEP_M)
    grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    points = pose.apply(np.column_stack([grid, np.full(len(grid), height)]))
    pixels = np.rint(picture.view.project(points)).astype(int)
    limit = np.array(picture.depth.shape[::-1])
    pixels = pixels[np.all((pixels >= 0) & (pixels < limit), axis=1)]
    if not len(pixels):
        return False
    depths = picture.depth[pixels[:, 1], pixels[:, 0]]
    heights = picture.view.at_depth(pixels.astype(np.float64), depths)[:, 2]
    near = np.abs(heights - height) < 3 * HEIGHT_M
    flat = abs(float(np.median(heights[near])) - height) < HEIGHT_M if near.any() else False
    return bool(flat and near.mean() >= LEAST_TOP)
