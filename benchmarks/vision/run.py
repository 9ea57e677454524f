#!/usr/bin/env python3
"""Measure the detection of cables on rendered scenes, against its targets.

A pixel is 1 mm on the table. Prints a table and writes lines of JSON to out/bench/vision.jsonl;
with --figures also the tables of docs/vision.md: cables.jsonl, clutter.jsonl and conditions.jsonl.

Usage: run.py [--scenes N] [--seed FIRST] [--processes N] [--tables FOLDER] [--figures FOLDER]
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import multiprocessing
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from row import Row, report, start
from scenes import Kind, make_scene
from scoring import Score, auc, follows, score

from remodel_vision.cables import detect_cables
from remodel_vision.cables.warnings import SURE

COUNTS = (1, 2, 3, 4, 5)
# What is made worse, and by how much: of the light and the camera, and of the scene.
LIGHT: dict[str, dict[str, float]] = {
    "exposure 0.25": {"exposure": 0.25},
    "exposure 0.5": {"exposure": 0.5},
    "exposure 1.6": {"exposure": 1.6},
    "exposure 2.5": {"exposure": 2.5},
    "blur 1.5 px": {"blur": 1.5},
    "blur 2.5 px": {"blur": 2.5},
    "blur 4 px": {"blur": 4.0},
    "noise 10": {"noise": 10.0},
    "noise 20": {"noise": 20.0},
    "light at 25 degrees": {"elevation": math.radians(25), "shadow": 0.6},
    "highlights": {"specular": 1.0},
    "lit from one side": {"falloff": 1.0},
    "JPEG with halved chroma": {"jpeg": 85.0},
    "motion blur 3 px": {"motion": 3.0},
    "blacks cut off": {"black": 25.0},
}
SCENE: dict[str, dict[str, Any]] = {
    "2 foreign objects": {"clutter": 2},
    "5 foreign objects": {"clutter": 5},
    "black table": {"surface": "black"},
    "2 coloured sheets": {"sheets": 2},
    "2 mounting rails": {"rails": 2},
}
BOTH: dict[str, tuple[dict[str, Any], dict[str, float]]] = {
    **{name: ({}, light) for name, light in LIGHT.items()},
    **{name: (scene, {}) for name, scene in SCENE.items()},
    "black table, blacks cut off, JPEG": ({"surface": "black"}, {"black": 6.0, "jpeg": 85.0}),
}


@dataclass(frozen=True)
class Task:
    """A scene to score."""

    kind: Kind
    seed: int
    light: tuple[tuple[str, float], ...] = ()


def run(task: Task) -> Score:
    """Render a scene, detect its cables, and score the answer."""
    cv2.setNumThreads(1)
    scene = make_scene(task.kind, task.seed, **dict(task.light))
    return score(scene, detect_cables(scene.rendered.rgb))


def cluttered(seed: int, photographs: Sequence[Path] = ()) -> Kind:
    """Return what a cluttered scene of a seed is like: sheets, rails, objects, or a photograph."""
    lot = np.random.default_rng([seed, 77])
    cables, some = int(lot.integers(1, 5)), int(lot.integers(1, 4))
    kind = Kind(cables, bool(lot.uniform() < 0.2), leaving=float(lot.choice([0.2, 0.7])))
    kinds = [
        replace(kind, sheets=some),
        replace(kind, rails=some),
        replace(kind, sheets=1, rails=1, clutter=3),
    ]
    if photographs:
        kinds.append(replace(kind, surface=str(photographs[lot.integers(len(photographs))])))
    return kinds[int(lot.integers(len(kinds)))]


def run_cluttered(task: Task) -> tuple[int, list[tuple[float, bool]]]:
    """Return how many cables a scene has, and of each line found its confidence and if it is one.

    Of several lines on one cable the likeliest is one.
    """
    cv2.setNumThreads(1)
    scene = make_scene(task.kind, task.seed, **dict(task.light))
    lines, taken = [], set[int]()
    found = detect_cables(scene.rendered.rgb).cables
    for cable in sorted(found, key=lambda c: -c.confidence):
        own = follows(scene, cable)
        lines.append((cable.confidence, own is not None and own not in taken))
        taken |= {own} if own is not None else set()
    return len(scene.cables), lines


def clutter(group: str, answers: list[tuple[int, list[tuple[float, bool]]]]) -> list[Row]:
    """Return the figures of cluttered scenes."""
    cables = sum(count for count, _ in answers)
    lines = sorted((line for _, own in answers for line in own), reverse=True)
    right = np.cumsum([ok for _, ok in lines])
    precise = np.flatnonzero(right >= 0.9 * np.arange(1, len(lines) + 1))
    found = right[precise[-1]] if len(precise) else 0
    false = sum(not ok for _, ok in lines) * 60 / len(answers)
    offered = sum(not ok for confidence, ok in lines if confidence >= SURE) * 60 / len(answers)
    return [
        Row(f"{group}: cables found at precision 0.9", 100 * found / cables, "%", 85.0),
        Row(f"{group}: false lines on 60 pictures", false, ""),
        Row(f"{group}: the same from confidence 0.5 on", offered, "", at_most=6.0),
        Row(f"{group}: confidence, AUC", auc(lines), "", 0.95),
    ]


def accuracy(group: str, scores: list[Score], least_count: float) -> list[Row]:
    """Return the figures of scenes in ordinary light."""
    lines = [e for s in scores for e in s.centreline]
    tips = [e for s in scores for e in s.tips]
    dice = [d for s in scores for d in s.dice]
    upper = [u for s in scores for u in s.upper_right]
    crossings = len(upper) + sum(s.crossings_missed for s in scores)
    return [
        Row(f"{group}: right number", _percent(s.count_right for s in scores), "%", least_count),
        Row(f"{group}: centreline error, mean", _mean(lines), "px", at_most=0.2),
        Row(f"{group}: tip error, median", float(np.median(tips)), "mm", at_most=0.5),
        Row(f"{group}: tip error, p90", float(np.quantile(tips, 0.9)), "mm", at_most=1.0),
        Row(f"{group}: Dice over instances, mean", _mean(dice), "", 0.985),
        Row(f"{group}: crossings found", 100 * len(upper) / max(1, crossings), "%"),
        Row(f"{group}: upper strand right", _percent(upper), "%"),
        Row(f"{group}: all right", _percent(s.right for s in scores), "%"),
        Row(f"{group}: right, with warnings", _percent(s.right and s.warned for s in scores), "%"),
        Row(f"{group}: wrong without a warning", _percent(map(_silent, scores)), "%", at_most=1.0),
    ]


def honesty(group: str, scores: list[Score]) -> Row:
    """Return how many scenes under a condition were found or refused, with how many were found."""
    right = _percent(s.right for s in scores)
    return Row(
        f"{group}: found or refused (found {right:.0f} %)",
        100 - _percent(map(_silent, scores)),
        "%",
        at_least=99.0,
    )


def condition_row(name: str, scores: list[Score]) -> dict[str, str]:
    """Return a row of the docs' table of conditions."""
    return {
        "condition": name,
        "scenes": str(len(scores)),
        "found or refused (99 %)": f"{100 - _percent(map(_silent, scores)):.1f} %",
        "found": f"{_percent(s.right for s in scores):.0f} %",
        "wrong without a warning": str(sum(map(_silent, scores))),
    }


