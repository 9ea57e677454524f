"""The pose of a component by its labels: their drawing, fitted to the grey levels of pictures."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from remodel_vision.colour import Pixels
from remodel_vision.device_pose import ComponentObservation, Deviations, deviations_of, solved
from remodel_work.camera import Picture
from remodel_work.component_shape import (
    LABEL_CELLS,
    LABEL_MARGIN_CELLS,
    label_corners,
    marker_cells,
)
from remodel_work.geometry import Array, Pose, multiply_quaternions
from remodel_work.panel import Component

# Samples of the drawing per cell, and white cells around its black square.
FINE = 16
MARGIN = int(LABEL_MARGIN_CELLS)
# So much of the white margin takes part [cells]: what lies beyond it blurs into its rim.
RIM_CELLS = 0.6
# So many samples are taken per cell and axis, at least, of labels that have them.
SAMPLES_PER_CELL = 6
# Pictures are blurred by this standard deviation [px]: edges sharper than a pixel are hard to move.
SMOOTH_PX = 1.0


class LabelPatch:
    """The pixels of one picture that show a label.

    Attributes:
        levels: (n,) grey levels.
        even: (n, 2) the pixels' places on the label, -0.5 to 0.5, for light that is not even.
        valid: (n,) which of them take part.
        scale: size of a sample of the drawing [m].
    """

    def __init__(self, component: Component, picture: Picture, corners: Array) -> None:
        """Cut out the label located at corners (4, 2) [px]."""
        self._size = component.marker_size
        self.scale = component.marker_size / (LABEL_CELLS * FINE)
        self._drawing = _drawing(component.marker_id)
        self._layers: dict[float, tuple[Pixels, Pixels, Pixels]] = {}
        square = corners.astype(np.float32)
        flat = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)
        self._cell_px = float(np.sqrt(abs(cv2.contourArea(square)))) / LABEL_CELLS
        reach = 1.5 * RIM_CELLS * self._cell_px
        limit = np.array([picture.rgb.shape[1], picture.rgb.shape[0]]) - 1
        low = np.clip(np.floor(corners.min(axis=0) - reach), 0, limit).astype(int)
        high = np.clip(np.ceil(corners.max(axis=0) + reach), 0, limit).astype(int)
        step = max(1, int(self._cell_px / SAMPLES_PER_CELL))
        columns, rows = np.meshgrid(
            np.arange(low[0], high[0] + 1, step), np.arange(low[1], high[1] + 1, step)
        )
        pixels = np.column_stack([columns.ravel(), rows.ravel()])
        to_label = cv2.getPerspectiveTransform(square, flat)
        even = cv2.perspectiveTransform(pixels[None].astype(np.float64), to_label)[0] - 0.5
        inside = np.all(np.abs(even) < 0.5 + RIM_CELLS / LABEL_CELLS, axis=1)
        window = picture.rgb[low[1] : high[1] + 1, low[0] : high[0] + 1]
        grey = cv2.cvtColor(window, cv2.COLOR_RGB2GRAY).astype(np.float32)
        smooth = cv2.GaussianBlur(grey, (0, 0), SMOOTH_PX)
        self.even = np.asarray(even[inside], np.float64)
        self.valid = np.ones(len(self.even), bool)
        self._inside, self._shape = inside, columns.shape
        self._step = step
        self.levels = smooth[::step, ::step].ravel()[inside].astype(np.float64)
        self._eye = picture.view.world_from_camera.position
        self._rays = picture.view.on_plane(pixels[inside], self._eye[2] - 1.0) - self._eye

    def drop(self, covered: npt.NDArray[np.bool_], cells: float) -> None:
        """Let pixels (n,) that something covers, and those that near [cells], take no part."""
        image = np.zeros(self._inside.shape, np.uint8)
        image[self._inside] = covered & self.valid
        reach = 2 * max(1, round(cells * self._cell_px / self._step)) + 1
        kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
        self.valid &= cv2.dilate(image.reshape(self._shape), kernel).ravel()[self._inside] == 0

    def shown(self, blur_px: float, places: Array) -> tuple[Array, Array]:
        """Return the drawing's level (n,), from 0 to 1, and its gradient at places (n, 2).

        Args:
            blur_px: standard deviation of the lens's blur [px].
            places: as `places` returns them.
        """
        maps = places.astype(np.float32)[None]
        level, *slope = (
            cv2.remap(
                layer, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
            )[0].astype(np.float64)
            for layer in self._blurred(blur_px)
        )
        return level, np.column_stack(slope)

    def _blurred(self, blur_px: float) -> tuple[Pixels, Pixels, Pixels]:
        """Return the drawing as a lens with that blur shows it, and its gradient."""
        if blur_px not in self._layers:
            whole = math.hypot(blur_px, SMOOTH_PX) / self._cell_px * FINE
            level = cv2.GaussianBlur(self._drawing, (0, 0), whole)
            along, down = (cv2.Scharr(level, cv2.CV_32F, *way) / 32 for way in ((1, 0), (0, 1)))
            self._layers[blur_px] = level, along, down
        return self._layers[blur_px]

    def places(self, world_from_label: Pose) -> Array:
        """Return where the pixels lie on the drawing (n, 2) when the label is at a pose."""
        turn = world_from_label.rotation
        gap = world_from_label.position - self._eye
        depth = (gap @ turn[:, 2]) / (self._rays @ turn[:, 2])
        local = (self._rays * depth[:, None] - gap) @ turn[:, :2] / self._size
        cells = (local * [1.0, -1.0] + 0.5) * LABEL_CELLS + MARGIN
        return np.asarray(cells * FINE - 0.5, np.float64)


def _drawing(marker_id: int) -> Pixels:
    cells = np.pad(marker_cells(marker_id) > 0, MARGIN, constant_values=True)
    return np.kron(cells, np.ones((FINE, FINE))).astype(np.float32)


# Blurs of the lens that are tried: standard deviations [px]; the first fit takes the one before.
BLURS_PX = (0.5, 0.8, 1.2, 1.7, 2.4, 3.4)
FIRST_BLUR_PX = 1.0
# A motion of a label is three shifts [m] and three turns about its middle [rad], along and about
# the world's axes. These are the ones of an upright component, and of any.
UPRIGHT, FREE = (0, 1, 5), (0, 1, 2, 3, 4, 5)
# Steps of the numeric derivatives [m], [rad].
STEPS = np.array([2e-5, 2e-5, 2e-5, 1e-3, 1e-3, 1e-3])
MAX_ROUNDS = 12
# Rounds end with motions that are this small, in steps of the derivatives.
STILL = 0.05
# Tukey's biweight: differences count less and less up to this share of the contrast.
TUKEY = 0.6
# What differs by more than this share of the contrast is not the label.
OUTLIER = 0.25
# The least difference of a label's white and black that is divided by [grey levels].
LEAST_CONTRAST = 5.0
# Six degrees of freedom are taken when they lower the cost to this share.
CLEARLY_BETTER = 0.8
# A label is seen well when so much of it looks as it should, and its edges lie so near to those of
# the pose found [m].
LEAST_SHOWN, MOST_RESIDUAL_M = 0.6, 0.0005
# Next to what covers a label, so much of it is dropped [cells].
BESIDE_CELLS = 0.5
# A pose is relied on when its standard deviations are at most these, at the component's corners [m]
# and in direction [rad], and no picture alone moves the label by more along the plate [m].
MOST = Deviations(shift=0.0012, turn=math.radians(1.2), apart=0.0004)
# A component leans or is lifted when it does so by more than this, and by more than so many of the
# standard deviations.
UPRIGHT_RAD, UPRIGHT_M = math.radians(1.0), 0.001
SIGNIFICANT = 2.5
# Nor is one upright that may be tilted by more than this; half of it, if the label is covered.
MOST_TILT_RAD = math.radians(2.0)
# Pictures without antialiasing show a tilt where there is none: of up to 2.5 degrees for labels of
# 73 px, of 6.4 for 45 px, alike in all parts of the label. Times the label's area [rad px^2].
FALSE_TILT = math.radians(14000.0)
# One picture is enough for an upright component only of a label of which so much is shown, unless
# it is certain how it stands.
WHOLE = 0.97
# A label is left out in so many parts along each side.
PARTS = 3


@dataclass(frozen=True, eq=False)
class LabelView:
    """A picture that shows a label, and roughly where: its corners (4, 2) [px]."""

    picture: Picture
    corners: Array


def locate_component(component: Component, views: Sequence[LabelView]) -> ComponentObservation:
    """Return the pose of a component at which its label looks as it does in all pictures."""
    patches = [
        LabelPatch(component, label_view.picture, label_view.corners) for label_view in views
    ]
    upright = _fit(patches, FIRST_BLUR_PX, _upright_start(component, views[-1]), UPRIGHT)
    start = upright.world_from_label
    blur = min(BLURS_PX, key=lambda px: _compare(patches, px, start).cost(upright.valid))
    free = _fit(patches, blur, start, FREE)
    for patch, rest in zip(patches, free.rests, strict=True):
        patch.drop(np.abs(rest) > OUTLIER, BESIDE_CELLS)
    upright = _fit(patches, blur, start, UPRIGHT)
    free = _fit(patches, blur, free.world_from_label, FREE)
    explained = upright.explained | free.explained
    # Within its own uncertainty a component is upright, as components are.
    best, deviations = upright, _deviations(component, patches, blur, upright, UPRIGHT)
    unsure = _deviations(component, patches, blur, free, FREE)
    tilt, lift = _stance(free.world_from_label, upright)
    leaning = tilt > max(UPRIGHT_RAD, SIGNIFICANT * unsure.turn)
    leaning |= lift > max(UPRIGHT_M, SIGNIFICANT * unsure.shift)
    smallest = min(abs(cv2.contourArea(view.corners.astype(np.float32))) for view in views)
    shows = tilt > FALSE_TILT / smallest or lift > UPRIGHT_M
    ambiguous = False
    if len(views) == 1:
        covered = float(upright.explained.mean()) < WHOLE
        ambiguous = leaning or (covered and not unsure.within(MOST))
    elif shows and free.cost(explained) < CLEARLY_BETTER * upright.cost(explained):
        best, deviations = free if leaning else upright, unsure
        whole = float(best.explained.mean()) >= WHOLE
        ambiguous = not leaning and tilt > (MOST_TILT_RAD if whole else UPRIGHT_RAD)
    shown = float(best.explained.mean())
    height = float(label_corners(component)[0, 2])
    pose = best.world_from_label @ Pose.level(0.0, 0.0, -height)
    clear = shown >= LEAST_SHOWN and best.residual <= MOST_RESIDUAL_M
    return ComponentObservation(
        world_from_component=pose,
        residual=best.residual,
        shown=shown,
        corners=views[-1].picture.view.project(pose.apply(label_corners(component))),
        clear=clear,
        reliable=clear and deviations.within(MOST) and not ambiguous,
    )


def _stance(world_from_label: Pose, upright: _Fit) -> tuple[float, float]:
    """Return the tilt [rad] of a pose, and how far it is above or below an upright one [m]."""
    tilt = math.acos(min(1.0, float(world_from_label.rotation[2, 2])))
    lift = float(world_from_label.position[2] - upright.world_from_label.position[2])
    return tilt, abs(lift)


def _deviations(
    component: Component,
    patches: Sequence[LabelPatch],
    blur_px: float,
    fit: _Fit,
    axes: tuple[int, ...],
) -> Deviations:
    """Return how far the parts of a label, and the pictures, are apart at a pose."""
    parts = np.zeros((PARTS**2, len(axes), len(axes) + 1))
    pictures = np.zeros((len(patches), len(axes), len(axes) + 1))
    for patch, picture in zip(patches, pictures, strict=True):
        own = _differences(patch, blur_px, fit.world_from_label, axes)
        beside = np.column_stack([own.change, own.rest])
        terms = (own.weight[:, None] * own.change)[:, :, None] * beside[:, None, :]
        place = np.clip(((patch.even + 0.5) * PARTS).astype(int), 0, PARTS - 1) @ [PARTS, 1]
        np.add.at(parts, place, terms)
        picture += terms.sum(axis=0)
    along = [i for i, axis in enumerate(axes) if axis in UPRIGHT]
    corners = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-1.0, 0.0)])
    arms = (corners * component.size) @ fit.world_from_label.rotation.T
    return deviations_of(parts, pictures, along, np.diag(STEPS)[list(axes)], arms)


def _upright_start(component: Component, label_view: LabelView) -> Pose:
    """Return the label's upright frame nearest to its corners (Procrustes)."""
    model = label_corners(component)
    height = float(model[0, 2])
    seen = label_view.picture.view.on_plane(label_view.corners, height)[:, :2]
    middle = seen.mean(axis=0)
    a, b = model[:, :2], seen - middle
    cross = float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))
    yaw = math.atan2(cross, float(np.sum(a * b)))
    return Pose.level(float(middle[0]), float(middle[1]), height, yaw)


