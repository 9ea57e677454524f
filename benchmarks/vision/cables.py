#!/usr/bin/env python3
"""Measure the detection of cables on rendered scenes, and on photographs with masks.

cables.py [--scenes N] [--seed FIRST] [--processes N] [--figures FOLDER]; the workspace must be
sourced. A pixel is 1 mm on the table. Prints the tables of docs/vision.md, and writes them to
FOLDER: cables.jsonl, conditions.jsonl, clutter.jsonl.

cables.py --photographs FOLDER: NAME.jpg and NAME.labels.png each, for each pixel the number of the
cable, 0 for the background, and at a crossing the number of one of the two. An answer is right when
it has as many cables as the mask, and each follows one of its own from end to end.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import argparse
import itertools
import math
import multiprocessing
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from renderer import Array, CableCurve
from scenes import SIZE, Kind, Scene, make_scene

sys.path.insert(0, str(Path(__file__).parents[1]))
from figures import Figure, report, report_table

from remodel_vision.cables import CableEnding, DetectedCable, Detection, detect_cables
from remodel_vision.cables.warnings import SURE

COUNTS = (1, 2, 3, 4, 5)
# What is made worse, and by how much: of the scene, and of the light and the camera.
CONDITIONS: dict[str, tuple[dict[str, Any], dict[str, float]]] = {
    "exposure 0.25": ({}, {"exposure": 0.25}),
    "exposure 0.5": ({}, {"exposure": 0.5}),
    "exposure 1.6": ({}, {"exposure": 1.6}),
    "exposure 2.5": ({}, {"exposure": 2.5}),
    "blur 1.5 px": ({}, {"blur": 1.5}),
    "blur 2.5 px": ({}, {"blur": 2.5}),
    "blur 4 px": ({}, {"blur": 4.0}),
    "noise 10": ({}, {"noise": 10.0}),
    "noise 20": ({}, {"noise": 20.0}),
    "light at 25 degrees": ({}, {"elevation": math.radians(25), "shadow": 0.6}),
    "highlights": ({}, {"specular": 1.0}),
    "lit from one side": ({}, {"falloff": 1.0}),
    "JPEG with halved chroma": ({}, {"jpeg": 85.0}),
    "motion blur 3 px": ({}, {"motion": 3.0}),
    "blacks cut off": ({}, {"black": 25.0}),
    "2 foreign objects": ({"clutter": 2}, {}),
    "5 foreign objects": ({"clutter": 5}, {}),
    "black table": ({"surface": "black"}, {}),
    "2 coloured sheets": ({"sheets": 2}, {}),
    "2 mounting rails": ({"rails": 2}, {}),
    "black table, blacks cut off, JPEG": ({"surface": "black"}, {"black": 6.0, "jpeg": 85.0}),
}
TARGETS = {
    "right number": "99, 97",
    "centreline error, mean": "0.2",
    "tip error, median": "0.5",
    "tip error, p90": "1",
    "wrong without a warning": "1",
    "time per frame, one thread, three cables, median": "4",
    "time per frame, one thread, one to five, median": "8",
    "cables found at precision 0.9": "85",
    "the same from confidence 0.5 on": "6",
    "confidence, AUC": "0.95",
}
# A cable is found when its centreline lies within these of the true one [px], [widths].
MEAN_LIMIT_PX, FAR_LIMIT_WIDTHS = 1.0, 1.0
PAIRED_PX, TIP_LIMIT_PX = 3.0, 5.0
# In clutter and on photographs a line follows a cable within so much over this share of both.
FOLLOWED_PX, FOLLOWED_SHARE = 3.0, 0.85
# A crossing is found within this distance [px].
REACH_PX = 10.0


@dataclass(frozen=True)
class Task:
    """A scene to score."""

    kind: Kind
    seed: int
    light: tuple[tuple[str, float], ...] = ()

    def scene(self) -> Scene:
        """Render it."""
        cv2.setNumThreads(1)
        return make_scene(self.kind, self.seed, **dict(self.light))


@dataclass(frozen=True, eq=False)
class Score:
    """How an answer compares with the truth.

    Attributes:
        count_right: as many cables as there are.
        right: count, every centreline and every end; a person would say so too.
        warned: the answer has warnings.
        centreline: mean error of each found cable [px].
        tips: errors of loose tips [px].
        upper_right: for each true crossing whether the upper strand is right; None: not found.
    """

    count_right: bool
    right: bool
    warned: bool
    centreline: tuple[float, ...]
    tips: tuple[float, ...]
    upper_right: tuple[bool | None, ...]

    @property
    def silent(self) -> bool:
        """Whether the answer is wrong without a warning."""
        return not self.right and not self.warned


def score(task: Task) -> Score:
    """Render a scene, detect its cables, and compare with the truth."""
    scene = task.scene()
    found = detect_cables(scene.rgb)
    truths = [visible(cable) for cable in scene.cables]
    pairs = paired(truths, found.cables)
    errors, tips, rights = [], [], []
    for t, f in pairs.items():
        error, ends, is_right = compared(scene.cables[t], found.cables[f])
        errors.append(error)
        tips += ends
        rights.append(is_right)
    count_right = len(found.cables) == len(truths)
    return Score(
        count_right,
        count_right and len(pairs) == len(truths) and all(rights),
        bool(found.warnings),
        tuple(errors),
        tuple(tips),
        tuple(upper_right(scene, found)),
    )


def compared(truth: CableCurve, found: DetectedCable) -> tuple[float, list[float], bool]:
    """Return the mean error of a line, those of its loose tips [px], and whether all is right."""
    line = visible(truth)
    forth, back = distances(found.centreline, line), distances(line, found.centreline)
    error = float((forth.mean() + back.mean()) / 2)
    far = max(np.quantile(forth, 0.98), np.quantile(back, 0.98))
    ends, ends_right = compared_ends(truth, found)
    is_near = error < MEAN_LIMIT_PX and far < FAR_LIMIT_WIDTHS * truth.width
    return error, ends, bool(is_near) and ends_right


def visible(cable: CableCurve) -> Array:
    """Return the points of a cable that lie in the picture."""
    limit = np.array(SIZE) - 1
    return cable.points[np.all((cable.points >= 0) & (cable.points <= limit), axis=1)]


def distances(points: Array, line: Array) -> Array:
    """Return the distances of points (n, 2) from a polyline (m, 2)."""
    start, way = line[:-1], np.diff(line, axis=0)
    share = np.einsum("nkd,kd->nk", points[:, None] - start, way) / np.sum(way**2, axis=1)
    nearest = start + np.clip(share, 0, 1)[..., None] * way
    return np.asarray(np.linalg.norm(points[:, None] - nearest, axis=-1).min(axis=1))


def paired(truths: list[Array], found: tuple[DetectedCable, ...]) -> dict[int, int]:
    """Pair true and found cables, the nearest first, while most of a true one is covered."""
    gaps = sorted(
        (float(np.median(distances(truth[::4], cable.centreline))), t, f)
        for (t, truth), (f, cable) in itertools.product(enumerate(truths), enumerate(found))
    )
    pairs: dict[int, int] = {}
    for gap, t, f in gaps:
        if gap < PAIRED_PX and t not in pairs and f not in pairs.values():
            pairs[t] = f
    return pairs


def compared_ends(truth: CableCurve, found: DetectedCable) -> tuple[list[float], bool]:
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


def upper_right(scene: Scene, found: Detection) -> Iterator[bool | None]:
    """Yield of each crossing whether the upper strand is right; None if it was not found."""
    for truth in scene.crossings:
        near = [c for c in found.crossings if np.linalg.norm(c.point - truth.point) < REACH_PX]
        if not near:
            yield None
            continue
        upper = heading(scene.cables[truth.upper].points, truth.upper_index)
        lower = heading(scene.cables[truth.lower].points, truth.lower_index)
        at = near[0].upper_at + np.array([-0.005, 0.005])
        seen = heading(found.cables[near[0].upper].spline.at(at), 0)
        yield bool(abs(seen @ upper) > abs(seen @ lower))


def heading(points: Array, index: int) -> Array:
    """Return the direction of a polyline at a point."""
    way = points[min(index + 1, len(points) - 1)] - points[max(index - 1, 0)]
    return np.asarray(way / np.linalg.norm(way))


def accuracy(scores: list[Score]) -> dict[str, str]:
    """Return the figures of scenes in ordinary light."""
    tips = [e for s in scores for e in s.tips]
    upper = [u for s in scores for u in s.upper_right]
    return {
        "right number": percent(s.count_right for s in scores),
        "centreline error, mean": f"{np.mean([e for s in scores for e in s.centreline]):.3g} px",
        "tip error, median": f"{np.median(tips):.3g} mm",
        "tip error, p90": f"{np.quantile(tips, 0.9):.3g} mm",
        "crossings found": percent(u is not None for u in upper),
        "upper strand right": percent(u for u in upper if u is not None),
        "all right": percent(s.right for s in scores),
        "right, with warnings": percent(s.right and s.warned for s in scores),
        "wrong without a warning": percent(s.silent for s in scores),
    }


def percent(flags: Iterator[bool]) -> str:
    """Return the share of what is so."""
    return f"{100 * np.mean([float(flag) for flag in flags]):.0f} %"


def times(seed: int, scenes: int = 30) -> dict[str, str]:
    """Return the time per frame of one thread: of each frame the best of five, CPU time."""
    counts = [COUNTS[i % len(COUNTS)] for i in range(scenes)]
    best = []
    for i, count in enumerate(counts):
        rgb = Task(Kind(count, i % 2 == 1), seed + i).scene().rgb
        best.append(min(time_ms(lambda rgb=rgb: detect_cables(rgb)) for _ in range(5)))
    three = [t for t, count in zip(best, counts, strict=True) if count == 3]
    what = "time per frame, one thread"
    return {
        f"{what}, three cables, median": f"{np.median(three):.3g} ms",
        f"{what}, one to five, median": f"{np.median(best):.3g} ms",
        f"{what}, one to five, p90": f"{np.quantile(best, 0.9):.3g} ms",
    }


def time_ms(work: Callable[[], object]) -> float:
    """Return the CPU time of this thread [ms]."""
    start = time.thread_time()
    work()
    return 1e3 * (time.thread_time() - start)


def condition_row(name: str, scores: list[Score]) -> dict[str, str]:
    """Return a row of the table of conditions."""
    silent = sum(s.silent for s in scores)
    return {
        "condition": name,
        "scenes": str(len(scores)),
        "found or refused (99 %)": f"{100 - 100 * silent / len(scores):.1f} %",
        "found": percent(s.right for s in scores),
        "wrong without a warning": str(silent),
    }


def cluttered(seed: int) -> Kind:
    """Return what a cluttered scene of a seed is like: with sheets, rails, or all and objects."""
    lot = np.random.default_rng([seed, 77])
    cables, some = int(lot.integers(1, 5)), int(lot.integers(1, 4))
    kind = Kind(cables, bool(lot.uniform() < 0.2), leaving=float(lot.choice([0.2, 0.7])))
    changes = ({"sheets": some}, {"rails": some}, {"sheets": 1, "rails": 1, "clutter": 3})
    return replace(kind, **changes[int(lot.integers(len(changes)))])


def score_cluttered(task: Task) -> tuple[int, list[tuple[float, bool]]]:
    """Return how many cables a scene has, and of each line found its confidence and if it is one.

    Of several lines on one cable the likeliest is one.
    """
    scene = task.scene()
    lines, taken = [], set[int]()
    for cable in sorted(detect_cables(scene.rgb).cables, key=lambda c: -c.confidence):
        own = followed(scene, cable)
        lines.append((cable.confidence, own is not None and own not in taken))
        taken |= {own} if own is not None else set()
    return len(scene.cables), lines


def followed(scene: Scene, cable: DetectedCable) -> int | None:
    """Return which of a scene's cables one found follows."""
    for i, line in enumerate(map(visible, scene.cables)):
        on = np.mean(distances(cable.centreline, line) < FOLLOWED_PX)
        under = np.mean(distances(line, cable.centreline) < FOLLOWED_PX)
        if min(on, under) > FOLLOWED_SHARE:
            return i
    return None


