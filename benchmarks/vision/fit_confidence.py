#!/usr/bin/env python3
"""Fit the weights of the detector's confidence, and write them into the package.

Candidates in rendered scenes under all conditions of run.py, and on cluttered tables, are compared
with the truth; with --tables also on parts of photographs of a folder, which show no cables. A
logistic model, by Newton's method with a small price of weights, gives the probability that a cable
is right. The fit is on even seeds; the printed figures are of odd ones.

Usage: fit_confidence.py [--scenes N] [--seed FIRST] [--processes N] [--tables FOLDER]
"""

from __future__ import annotations

import argparse
import itertools
import multiprocessing
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import cv2
import numpy as np
from renderer import Array, Picture
from row import Row, report
from run import BOTH, COUNTS, Task, cluttered
from scenes import Kind, make_scene
from scoring import auc, is_right

from remodel_vision.cables import candidates, confidence_weights, detect, detect_cables
from remodel_vision.cables.candidates import Candidate

PRICE = 1.0
ROUNDS = 30
# So many times the scenes of a condition are on cluttered tables.
CLUTTERED = 12

Sample = tuple[int, dict[str, float], bool]


def collect(task: Task) -> list[Sample]:
    """Return seed and terms of each candidate of a scene, and whether it is right."""
    cv2.setNumThreads(1)
    scene = make_scene(task.kind, task.seed, **dict(task.light))
    samples: list[Sample] = []
    rate = candidates.rate

    def keep(rgb: Picture, among: list[Candidate], index: int, *where: Any) -> float:  # noqa: ANN401
        terms = candidates.terms_of(rgb, among, index, *where)
        samples.append((task.seed, terms, is_right(scene, among[index].cable)))
        return rate(rgb, among, index, *where)

    with patch.object(candidates, "rate", keep), patch.object(detect, "rate", keep):
        detect_cables(scene.rendered.rgb)
    return samples


def fit(terms: Array, right: Array) -> Array:
    """Return the bias and the weights (k + 1,) for terms (n, k) of mean 0 and deviation 1."""
    rows = np.column_stack([np.ones(len(terms)), terms])
    price = PRICE * np.diag([0.0, *np.ones(terms.shape[1])])
    weights = np.zeros(rows.shape[1])
    for _ in range(ROUNDS):
        chance = 1 / (1 + np.exp(-np.clip(rows @ weights, -50, 50)))
        slope = rows.T @ (right - chance) - price @ weights
        bend = (rows * (chance * (1 - chance) + 1e-6)[:, None]).T @ rows + price
        weights = weights + np.linalg.solve(bend, slope)
    return np.asarray(weights)


def write(bias: float, weights: dict[str, float]) -> None:
    """Write the weights as a module of the package."""
    lines = [
        '"""Weights of the confidence, written by benchmarks/vision/fit_confidence.py."""',
        "",
        f"BIAS = {bias:.4f}",
        "WEIGHTS = {",
        *(f'    "{name}": {weight:.4f},' for name, weight in weights.items()),
        "}",
        "",
    ]
    Path(confidence_weights.__file__).resolve().write_text("\n".join(lines), encoding="utf-8")


def main() -> None:
    """Fit, write and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=40, help="per condition")
    parser.add_argument("--seed", type=int, default=20000, help="of the first scene")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--tables", type=Path, help="a folder of photographs without cables")
    options = parser.parse_args()
    kinds = [Kind(count, same) for count, same in itertools.product(COUNTS, (False, True))]
    conditions = [({}, {}), *BOTH.values()]
    tasks = [
        Task(replace(kinds[(i + c) % 10], **scene), options.seed + i, tuple(light.items()))
        for c, (scene, light) in enumerate(conditions)
        for i in range(options.scenes)
    ]
    photographs = sorted(options.tables.iterdir()) if options.tables else []
    tasks += [
        Task(cluttered(options.seed + i, photographs), options.seed + i)
        for i in range(CLUTTERED * options.scenes)
    ]
    with multiprocessing.get_context("spawn").Pool(options.processes) as pool:
        samples = [s for found in pool.imap(collect, tasks, chunksize=2) for s in found]
    names = list(samples[0][1])
    seeds = np.array([seed for seed, _, _ in samples])
    terms = np.array([[of[name] for name in names] for _, of, _ in samples])
    right = np.array([float(ok) for _, _, ok in samples])
    mean, deviation = terms.mean(axis=0), terms.std(axis=0) + 1e-9
    fitted = seeds % 2 == 0
    model = fit(((terms - mean) / deviation)[fitted], right[fitted])
    weights = model[1:] / deviation
    bias = float(model[0] - weights @ mean)
    chance = 1 / (1 + np.exp(-(bias + terms @ weights)))
    kept = [(float(c), bool(r)) for c, r in zip(chance[~fitted], right[~fitted], strict=True)]
    write(bias, dict(zip(names, weights.tolist(), strict=True)))
    report(Row("candidates for the fit", float(fitted.sum())))
    report(Row("candidates kept back", float(len(kept))))
    report(Row("candidates kept back, right", 100 * float(right[~fitted].mean()), "%"))
    report(Row("confidence of candidates kept back, AUC", auc(kept), "", at_least=0.95))


if __name__ == "__main__":
    main()