@dataclass(frozen=True, eq=False)
class _Fit:
    """How well a drawing fits at a pose, and which motion would improve it.

    Attributes:
        world_from_label: the pose.
        normal: (k, k) and
        pull: (k,) of the normal equations of the motion; k = 0 where none was asked for.
        rests: (n,) differences of all pixels of each patch, in contrasts.
        valid: (n,) which pixels of all patches take part.
        residual: RMS distance of the edges seen from the drawing's [m].
    """

    world_from_label: Pose
    normal: Array
    pull: Array
    rests: Sequence[Array]
    valid: npt.NDArray[np.bool_]
    residual: float

    @property
    def explained(self) -> npt.NDArray[np.bool_]:
        """Which pixels (n,) show the label."""
        return self.valid & (np.abs(np.concatenate(self.rests)) < OUTLIER)

    def cost(self, of: npt.NDArray[np.bool_]) -> float:
        """Return the sum of squares of some pixels' differences, each cut at OUTLIER."""
        rest = np.concatenate(self.rests)[of]
        return float(np.sum(np.minimum(np.square(rest), OUTLIER**2)))


def _fit(patches: Sequence[LabelPatch], blur_px: float, pose: Pose, axes: tuple[int, ...]) -> _Fit:
    """Move a label from a pose along some axes until its drawing fits all patches."""
    for _ in range(MAX_ROUNDS):
        fit = _compare(patches, blur_px, pose, axes)
        motion = solved(fit.normal, fit.pull)
        if np.abs(motion).max() < STILL:
            break
        pose = _moved(pose, axes, motion)
    return fit