def table(groups: Mapping[str, Iterable[Row]]) -> list[dict[str, str]]:
    """Return the rows of a docs' table: a line for each figure, a column for each group."""
    lines: dict[str, dict[str, str]] = {}
    for group, rows in groups.items():
        for row in rows:
            figure = row.what.removeprefix(f"{group}: ")
            lines.setdefault(figure, {"figure": figure})[group] = _cell(row.value, row.unit)
            if row.target is not None:
                before = lines[figure].get("target")
                same = before in (None, f"{row.target:g}")
                lines[figure]["target"] = f"{'' if same else f'{before}, '}{row.target:g}"
    # The target comes last.
    return [
        {k: line[k] for k in sorted(line, key=lambda k: k == "target")} for line in lines.values()
    ]


def _cell(value: float, unit: str) -> str:
    return f"{value:.0f} %" if unit == "%" else f"{value:.3g} {unit}".rstrip()


def write(folder: Path | None, name: str, rows: Iterable[Mapping[str, str]]) -> None:
    """Write a table to a folder, if one is named."""
    if folder is not None:
        lines = "".join(f"{json.dumps(row)}\n" for row in rows)
        (folder / name).write_text(lines, encoding="utf-8")


def _silent(scored: Score) -> bool:
    return not scored.right and not scored.warned


