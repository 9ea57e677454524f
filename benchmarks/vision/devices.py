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
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path

import cv2
import numpy as np
from row import Row, report

from remodel_sim.physics.fixtures.panel_scene import PanelScene
from remodel_sim.physics.world import World, take
from remodel_skills.edge.parameter_files import read_parameters
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_vision.device_pose import DeviceView, locate_device, search_device, stands_there
from remodel_vision.panel_pose import register_panel
from remodel_work.camera import Picture, View, looking_down
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Array, Pose
from remodel_work.panel import BOARD, Component, Panel
from remodel_work.ros.panel_message import read_panel

# Panels without labels as they are mounted, under the cameras of their cells.
#
# The panel lies a few millimetres and a degree or so off its place; the devices of a rail stand
# further along it, and each a little aside and turned; the light differs from picture to picture.
# Some seeds have a mistake: a device is missing, turned by 180 degrees, or another one stands
# there.


CONFIG = Path(__file__).parents[2] / "src" / "remodel_sim" / "config"
# The wrist camera's height when it observes a component [m].
LENS_Z = 0.204
# How far the panel lies off its place along x and y [m], and turned [rad].
PANEL_M, PANEL_RAD = 0.008, math.radians(1.5)
LIGHT = (0.4, 1.6)


@dataclass(frozen=True)
class Board:
    """A panel and how its devices are mounted.

    Attributes:
        cell: whose cameras see it.
        panel: its file.
        row: how far the devices of a panel may all stand further along their rails [m].
        along, across: of each device, along its rail and across it [m].
        turn: of each device [rad].
    """

    cell: str
    panel: str
    row: float
    along: float
    across: float
    turn: float


BOARDS = {
    # Devices on rails: 2 mm between neighbours.
    "household": Board("cabinet", "household.yaml", 0.003, 0.0006, 0.0003, math.radians(0.4)),
    # Devices screwed to the plate, each by itself.
    "example": Board("one_panda", "panel.yaml", 0.0, 0.004, 0.003, math.radians(1.5)),
}


class Mistake(Enum):
    """What is not as drawn about one device."""

    MISSING = "missing"
    TURNED = "turned by 180 degrees"
    OTHER = "another device in its place"


class DeviceScene:
    """A panel without labels.

    Attributes:
        panel: as drawn.
        devices: that are to be located: some of the panel's.
        wrong: the device about which something is not as drawn; None: all is.
        poses: where each device stands, by its id, world frame.
    """

    def __init__(
        self, world: World, board: Board, seed: int, count: int, mistake: Mistake | None = None
    ) -> None:
        """Build the scene of a seed in an empty world, with `count` devices to be located."""
        self._random = np.random.default_rng([seed, 11])
        self._world = world
        self.panel = read_panel(CONFIG / board.panel, read_wire_materials())
        cell = read_cell(board.cell)
        self._overhead, self._wrist_lens = cell.overheads[0], cell.robots[0].camera.lens
        dx, dy, turn = self._random.uniform(-1, 1, 3) * (PANEL_M, PANEL_M, PANEL_RAD)
        panel_at = BOARD @ Pose.level(dx, dy, 0.0, turn)
        row = self._random.uniform(-1, 1) * board.row
        self.poses = {}
        for part in self.panel.components:
            along, across, turn = self._random.uniform(-1, 1, 3) * (
                board.along,
                board.across,
                board.turn,
            )
            shifted = Pose.level(across, along + row, 0.0) @ part.panel_from_component
            self.poses[part.id] = panel_at @ shifted @ Pose.level(0.0, 0.0, 0.0, turn)
        chosen = self._random.permutation(len(self.panel.components))[:count]
        self.devices = tuple(self.panel.components[i] for i in chosen)
        self.wrong = self.devices[0] if mistake is not None else None
        stands = self._with(mistake) if mistake is not None else self.panel
        world.clear()
        PanelScene(
            world,
            cell.table,
            replace(stands, wires=()),
            self.poses,
            world_from_panel=panel_at,
            labels=False,
        )

    def _with(self, mistake: Mistake) -> Panel:
        """Return the panel with a mistake about the first of the devices."""
        assert self.wrong is not None, "a mistake is about a device"
        wrong, others = self.wrong, [c for c in self.panel.components if c is not self.wrong]
        if mistake is Mistake.MISSING:
            return replace(self.panel, components=tuple(others))
        if mistake is Mistake.TURNED:
            self.poses[wrong.id] @= Pose.level(0.0, 0.0, 0.0, math.pi)
            return self.panel
        like = [c for c in others if c.size != wrong.size and c.size[1] < wrong.size[1] * 1.1]
        other = like[int(self._random.integers(len(like)))] if like else _wider(wrong)
        standing = replace(other, id=wrong.id, pose=wrong.pose)
        return replace(self.panel, components=(*others, standing))

    def take_overhead_picture(self) -> Picture:
        """Take a picture of the whole plate, with depth."""
        light = self._random.uniform(*LIGHT)
        return take(self._world, self._overhead, self._random, depth=True, light=light)

    def take_wrist_picture(self, place: Array) -> Picture:
        """Take a picture from the hand over a place (2,) [m]; the hand is turned by chance."""
        turn = self._random.uniform(-math.pi, math.pi)
        view = View(self._wrist_lens, looking_down(float(place[0]), float(place[1]), LENS_Z, turn))
        return take(self._world, view, self._random, light=self._random.uniform(*LIGHT))


def _wider(component: Component) -> Component:
    """Return a device like another one, but 4 mm wider and without its last terminal."""
    depth, width, height = component.size
    return replace(
        component, size=(depth, width + 0.004, height), terminals=component.terminals[:-1]
    )


# The measurement


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
