"""Compare an answer with the truth."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from renderer import Array, CableCurve, TrueCrossing, paint_labels
from scenes import SIZE, Scene

from remodel_vision.cables import CableEnding, DetectedCable, Detection

# A cable is found when its centreline lies within these of the true one [px], [widths].
MEAN_LIMIT_PX, FAR_LIMIT_WIDTHS = 1.0, 1.0
TIP_LIMIT_PX = 5.0
# In clutter a line follows a cable within so much over this share of both.
FOLLOWED_PX, FOLLOWED_SHARE = 3.0, 0.85
# A crossing is found within this distance [px].
REACH_PX = 10.0


@dataclass(frozen=True, eq=False)
class Score:
    """How an answer compares with the truth.

    Attributes:
        count_right: as many cables as there are.
        right: count, every centreline and every end; a person would say so too.
        centreline: mean error of each found cable [px].
        tips: errors of loose tips [px].
        dice: of each true cable's visible pixels; 0 where it was not found.
        upper_right: for each true crossing that was found, whether the upper strand is right.
        crossings_missed: true crossings without an answer.
        warned: the answer has warnings.
        cables: of each found cable its confidence, and whether line and ends are right.
        unwarned: of each found cable without warnings of its own, whether it is right.
    """

    count_right: bool
    right: bool
    centreline: tuple[float, ...]
    tips: tuple[float, ...]
    dice: tuple[float, ...]
    upper_right: tuple[bool, ...]
    crossings_missed: int
    warned: bool
    cables: tuple[tuple[float, bool], ...]
    unwarned: tuple[bool, ...]


def score(scene: Scene, found: Detection) -> Score:
    """Score what was found in a scene."""
    truths = [_visible(cable) for cable in scene.cables]
    matched = _match(truths, found.cables)
    errors, tips = [], []
    rights = [False] * len(found.cables)
    for t, f in matched.items():
        cable = found.cables[f]
        forth, back = (
            _distances(cable.centreline, truths[t]),
            _distances(truths[t], cable.centreline),
        )
        errors.append(float((forth.mean() + back.mean()) / 2))
        ends, ends_right = _ends(scene.cables[t], cable)
        tips += ends
        rights[f] = _is_right(forth, back, scene.cables[t]) and ends_right
    count_right = len(found.cables) == len(truths)
    upper, missed = _crossings(scene, found, matched)
    return Score(
        count_right,
        count_right and len(matched) == len(truths) and all(rights),
        tuple(errors),
        tuple(tips),
        _dice(scene, found, matched),
        upper,
        missed,
        bool(found.warnings),
        tuple((cable.confidence, ok) for cable, ok in zip(found.cables, rights, strict=True)),
        tuple(ok for cable, ok in zip(found.cables, rights, strict=True) if not cable.warnings),
    )


def is_right(scene: Scene, cable: DetectedCable) -> bool:
    """Return whether a cable found is one of a scene's, line and ends."""
    return any(
        _is_right(_distances(cable.centreline, line), _distances(line, cable.centreline), truth)
        and _ends(truth, cable)[1]
        for truth in scene.cables
        if np.ptp((line := _visible(truth)), axis=0).max() > 0
        and np.median(_distances(line[::8], cable.centreline)) < truth.width
    )


def follows(scene: Scene, cable: DetectedCable) -> int | None:
    """Return which of a scene's cables one found follows, within 3 px over 85 % of both."""
    for i, truth in enumerate(scene.cables):
        line = _visible(truth)
        on = np.mean(_distances(cable.centreline, line) < FOLLOWED_PX)
        under = np.mean(_distances(line, cable.centreline) < FOLLOWED_PX)
        if min(on, under) > FOLLOWED_SHARE:
            return i
    return None


def _is_right(forth: Array, back: Array, truth: CableCurve) -> bool:
    """Return whether two lines are near each other, by the distances of each from the other."""
    far = max(np.quantile(forth, 0.98), np.quantile(back, 0.98))
    mean = (forth.mean() + back.mean()) / 2
    return bool(mean < MEAN_LIMIT_PX and far < FAR_LIMIT_WIDTHS * truth.width)


def auc(cables: list[tuple[float, bool]]) -> float:
    """Return the probability that a right cable has more confidence than a wrong one."""
    right = np.array([confidence for confidence, ok in cables if ok])
    wrong = np.array([confidence for confidence, ok in cables if not ok])
    return float(np.mean((right[:, None] > wrong) + 0.5 * (right[:, None] == wrong)))


def _visible(cable: CableCurve) -> Array:
    limit = np.array(SIZE) - 1
    return cable.points[np.all((cable.points >= 0) & (cable.points <= limit), axis=1)]


