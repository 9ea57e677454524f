#!/usr/bin/env python3
"""Fit the weights of the detector's confidence, and print how well they separate right and wrong.

fit_confidence.py [--scenes N] [--seed FIRST] [--processes N] [--write]

Candidates in rendered scenes under all conditions of cables.py, and in cluttered ones, are compared
with the truth. A logistic model, by Newton's method with a small price of weights, gives the
probability that a cable is right. The fit is on even seeds; the printed figures are of odd ones.
With --write the weights go into the package.
"""

from __future__ import annotations

import argparse
import itertools
import multiprocessing
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from cables import CONDITIONS, COUNTS, Task, auc, cluttered, compared, distances, visible
from renderer import Array, Picture
from scenes import Kind, Scene

sys.path.insert(0, str(Path(__file__).parents[1]))
from figures import Figure, report

from remodel_vision.cables import DetectedCable, candidates, confidence_weights, detect
from remodel_vision.cables.candidates import Candidate

PRICE = 1.0
ROUNDS = 30
# So many times the scenes of a condition are cluttered.
CLUTTERED = 12

Sample = tuple[int, dict[str, float], bool]


def collect(task: Task) -> list[Sample]:
    """Return seed and terms of each candidate of a scene, and whether it is right."""
    scene = task.scene()
    samples: list[Sample] = []
    rate = candidates.rate

    def keep(rgb: Picture, among: list[Candidate], index: int, *where: Any) -> float:  # noqa: ANN401
        terms = candidates.terms_of(rgb, among, index, *where)
        samples.append((task.seed, terms, is_one_of(scene, among[index].cable)))
        return rate(rgb, among, index, *where)

    with patch.object(candidates, "rate", keep), patch.object(detect, "rate", keep):
        detect.detect_cables(scene.rgb)
    return samples


def is_one_of(scene: Scene, cable: DetectedCable) -> bool:
    """Return whether a cable found is one of a scene's, line and ends."""
    return any(
        np.ptp((line := visible(truth)), axis=0).max() > 0
        and np.median(distances(line[::8], cable.centreline)) < truth.width
        and compared(truth, cable)[2]
        for truth in scene.cables
    )


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
    """Fit, print, and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=40, help="per condition")
    parser.add_argument("--seed", type=int, default=20000, help="of the first scene")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--write", action="store_true", help="write the weights into the package")
    options = parser.parse_args()
    kinds = [Kind(count, same) for count, same in itertools.product(COUNTS, (False, True))]
    tasks = [
        Task(replace(kinds[(i + c) % 10], **scene), options.seed + i, tuple(light.items()))
        for c, (scene, light) in enumerate([({}, {}), *CONDITIONS.values()])
        for i in range(options.scenes)
    ]
    clutter = range(options.seed, options.seed + CLUTTERED * options.scenes)
    tasks += [Task(cluttered(seed), seed) for seed in clutter]
    with multiprocessing.get_context("spawn").Pool(options.processes) as pool:
        samples = [s for found in pool.imap(collect, tasks, chunksize=2) for s in found]
    names = list(samples[0][1])
    terms = np.array([[of[name] for name in names] for _, of, _ in samples])
    right = np.array([is_right for _, _, is_right in samples])
    is_fitted = np.array([seed % 2 == 0 for seed, _, _ in samples])
    mean, deviation = terms.mean(axis=0), terms.std(axis=0) + 1e-9
    model = fit(((terms - mean) / deviation)[is_fitted], right[is_fitted].astype(float))
    weights = model[1:] / deviation
    bias = float(model[0] - weights @ mean)
    kept = 1 / (1 + np.exp(-(bias + terms[~is_fitted] @ weights)))
    kept_right = right[~is_fitted]
    if options.write:
        write(bias, dict(zip(names, weights.tolist(), strict=True)))
    area = auc(kept[kept_right], kept[~kept_right])
    report(
        [
            Figure("candidates for the fit", float(is_fitted.sum())),
            Figure("candidates kept back", float(len(kept))),
            Figure("candidates kept back, right", 100 * float(kept_right.mean()), "%"),
            Figure("confidence of candidates kept back, AUC", area, least=0.95),
        ]
    )


if __name__ == "__main__":
    main()
