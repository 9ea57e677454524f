#!/usr/bin/env python3
# ruff: noqa: T201 - a command prints
"""Draw examples of the detection, good and bad, for docs/vision.md.

Usage: pictures.py FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np
from scenes import Kind, make_scene

from remodel_vision.cables import detect_cables
from remodel_vision.cables.lines import sketch

SHRINK = 0.75
# By name of the picture: scenes side by side, as kind, seed and light.
PICTURES: dict[str, tuple[tuple[Kind, int, dict[str, float]], ...]] = {
    "found": (
        (Kind(5, False), 29, {}),
        (Kind(5, True), 84, {}),
        (Kind(4, True), 28, {}),
    ),
    "unreliable": (
        (Kind(4, True), 63, {}),
        (Kind(3, False, clutter=4), 17, {}),
        (Kind(3, False), 57, {}),
    ),
    "wrong": (
        (Kind(5, False), 14, {}),
        (Kind(2, False), 6016, {"specular": 1.0}),
    ),
}


def main(folder: Path) -> None:
    """Write a picture for each name, and print the warnings."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, scenes in PICTURES.items():
        row = []
        for kind, seed, light in scenes:
            rgb = make_scene(kind, seed, **light).rendered.rgb
            found = detect_cables(rgb)
            print(name, seed, f"{len(found.cables)} of {kind.cables}", *found.warnings, sep="; ")
            row.append(cv2.resize(sketch(rgb, found), None, fx=SHRINK, fy=SHRINK, interpolation=3))
        strip = cv2.cvtColor(np.hstack(row), cv2.COLOR_RGB2BGR)
        cv2.imwrite(str(folder / f"cables-{name}.jpg"), strip, [cv2.IMWRITE_JPEG_QUALITY, 82])


if __name__ == "__main__":
    main(Path(sys.argv[1]))