def clutter(answers: list[tuple[int, list[tuple[float, bool]]]]) -> dict[str, str]:
    """Return the figures of cluttered scenes."""
    lines = sorted((line for _, own in answers for line in own), reverse=True)
    confidences, is_one = (np.array(each) for each in zip(*lines, strict=True))
    right = np.cumsum(is_one)
    precise = np.flatnonzero(right >= 0.9 * np.arange(1, len(lines) + 1))
    found = right[precise[-1]] if len(precise) else 0
    bad = confidences[~is_one]
    return {
        "cables found at precision 0.9": f"{100 * found / sum(n for n, _ in answers):.0f} %",
        "false lines on 60 pictures": f"{len(bad) * 60 / len(answers):.3g}",
        "the same from confidence 0.5 on": f"{np.sum(bad >= SURE) * 60 / len(answers):.3g}",
        "confidence, AUC": f"{auc(confidences[is_one], bad):.3g}",
    }


def auc(right: Array, wrong: Array) -> float:
    """Return how often what is right has more confidence than what is wrong, (n,) and (m,)."""
    return float(np.mean((right[:, None] > wrong) + 0.5 * (right[:, None] == wrong)))


def table(**groups: dict[str, str]) -> list[dict[str, str]]:
    """Return the rows of a table: a line for each figure, a column for each group, its target."""
    return [
        {
            "figure": figure,
            **{group.replace("_", " "): found.get(figure, "") for group, found in groups.items()},
            "target": TARGETS.get(figure, ""),
        }
        for figure in dict.fromkeys(itertools.chain(*groups.values()))
    ]