def _compare(
    patches: Sequence[LabelPatch], blur_px: float, pose: Pose, axes: tuple[int, ...] = ()
) -> _Fit:
    """Compare patches with the drawing at a pose, and differentiate along some axes."""
    all_of = [_differences(patch, blur_px, pose, axes) for patch in patches]
    # A difference is a distance times a slope; the steeper, the better it shows the distance.
    edges = sum(d.weight @ (d.steep * np.square(d.rest * d.scale)) for d in all_of)
    steep = sum(d.weight @ np.square(d.steep) for d in all_of)
    weighted = [(d.weight[:, None] * d.change).T for d in all_of]
    k = len(axes)
    return _Fit(
        world_from_label=pose,
        normal=sum((w @ d.change for w, d in zip(weighted, all_of, strict=True)), np.zeros((k, k))),
        pull=sum((w @ d.rest for w, d in zip(weighted, all_of, strict=True)), np.zeros(k)),
        rests=[d.rest for d in all_of],
        valid=np.concatenate([patch.valid for patch in patches]),
        residual=math.sqrt(edges / max(steep, 1e-12)),
    )


@dataclass(frozen=True, eq=False)
class _Differences:
    """How the pixels of one patch differ from the drawing.

    Attributes:
        rest: (n,) in contrasts.
        weight: (n,) Tukey's; 0 of pixels that take no part.
        change: (n, k) by a step along each axis.
        steep: (n,) square of the drawing's slope.
        scale: size of a sample of the drawing [m].
    """

    rest: Array
    weight: Array
    change: Array
    steep: Array
    scale: float


