#!/usr/bin/env python3
"""Measure how well devices without labels are located, against the targets.

Each device is observed from above and then from the hand, as LocateGearboxComponent does in a cell
with `labels: false`, but without an arm. Adds to out/bench/vision.jsonl, and writes the table of
docs/vision.md to a file that is named.

Usage: devices.py [--scenes N] [--seed FIRST] [--processes N] [--devices N] [FILE]
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from device_scenes import BOARDS, DeviceScene, Mistake
from row import Row, report

from remodel_sim.physics.world import World
from remodel_skills.edge.parameter_files import read_parameters
from remodel_vision.device_pose import (
    DeviceView,
    locate_device,
    search_device,
    stands_there,
)
from remodel_vision.panel_pose import register_panel
from remodel_work.camera import Picture
from remodel_work.geometry import Pose
from remodel_work.panel import Component

PARAMETERS = read_parameters().parameters

# Places of the hand's camera over the device and beside it [m], in the order of their trial.
ASIDE_M = ((0.0, 0.0), *PARAMETERS.looking.label_aside_m)
# A device is located when it is no further off than this; further off is wrong: [mm], [deg].
WITHIN_MM, WITHIN_DEG = 0.5, 0.5
# One scene of so many has each of the mistakes.
MISTAKES = (None, None, None, *Mistake)


@dataclass(frozen=True)
class Task:
    """A scene to measure."""

    board: str
    seed: int
    devices: int
    mistake: Mistake | None


@dataclass(frozen=True)
class Answer:
    """What came of one device.

    Attributes:
        group: the board; or the mistake about the device.
        position: error of the terminal's opening that is furthest off [mm]; infinite when it was
            refused.
        angle: error [deg]; likewise.
    """

    group: str
    position: float = math.inf
    angle: float = math.inf

    @property
    def accepted(self) -> bool:
        """Whether there was an answer."""
        return math.isfinite(self.position)

    @property
    def within(self) -> bool:
        """Whether it is as near as it should be."""
        return self.position <= WITHIN_MM and self.angle <= WITHIN_DEG


def run(task: Task) -> list[Answer]:
    """Locate devices of a scene."""
    cv2.setNumThreads(1)
    world = World(240.0)
    try:
        scene = DeviceScene(world, BOARDS[task.board], task.seed, task.devices, task.mistake)
        above = scene.take_overhead_picture()
        panel_at = register_panel(above, scene.panel)
        answers = []
        for device in scene.devices:
            group = task.board
            if device is scene.wrong and task.mistake is not None:
                group = task.mistake.value
            found = None if panel_at is None else locate(scene, device, above, panel_at)
            if found is None:
                answers.append(Answer(group))
            else:
                answers.append(Answer(group, *_errors(scene, device, found)))
        return answers
    finally:
        world.close()


def locate(scene: DeviceScene, device: Component, above: Picture, panel_at: Pose) -> Pose | None:
    """Return where a device stands, by pictures from above and from the hand; None: refused."""
    near = panel_at @ device.panel_from_component
    views: list[DeviceView] = []
    for aside in ASIDE_M:
        picture = scene.take_wrist_picture(near.position[:2] + aside)
        view = search_device(picture, scene.panel, device, near)
        if view is None or not (seen := locate_device(device, [*views, view])).clear:
            continue
        views.append(view)
        if len(views) >= PARAMETERS.looking.enough_views and seen.reliable:
            found = seen.world_from_component
            return found if stands_there(above, device, found) else None
    return None


def _errors(scene: DeviceScene, device: Component, found: Pose) -> tuple[float, float]:
    """Return the greatest error of its openings [mm], and that of the direction [deg]."""
    true = scene.poses[device.id]
    openings = np.array([terminal.mouth for terminal in device.terminals])
    away = np.linalg.norm(found.apply(openings) - true.apply(openings), axis=1).max()
    cosine = (np.trace(found.rotation.T @ true.rotation) - 1) / 2
    return 1e3 * float(away), math.degrees(math.acos(float(np.clip(cosine, -1, 1))))


def table(groups: dict[str, list[Answer]]) -> list[dict[str, str]]:
    """Return the rows of the docs' table."""
    rows = []
    for group, answers in groups.items():
        good = [a for a in answers if a.accepted]
        wrong = sum(not a.within for a in good)
        if group in BOARDS:
            position = np.quantile([a.position for a in good] or [math.nan], [0.5, 0.9, 1.0])
            angle = np.quantile([a.angle for a in good] or [math.nan], [0.5, 0.9, 1.0])
            share = 100 * sum(a.within for a in answers) / len(answers)
            cells = (
                f"{share:.1f} %",
                " / ".join(f"{p:.2f}" for p in position) + " mm",
                " / ".join(f"{a:.2f}" for a in angle) + " deg",
                f"{wrong} (0)",
            )
        else:
            # Nothing is where it was drawn: any answer is wrong.
            cells = ("", "", "", f"{len(good)} (0)")
        keys = (
            "devices",
            "seen",
            "within 0.5 mm and 0.5 deg (95 %)",
            "position, median / p90 / max",
            "angle, median / p90 / max",
            "wrong (target)",
        )
        rows.append(dict(zip(keys, (group, str(len(answers)), *cells), strict=True)))
    return rows


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path, nargs="?", help="of the table, such as devices.jsonl")
    parser.add_argument("--scenes", type=int, default=24, help="per board")
    parser.add_argument("--seed", type=int, default=6000, help="of the first scene")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--devices", type=int, default=6, help="per scene, drawn by lot")
    options = parser.parse_args()
    tasks = [
        Task(board, options.seed + i, options.devices, MISTAKES[i % len(MISTAKES)])
        for board in BOARDS
        for i in range(options.scenes)
    ]
    groups: dict[str, list[Answer]] = defaultdict(list)
    with multiprocessing.get_context("spawn").Pool(options.processes) as pool:
        for answers in pool.imap(run, tasks):
            for answer in answers:
                groups[answer.group].append(answer)
    for board in BOARDS:
        good = [a for a in groups[board] if a.accepted]
        share = 100 * sum(a.within for a in groups[board]) / len(groups[board])
        name = f"devices, {board}, {len(groups[board])} seen"
        report(Row(f"{name}: within 0.5 mm and 0.5 deg", share, "%", at_least=95.0))
        report(Row(f"{name}: wrong", sum(not a.within for a in good), "", at_most=0))
    for mistake in Mistake:
        accepted = sum(a.accepted for a in groups[mistake.value])
        name = f"device {mistake.value}, {len(groups[mistake.value])} seen"
        report(Row(f"{name}: located all the same", accepted, "", at_most=0))
    if options.file is not None:
        ordered = {name: groups[name] for name in (*BOARDS, *(m.value for m in Mistake))}
        lines = [json.dumps(row) + "\n" for row in table(ordered)]
        options.file.write_text("".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