def measure(options: argparse.Namespace) -> None:
    """Print the tables of rendered scenes, and write them."""
    first, count, folder = options.seed, options.scenes, options.figures

    def show(name: str, rows: list[dict[str, str]]) -> None:
        report_table(rows, folder and folder / name)

    timed = times(first)
    with multiprocessing.get_context("spawn").Pool(options.processes) as pool:
        colours, one_colour = (
            [Task(Kind(COUNTS[i % 5], same), first + i) for i in range(count)]
            for same in (False, True)
        )
        found = {**accuracy(pool.map(score, colours, chunksize=4)), **timed}
        one = accuracy(pool.map(score, one_colour, chunksize=4))
        show("cables.jsonl", table(colours=found, one_colour=one))
        tasks = [Task(cluttered(seed), seed) for seed in range(first, first + count)]
        answers = pool.map(score_cluttered, tasks, chunksize=4)
        show("clutter.jsonl", table(clutter=clutter(answers)))
        kinds = [Kind(n, same) for n, same in itertools.product(COUNTS, (False, True))]
        scores: dict[str, list[Score]] = {}
        for name, (scene, light) in CONDITIONS.items():
            tasks = [
                Task(replace(kinds[i % 10], **scene), first + i, tuple(light.items()))
                for i in range(max(5, count // 5))
            ]
            scores[name] = pool.map(score, tasks, chunksize=4)
    scores["all conditions"] = list(itertools.chain(*scores.values()))
    show("conditions.jsonl", [condition_row(name, each) for name, each in scores.items()])


def photographs(folder: Path) -> Iterator[Figure]:
    """Yield the figures of photographs with masks."""
    rights, warnings = [], []
    for path in sorted(folder.glob("*.labels.png")):
        name = path.name.removesuffix(".labels.png")
        rgb = cv2.cvtColor(cv2.imread(str(path.with_name(f"{name}.jpg"))), cv2.COLOR_BGR2RGB)
        found, labels = detect_cables(rgb), cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        own = [followed_mask(cable, labels) for cable in found.cables]
        rights.append(None not in own and {*own} == {*np.unique(labels)} - {0})
        rights[-1] &= len(own) == len({*own})
        warnings.append(bool(found.warnings))
        print(f"{name}: {'right' if rights[-1] else 'WRONG'}", *found.warnings, sep="; ")
    if not rights:
        raise SystemExit(f"no NAME.labels.png in {folder}")
    right, warned = 100 * np.array(rights), 100 * np.array(warnings)
    yield Figure("photographs", len(right))
    yield Figure("number and pairing right", float(right.mean()), "%", least=99.0)
    yield Figure("answered without a warning", float(100 - warned.mean()), "%", least=90.0)
    silent = 100 * np.mean((right == 0) & (warned == 0))
    yield Figure("wrong without a warning", float(silent), "%", most=0.5)


def followed_mask(cable: DetectedCable, labels: Array) -> int | None:
    """Return the number of the mask's cable that a found one follows from end to end."""
    line = np.clip(np.rint(cable.centreline).astype(int), 0, np.array(labels.shape[::-1]) - 1)
    numbers = labels[line[:, 1], line[:, 0]]
    number = int(np.argmax(np.bincount(numbers, minlength=2)[1:])) + 1
    mask, slack = (labels == number).astype(np.uint8), round(FOLLOWED_PX)
    near = cv2.dilate(mask, np.ones((2 * slack + 1,) * 2, np.uint8))
    drawn = np.zeros_like(mask)
    fixed = np.rint(cable.centreline * 16).astype(np.int32)
    cv2.polylines(drawn, [fixed], False, 1, round(cable.width + 2 * slack), cv2.LINE_8, 4)
    on = near[line[:, 1], line[:, 0]].mean()
    under = (drawn & mask).sum() / max(1, mask.sum())
    return number if min(on, under) >= FOLLOWED_SHARE else None


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=int, default=60, help="per group; a fifth per condition")
    parser.add_argument("--seed", type=int, default=23000, help="of the first scene")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--figures", type=Path, help="folder of the docs' tables: docs/figures")
    parser.add_argument("--photographs", type=Path, help="folder of photographs with masks")
    options = parser.parse_args()
    cv2.setNumThreads(1)
    if options.photographs:
        file = options.figures and options.figures / "photographs.jsonl"
        report(photographs(options.photographs), file)
    else:
        measure(options)


if __name__ == "__main__":
    main()