def _distances(points: Array, line: Array) -> Array:
    """Return the distances of points (n, 2) from a polyline (m, 2)."""
    start, way = line[:-1], np.diff(line, axis=0)
    share = np.einsum("nkd,kd->nk", points[:, None] - start, way) / np.sum(way**2, axis=1)
    nearest = start + np.clip(share, 0, 1)[..., None] * way
    return np.asarray(np.linalg.norm(points[:, None] - nearest, axis=-1).min(axis=1))


def _match(truths: list[Array], found: tuple[DetectedCable, ...]) -> dict[int, int]:
    """Pair true and found cables, the nearest first, while most of a true one is covered."""
    options = []
    for (t, truth), (f, cable) in itertools.product(enumerate(truths), enumerate(found)):
        gaps = _distances(truth[::4], cable.centreline)
        options.append((float(np.median(gaps)), t, f))
    pairs: dict[int, int] = {}
    for gap, t, f in sorted(options):
        if gap < 3.0 and t not in pairs and f not in pairs.values():
            pairs[t] = f
    return pairs


def _ends(truth: CableCurve, found: DetectedCable) -> tuple[list[float], bool]:
    """Return the errors of the loose tips [px], and whether both ends are what they are."""
    limit = np.array(SIZE) - 1
    errors, right = [], True
    for point in (truth.points[0], truth.points[-1]):
        if np.any((point < 0) | (point > limit)):
            right &= any(tip.end is CableEnding.TRUNCATED for tip in found.tips)
            continue
        gaps = [float(np.linalg.norm(tip.point - point)) for tip in found.tips]
        near = int(np.argmin(gaps))
        errors.append(gaps[near])
        right &= gaps[near] < TIP_LIMIT_PX and found.tips[near].end is CableEnding.TIP
    return errors, right


def _dice(scene: Scene, found: Detection, matched: dict[int, int]) -> tuple[float, ...]:
    """Return for each true cable the Dice index of what one sees of it."""
    curves = tuple(_curve(cable) for cable in found.cables)
    crossings = tuple(
        TrueCrossing(
            c.point,
            c.upper,
            c.lower,
            _index(curves[c.upper], found.cables[c.upper].spline.at(np.array([c.upper_at]))[0]),
            _index(curves[c.lower], c.point),
        )
        for c in found.crossings
    )
    labels = paint_labels(SIZE, curves, crossings)
    indices = []
    for t in range(len(scene.cables)):
        if t not in matched:
            indices.append(0.0)
            continue
        true, ours = scene.rendered.labels == t + 1, labels == matched[t] + 1
        indices.append(float(2 * np.sum(true & ours) / max(1, np.sum(true) + np.sum(ours))))
    return tuple(indices)


def _curve(cable: DetectedCable) -> CableCurve:
    """Return a found cable in steps of 1 px; one that leaves the picture goes on beyond it."""
    line = [cable.centreline]
    for tip, first in zip(cable.tips, (True, False), strict=True):
        if tip.end is CableEnding.TRUNCATED:
            beyond = (tip.point + 2 * cable.width * tip.outward)[None]
            line = [beyond, *line] if first else [*line, beyond]
    points = np.vstack(line)
    arc = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    even = np.arange(0, arc[-1], 1.0)
    return CableCurve(
        np.column_stack([np.interp(even, arc, points[:, i]) for i in (0, 1)]), cable.width
    )


def _index(curve: CableCurve, point: Array) -> int:
    return int(np.argmin(np.linalg.norm(curve.points - point, axis=1)))


def _crossings(
    scene: Scene, found: Detection, matched: dict[int, int]
) -> tuple[tuple[bool, ...], int]:
    """Return whether the upper strand is right at the crossings found, and how many were missed."""
    right, missed = [], 0
    for truth in scene.crossings:
        near = [c for c in found.crossings if np.linalg.norm(c.point - truth.point) < REACH_PX]
        if not near:
            missed += 1
            continue
        upper = _heading(scene.cables[truth.upper].points, truth.upper_index)
        lower = _heading(scene.cables[truth.lower].points, truth.lower_index)
        answer = near[0]
        ends = found.cables[answer.upper].spline.at(answer.upper_at + np.array([-0.005, 0.005]))
        heading = _heading(ends, 0)
        right.append(bool(abs(heading @ upper) > abs(heading @ lower)))
    return tuple(right), missed


def _heading(points: Array, index: int) -> Array:
    way = points[min(index + 1, len(points) - 1)] - points[max(index - 1, 0)]
    return np.asarray(way / np.linalg.norm(way))
