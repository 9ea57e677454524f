"""The pose of a component from its label: the most likely one.

The label's drawing, blurred as by the lens, is laid into the pictures at a pose; pose, brightness
and contrast are changed until it differs least from what was seen (Gauss and Newton, with Tukey's
weights, so that what lies over a part of the label does not count). All edges of all cells take
part, not four corners only, and all pictures that are given.

A component that stands upright on the plate has three degrees of freedom, one that does not has
six. The six are taken only where they explain the pictures clearly better, and only of two pictures
from different places: one hardly shows how a label is tilted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from remodel_sim.core.camera import Picture
from remodel_sim.core.geometry import Array, Pose, multiply_quaternions
from remodel_sim.core.vision.label_patch import LabelPatch
from remodel_sim.core.workpiece.component_shape import label_corners
from remodel_sim.core.workpiece.panel import Component

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
# Keeps the normal equations solvable when a picture does not determine all motions.
DAMPING = 1e-9
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
LEAST_SHOWN, MOST_RESIDUAL_M = 0.7, 0.0005


@dataclass(frozen=True, eq=False)
class LabelView:
    """A picture that shows a label, and roughly where: its corners (4, 2) [px]."""

    picture: Picture
    corners: Array


@dataclass(frozen=True, eq=False)
class ComponentObservation:
    """A component as seen.

    Attributes:
        world_from_component: upright on the plate, unless two views or more show otherwise.
        upright: whether it is.
        residual: RMS distance of the label's edges, as seen, from those of the pose [m].
        shown: share of the label that looks as it should, 0 to 1.
        corners: (4, 2) of its black square in the last picture [px].
    """

    world_from_component: Pose
    upright: bool
    residual: float
    shown: float
    corners: Array

    @property
    def clear(self) -> bool:
        """Whether the label is seen well enough to rely on."""
        return self.shown >= LEAST_SHOWN and self.residual <= MOST_RESIDUAL_M


def locate_component(component: Component, views: Sequence[LabelView]) -> ComponentObservation:
    """Return the pose of a component at which its label looks as it does in all pictures."""
    patches = [
        LabelPatch(component, label_view.picture, label_view.corners) for label_view in views
    ]
    upright = _fit(patches, FIRST_BLUR_PX, _upright_start(component, views[-1]), UPRIGHT)
    every = np.ones(len(upright.rest), bool)
    blur = min(BLURS_PX, key=lambda px: _compare(patches, px, upright.world_from_label).cost(every))
    best = upright = _fit(patches, blur, upright.world_from_label, UPRIGHT)
    if len(views) > 1:
        free = _fit(patches, blur, upright.world_from_label, FREE)
        if free.cost(free.explained) < CLEARLY_BETTER * upright.cost(free.explained):
            best = free
    height = float(label_corners(component)[0, 2])
    pose = best.world_from_label @ Pose.level(0.0, 0.0, -height)
    corners = views[-1].picture.view.project(pose.apply(label_corners(component)))
    return ComponentObservation(
        world_from_component=pose,
        upright=best is upright,
        residual=best.residual,
        shown=float(best.explained.mean()),
        corners=corners,
    )


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
        rest: (n,) differences of all pixels, in contrasts.
        residual: RMS distance of the edges seen from the drawing's [m].
    """

    world_from_label: Pose
    normal: Array
    pull: Array
    rest: Array
    residual: float

    @property
    def explained(self) -> npt.NDArray[np.bool_]:
        """Which pixels (n,) show the label."""
        return np.abs(self.rest) < OUTLIER

    def cost(self, of: npt.NDArray[np.bool_]) -> float:
        """Return the sum of squares of some pixels' differences, each cut at OUTLIER."""
        return float(np.sum(np.minimum(np.square(self.rest[of]), OUTLIER**2)))


def _fit(patches: Sequence[LabelPatch], blur_px: float, pose: Pose, axes: tuple[int, ...]) -> _Fit:
    """Move a label from a pose along some axes until its drawing fits all patches."""
    for _ in range(MAX_ROUNDS):
        fit = _compare(patches, blur_px, pose, axes)
        damping = DAMPING * np.trace(fit.normal) * np.eye(len(axes))
        motion = np.linalg.solve(fit.normal + damping, fit.pull)
        if np.abs(motion).max() < STILL:
            break
        pose = _moved(pose, axes, motion)
    return fit


def _compare(
    patches: Sequence[LabelPatch], blur_px: float, pose: Pose, axes: tuple[int, ...] = ()
) -> _Fit:
    """Compare patches with the drawing at a pose, and differentiate along some axes."""
    rests, normal, pull = [], np.zeros((len(axes), len(axes))), np.zeros(len(axes))
    edges = np.zeros(2)
    for patch in patches:
        places = patch.places(pose)
        shown, slope = patch.shown(blur_px, places)
        light = np.column_stack([np.ones(len(shown)), shown, shown[:, None] * patch.even])
        weight = np.ones(len(shown))
        for _ in range(2):
            level = _fitted(light, patch.levels, weight)
            contrast = max(float(level[1]), LEAST_CONTRAST)
            rest = (patch.levels - light @ level) / contrast
            weight = np.square(np.clip(1 - np.square(rest / TUKEY), 0.0, None))
        rests.append(rest)
        change = np.empty((len(rest), len(axes)))
        for k, axis in enumerate(axes):
            step = patch.places(_moved(pose, (axis,), np.ones(1))) - places
            change[:, k] = np.sum(slope * step, axis=1)
        change *= ((level[1] + patch.even @ level[2:]) / contrast)[:, None]
        # What other light would explain as well shows no motion.
        change -= light @ _fitted(light, change, weight)
        # A difference is a distance times a slope; the steeper, the better it shows the distance.
        steep = np.sum(np.square(slope), axis=1)
        edges += [weight @ (steep * np.square(rest * patch.scale)), weight @ np.square(steep)]
        normal += change.T @ (weight[:, None] * change)
        pull += change.T @ (weight * rest)
    residual = math.sqrt(edges[0] / max(edges[1], 1e-12))
    return _Fit(
        world_from_label=pose,
        normal=normal,
        pull=pull,
        rest=np.concatenate(rests),
        residual=residual,
    )


def _fitted(basis: Array, target: Array, weight: Array) -> Array:
    """Return the coefficients of a basis (n, k) that come nearest to a target (n,) or (n, m)."""
    weighted = (basis * weight[:, None]).T
    return np.asarray(np.linalg.solve(weighted @ basis, weighted @ target))


def _moved(pose: Pose, axes: tuple[int, ...], motion: Array) -> Pose:
    """Return a pose after a motion (k,) along axes, in steps of the derivatives."""
    whole = np.zeros(6)
    whole[list(axes)] = motion
    whole *= STEPS
    angle = float(np.linalg.norm(whole[3:]))
    axis = whole[3:] / max(angle, 1e-12)
    turn = np.array([*(axis * math.sin(angle / 2)), math.cos(angle / 2)])
    return Pose(pose.position + whole[:3], multiply_quaternions(turn, pose.quaternion))
