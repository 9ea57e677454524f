#!/usr/bin/env python3
"""Measure the detection of cables on photographs with masks.

A folder holds NAME.jpg and NAME.labels.png each: for each pixel the number of the cable, 0 for the
background, and at a crossing the number of one of the two. An answer is right when it has as many
cables as the mask, and each follows one of its own from end to end.

Usage: photographs.py FOLDER [FILE]

FILE, such as docs/figures/photographs.jsonl, is the table of docs/vision.md.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from renderer import Array
from row import Row, report, start

from remodel_vision.cables import DetectedCable, Detection, detect_cables

# A cable is followed when so much of its line lies on it, and so much of it under its line: at
# crossings both belong to the other one.
ON, UNDER = 0.85, 0.85
# Masks drawn by hand are off by so much [px].
SLACK_PX = 3


@dataclass(frozen=True)
class Answer:
    """How an answer compares with a mask.

    Attributes:
        right: as many cables, each along one of the mask's.
        warned: the answer has warnings.
        cables: the confidence of each cable found, and whether it follows one of the mask's.
    """

    right: bool
    warned: bool
    cables: tuple[tuple[float, bool], ...]


def judge(found: Detection, labels: Array) -> Answer:
    """Compare an answer with a mask (height, width)."""
    taken: set[int] = set()
    cables = []
    for cable in found.cables:
        own = _followed(cable, labels)
        followed = own is not None and own not in taken
        taken |= {own} if own is not None else set()
        cables.append((cable.confidence, followed))
    numbers = set(np.unique(labels)) - {0}
    right = len(cables) == len(numbers) and all(followed for _, followed in cables)
    return Answer(right, bool(found.warnings), tuple(cables))


def _followed(cable: DetectedCable, labels: Array) -> int | None:
    """Return the number of the mask's cable that a found one follows from end to end."""
    line = np.rint(cable.centreline).astype(int)
    line = np.clip(line, 0, np.array(labels.shape[::-1]) - 1)
    numbers = labels[line[:, 1], line[:, 0]]
    number = int(np.argmax(np.bincount(numbers, minlength=2)[1:])) + 1
    mask = (labels == number).astype(np.uint8)
    near = cv2.dilate(mask, np.ones((2 * SLACK_PX + 1,) * 2, np.uint8))
    drawn = np.zeros_like(mask)
    fixed = np.rint(cable.centreline * 16).astype(np.int32)
    cv2.polylines(drawn, [fixed], False, 1, round(cable.width + 2 * SLACK_PX), cv2.LINE_8, 4)
    on = near[line[:, 1], line[:, 0]].mean()
    under = (drawn & mask).sum() / max(1, mask.sum())
    return number if on >= ON and under >= UNDER else None


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("file", type=Path, nargs="?", help="of the table")
    options = parser.parse_args()
    start()
    cv2.setNumThreads(1)
    answers = []
    for path in sorted(options.folder.glob("*.labels.png")):
        name = path.name.removesuffix(".labels.png")
        rgb = cv2.cvtColor(cv2.imread(str(path.with_name(f"{name}.jpg"))), cv2.COLOR_BGR2RGB)
        found = detect_cables(rgb)
        answer = judge(found, cv2.imread(str(path), cv2.IMREAD_UNCHANGED))
        answers.append(answer)
        if not answer.right or answer.warned:
            print(f"{name}: {'right' if answer.right else 'WRONG'}", *found.warnings, sep="\n  ")
    if not answers:
        parser.error(f"no NAME.labels.png in {options.folder}")
    count = len(answers)
    right = sum(a.right for a in answers)
    silent = sum(not a.right and not a.warned for a in answers)
    answered = sum(not a.warned for a in answers)
    rows = [
        Row("photographs", count),
        Row("number and pairing right", 100 * right / count, "%", 99.0),
        Row("answered without a warning", 100 * answered / count, "%", 90.0),
        Row("wrong without a warning", 100 * silent / count, "%", None, at_most=0.5),
    ]
    for row in rows:
        report(row)
    if options.file is not None:
        options.file.write_text("".join(map(_line, rows)), encoding="utf-8")


def _line(row: Row) -> str:
    figure = {"what": row.what, "value": row.value, "unit": row.unit}
    targets = {"least": row.at_least, "most": row.at_most}
    return json.dumps(figure | {k: v for k, v in targets.items() if v is not None}) + "\n"


if __name__ == "__main__":
    main()
