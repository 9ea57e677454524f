"""Medians and limits of small arrays; numpy's own spend ten times as long on checks."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def limited(values: npt.NDArray[Any], low: npt.ArrayLike, high: npt.ArrayLike) -> npt.NDArray[Any]:
    """Return values, none of them below one limit or above another."""
    return np.minimum(np.maximum(values, low), high)


def median(values: npt.NDArray[Any]) -> float:
    """Return the upper median of a non-empty array, however shaped."""
    flat = values.ravel()
    return float(np.partition(flat, len(flat) // 2)[len(flat) // 2])


def median_colour(colours: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the upper median of each column of a non-empty array (n, k)."""
    return np.partition(colours, len(colours) // 2, axis=0)[len(colours) // 2]