def _mean(values: list[float]) -> float:
    return float(np.mean(values)) if values else math.nan


def _percent(flags: object) -> float:
    return 100 * _mean([float(flag) for flag in flags])


def times(seed: int, scenes: int) -> list[Row]:
    """Return the time per frame of one thread: medians of each frame's best of five.

    It is CPU time, so that other work on the machine counts little.
    """
    cv2.setNumThreads(1)
    counts = [COUNTS[i % len(COUNTS)] for i in range(scenes)]
    frames = [
        make_scene(Kind(count, i % 2 == 1), seed + i).rendered.rgb for i, count in enumerate(counts)
    ]
    best = [min(_time(lambda f=frame: detect_cables(f)) for _ in range(5)) for frame in frames]
    three = [t for t, count in zip(best, counts, strict=True) if count == 3]
    what = "time per frame, one thread"
    return [
        Row(f"{what}, three cables, median", 1e3 * float(np.median(three)), "ms", at_most=4.0),
        Row(f"{what}, one to five, median", 1e3 * float(np.median(best)), "ms", at_most=8.0),
        Row(f"{what}, one to five, p90", 1e3 * float(np.quantile(best, 0.9)), "ms"),
    ]


def _time(work: Callable[[], object]) -> float:
    start = time.thread_time()
    work()
    return time.thread_time() - start


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=200, help="per group; a fifth per condition")
    parser.add_argument("--seed", type=int, default=5000, help="of the first scene")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--tables", type=Path, help="a folder of photographs without cables")
    parser.add_argument("--figures", type=Path, help="a folder for the tables: docs/figures")
    options = parser.parse_args()
    start()
    first, few = options.seed, max(5, options.scenes // 5)
    timed = times(first, 30)
    with multiprocessing.get_context("spawn").Pool(options.processes) as pool:
        groups: dict[str, list[Row]] = {}
        for same, group, least in ((False, "colours", 99.0), (True, "one colour", 97.0)):
            tasks = [Task(Kind(COUNTS[i % 5], same), first + i) for i in range(options.scenes)]
            groups[group] = accuracy(group, pool.map(run, tasks, chunksize=4), least)
        groups["colours"] += timed
        report_all(itertools.chain(*groups.values()))
        write(options.figures, "cables.jsonl", table(groups))
        photographs = sorted(options.tables.iterdir()) if options.tables else []
        cluttering: dict[str, list[Row]] = {}
        for group, pictures in (("clutter", []), ("on photographs", photographs)):
            if group == "clutter" or pictures:
                tasks = [
                    Task(cluttered(s, pictures), s) for s in range(first, first + options.scenes)
                ]
                tasks = [t for t in tasks if group == "clutter" or t.kind.surface]
                answers = pool.map(run_cluttered, tasks, chunksize=4)
                cluttering[group] = clutter(group, answers)
        report_all(itertools.chain(*cluttering.values()))
        write(options.figures, "clutter.jsonl", table(cluttering))
        by_condition: dict[str, list[Score]] = {}
        kinds = [Kind(count, same) for count, same in itertools.product(COUNTS, (False, True))]
        for name, (scene, light) in BOTH.items():
            condition = tuple(light.items())
            tasks = [
                Task(replace(kinds[i % 10], **scene), first + i, condition) for i in range(few)
            ]
            by_condition[name] = pool.map(run, tasks, chunksize=4)
            report(honesty(name, by_condition[name]))
    everything = [s for scores in by_condition.values() for s in scores]
    by_condition["all conditions"] = everything
    rows = [condition_row(name, scores) for name, scores in by_condition.items()]
    write(options.figures, "conditions.jsonl", rows)
    cables = [cable for s in everything for cable in s.cables]
    alone = [ok for s in everything for ok in s.unwarned]
    offered = [ok for confidence, ok in cables if confidence >= 0.9]
    report_all(
        [
            honesty("all conditions", everything),
            Row("all conditions: confidence, AUC", auc(cables), "", at_least=0.95),
            Row("all conditions: cables without own warnings, right", _percent(alone), "%"),
            Row("all conditions: right from confidence 0.9 on", _percent(offered), "%", 90.0),
        ]
    )


def report_all(rows: Iterable[Row]) -> None:
    """Print figures."""
    for row in rows:
        report(row)


if __name__ == "__main__":
    main()
