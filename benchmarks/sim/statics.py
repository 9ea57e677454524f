"""The wire's statics against the elastica: sag, and the shape after buckling."""

from __future__ import annotations

import math
from collections.abc import Iterator

import rods
from elastica import buckled_tip_angle, cantilever_drop
from row import Row

LOADS = (1.0, 5.0, 21.0)
RATIOS = (0.97, 1.03, 1.06, 1.1, 1.2, 1.5, 2.0)
CELLS = 24


def rows() -> Iterator[Row]:
    """Measure."""
    for load in LOADS:
        exact = cantilever_drop(rods.LENGTH, 1.0, load / rods.LENGTH**3)
        error = 100 * abs(rods.sag(load, cells=CELLS) / exact - 1)
        yield Row(f"sag error, w L^3 / EI = {load:g}, N = {CELLS}", error, "%", most=0.3)
    exact = cantilever_drop(rods.LENGTH, 1.0, 5.0 / rods.LENGTH**3)
    error = 100 * abs(rods.sag(5.0, cells=CELLS, cut=CELLS // 2) / exact - 1)
    yield Row(f"sag error, w L^3 / EI = 5, N = {CELLS}, two bodies", error, "%", most=0.3)
    for ratio in RATIOS:
        angle = math.degrees(rods.buckle(ratio, cells=CELLS))
        exact = math.degrees(buckled_tip_angle(ratio))
        yield Row(f"tip angle error, P / Pcr = {ratio:g}", abs(angle - exact), "deg", most=0.5)