def _differences(
    patch: LabelPatch, blur_px: float, pose: Pose, axes: tuple[int, ...]
) -> _Differences:
    places = patch.places(pose)
    shown, slope = patch.shown(blur_px, places)
    light = np.column_stack([np.ones(len(shown)), shown, shown[:, None] * patch.even])
    weight = patch.valid.astype(np.float64)
    for _ in range(2):
        level = _fitted(light, patch.levels, weight)
        contrast = max(float(level[1]), LEAST_CONTRAST)
        rest = (patch.levels - light @ level) / contrast
        weight = patch.valid * np.square(np.clip(1 - np.square(rest / TUKEY), 0.0, None))
    change = np.empty((len(rest), len(axes)))
    for k, axis in enumerate(axes):
        step = patch.places(_moved(pose, (axis,), np.ones(1))) - places
        change[:, k] = np.sum(slope * step, axis=1)
    change *= ((level[1] + patch.even @ level[2:]) / contrast)[:, None]
    # What other light would explain as well shows no motion.
    if axes:
        change -= light @ _fitted(light, change, weight)
    steep = np.sum(np.square(slope), axis=1)
    return _Differences(rest, weight, change, steep, patch.scale)


def _fitted(basis: Array, target: Array, weight: Array) -> Array:
    """Return the coefficients of a basis (n, k) that come nearest to a target (n,) or (n, m)."""
    weighted = (basis * weight[:, None]).T
    return np.asarray(np.linalg.lstsq(weighted @ basis, weighted @ target, rcond=None)[0])


def _moved(pose: Pose, axes: tuple[int, ...], motion: Array) -> Pose:
    """Return a pose after a motion (k,) along axes, in steps of the derivatives."""
    whole = np.zeros(6)
    whole[list(axes)] = motion
    whole *= STEPS
    angle = float(np.linalg.norm(whole[3:]))
    axis = whole[3:] / max(angle, 1e-12)
    turn = np.array([*(axis * math.sin(angle / 2)), math.cos(angle / 2)])
    return Pose(pose.position + whole[:3], multiply_quaternions(turn, pose.quaternion))
