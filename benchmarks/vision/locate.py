#!/usr/bin/env python3
"""Measure how well components are located by their labels, against the targets.

Each component of a scene is observed from above and then from the hand, as LocateGearboxComponent
does, but without an arm. Adds to out/bench/vision.jsonl, and writes the table of docs/vision.md to
a file that is named.

Usage: locate.py [--scenes N] [--seed FIRST] [--processes N] [--conditions NAME,NAME] [FILE]
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
from row import Row, report

from remodel_sim.physics.fixtures.panel_scene import PanelScene
from remodel_sim.physics.wires.parked_wire import draw_parked
from remodel_sim.physics.world import NOISE_LEVELS, World, take
from remodel_skills.edge.parameter_files import read_parameters
from remodel_states.core.wires import DISTINCT_COLOURS
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_vision.label_pose import LabelView, locate_component
from remodel_vision.labels import find_labels, search_label
from remodel_work.camera import Picture, View, looking_down
from remodel_work.component_shape import LABEL_MARGIN_CELLS, Box, component_boxes, label_corners
from remodel_work.edge.bullet import add_static
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Array, Pose
from remodel_work.panel import BOARD, Component, Panel
from remodel_work.ros.panel_message import read_panel

# Components on a plate under conditions that make locating hard, as the cell's cameras see them.
#
# The cell's own panel, rendered with the cell's cameras; labels, sizes and poses are drawn by lot.
# What the cell does not have is added to the pictures: uneven light, highlights, glare, blur.


# Changes of pose: along the plate [m], about its normal [rad]; off it [m], and tilted [rad].
SHIFT_M, TURN_RAD = 0.010, math.radians(8.0)
LIFT_M, TILT_RAD = 0.004, math.radians(5.0)
LABEL_M = (0.018, 0.030)
LABELS = 250
# The wrist camera's height when it observes a label [m].
LENS_Z = 0.204
# Wires over labels: so many, so high above the plate [m].
WIRES, WIRE_Z_M = 3, (0.050, 0.075)
# Tape lies so far above the label [m], in one of these colours: white, black, greys, tan, blue.
TAPE_Z_M = 0.0006
TAPE_RGB = (
    (0.95, 0.95, 0.95),
    (0.05, 0.05, 0.05),
    (0.3, 0.3, 0.3),
    (0.55, 0.55, 0.55),
    (0.78, 0.66, 0.45),
    (0.2, 0.3, 0.7),
)
# Glare adds so many grey levels in its middle, falls off over this share of a label's side, and
# moves by up to this share of the way of the lens.
GLARE_LEVELS, GLARE_SIDE, GLARE_DRIFT = (80.0, 400.0), (0.12, 0.35), 0.5


@dataclass(frozen=True)
class Condition:
    """What makes it hard.

    Attributes:
        askew: components are lifted and tilted too.
        light: the least and the greatest share of the usual light.
        uneven: how much the light changes over a picture, and highlights.
        blur: the least and the greatest standard deviation [px], on top of the lens's own.
        clutter: wires over labels, and labels that the panel lacks.
        tape: share of each label under a strip of tape.
        glare: a bright spot on each label.
    """

    askew: bool = False
    light: tuple[float, float] = (1.0, 1.0)
    uneven: float = 0.0
    blur: tuple[float, float] = (0.0, 0.0)
    clutter: bool = False
    tape: float = 0.0
    glare: bool = False


@dataclass(frozen=True)
class Glare:
    """A bright spot: its place (3,) [m] from straight above, world frame.

    Its levels are those in its middle; it falls off over a size [m], and moves with the lens.
    """

    place: Array
    levels: float
    size: float
    drift: float


class LabelScene:
    """A plate with components; under the cameras.

    Attributes:
        components: with labels drawn by lot.
        poses: where each component stands, by its id, world frame.
    """

    def __init__(self, world: World, panel: Panel, condition: Condition, seed: int) -> None:
        self._random = np.random.default_rng([seed, 7])
        self._world, self._condition = world, condition
        markers = self._random.permutation(LABELS)
        own = len(panel.components)
        self.components = tuple(
            replace(part, marker_id=int(marker), marker_size=self._random.uniform(*LABEL_M))
            for part, marker in zip(panel.components, markers[:own], strict=True)
        )
        self.poses = {part.id: self._stands(part) for part in self.components}
        world.clear()
        bare = replace(panel, components=self.components, wires=())
        cell = read_cell()
        self._overhead, self._wrist_lens = cell.overheads[0], cell.robots[0].camera.lens
        PanelScene(world, cell.table, bare, self.poses)
        if condition.clutter:
            self._add_strangers(markers[own : 2 * own])
            for _ in range(WIRES):
                self._add_wire(panel)
        if condition.tape:
            for part in self.components:
                self._tape(part)
        self._glares = [self._glare(part) for part in self.components if condition.glare]

    def _stands(self, part: Component) -> Pose:
        dx, dy, turn = self._random.uniform(-1, 1, 3) * (SHIFT_M, SHIFT_M, TURN_RAD)
        moved = part.panel_from_component @ Pose.level(dx, dy, 0.0, turn)
        if self._condition.askew:
            way, angle = self._random.uniform(0, (2 * math.pi, TILT_RAD))
            half = math.sin(angle / 2) * np.array([math.cos(way), math.sin(way), 0.0])
            tilt = np.array([*half, math.cos(angle / 2)])
            moved @= Pose(np.array([0.0, 0.0, self._random.uniform(0, LIFT_M)]), tilt)
        return BOARD @ moved

    def _add_strangers(self, markers: npt.NDArray[np.int64]) -> None:
        """Stand small components with other labels on the plate."""
        for marker in markers:
            x, y = self._random.uniform(-1, 1, 2) * (0.03, 0.25)
            size = self._random.uniform(*LABEL_M)
            wide = size * (1 + 2 * LABEL_MARGIN_CELLS / 6)
            part = Component("", "", int(marker), size, (x, y, 0.0), (wide, wide, 0.02), ())
            pose = BOARD @ Pose.level(x, y, 0.0, self._random.uniform(-3, 3))
            add_static(self._world.bullet, component_boxes(part), pose)

    def _add_wire(self, panel: Panel) -> None:
        """Hang a wire over a component's label, or past it."""
        part = self.components[self._random.integers(len(self.components))]
        aside = np.array([*self._random.uniform(-0.015, 0.015, 2), 0.0])
        middle = self.poses[part.id].position + aside
        way = self._random.uniform(0, math.pi)
        along = np.linspace(-0.08, 0.08, 9)[:, None] * [math.cos(way), math.sin(way), 0.0]
        nodes = middle + along + [0.0, 0.0, self._random.uniform(*WIRE_Z_M)]
        colour = str(self._random.choice(sorted(DISTINCT_COLOURS)))
        draw_parked(self._world, nodes, replace(panel.wires[0], colour=colour))

    def _tape(self, part: Component) -> None:
        """Stick a strip over a label, in any direction, also along its edge."""
        way, aside = self._random.uniform((0, -0.5), (math.pi, 0.5))
        side = part.marker_size
        away = aside * side * np.array([-math.sin(way), math.cos(way), 0.0])
        top = np.array([0.0, 0.0, float(label_corners(part)[0, 2]) + TAPE_Z_M])
        size = (2.0 * side, self._condition.tape * side, 0.0002)
        colour = TAPE_RGB[self._random.integers(len(TAPE_RGB))]
        strip = Box(tuple((away + top).tolist()), size, colour, (0.0, 0.0, way), solid=False)
        add_static(self._world.bullet, [strip], self.poses[part.id])

    def _glare(self, part: Component) -> Glare:
        aside = self._random.uniform(-0.5, 0.5, 2) * part.marker_size
        middle = label_corners(part).mean(axis=0) + np.array([*aside, 0.0])
        return Glare(
            self.poses[part.id].apply(middle),
            self._random.uniform(*GLARE_LEVELS),
            self._random.uniform(*GLARE_SIDE) * part.marker_size,
            self._random.uniform(0.0, GLARE_DRIFT),
        )

    def take_overhead_picture(self) -> Picture:
        """Take a picture of the whole plate."""
        return self._worse(take(self._world, self._overhead, self._random))

    def take_wrist_picture(self, place: Array) -> Picture:
        """Take a picture from the hand over a place (2,) [m]; the hand is turned by chance."""
        turn = self._random.uniform(-math.pi, math.pi)
        view = View(self._wrist_lens, looking_down(float(place[0]), float(place[1]), LENS_Z, turn))
        return self._worse(take(self._world, view, self._random))

    def _worse(self, picture: Picture) -> Picture:
        condition, random = self._condition, self._random
        height, width = picture.rgb.shape[:2]
        levels = picture.rgb.astype(np.float32) * random.uniform(*condition.light)
        if condition.uneven:
            x, y = np.meshgrid(np.linspace(-1, 1, width), np.linspace(-1, 1, height))
            way = random.uniform(0, 2 * math.pi)
            fade = 1 + condition.uneven * (x * math.cos(way) + y * math.sin(way))
            spot = random.uniform(-1, 1, 2)
            shine = np.exp(-((x - spot[0]) ** 2 + (y - spot[1]) ** 2) / 0.1)
            levels = levels * fade[..., None] + 120 * condition.uneven * shine[..., None]
        for glare in self._glares:
            lens = picture.view.world_from_camera.position[:2]
            moved = glare.place + np.array([*(glare.drift * (lens - glare.place[:2])), 0.0])
            middle = picture.view.project(moved)[0]
            spread = glare.size / picture.view.metres_per_pixel(float(moved[2]))
            columns, rows = np.meshgrid(np.arange(width), np.arange(height))
            away = np.square(columns - middle[0]) + np.square(rows - middle[1])
            levels = levels + glare.levels * np.exp(-away / (2 * spread**2))[..., None]
        blur = random.uniform(*condition.blur)
        if blur > 0:
            levels = cv2.GaussianBlur(levels, (0, 0), blur)
            levels += random.normal(0, NOISE_LEVELS, levels.shape)
        rgb = np.clip(np.rint(levels), 0, 255).astype(np.uint8)
        return Picture(rgb, None, picture.view)


# The measurement


PARAMETERS = read_parameters().parameters

PANEL = Path(__file__).parents[2] / "src" / "remodel_sim" / "config" / "panel.yaml"
# Places of the hand's camera over the label and beside it [m], in the order of their trial.
ASIDE_M = ((0.0, 0.0), *PARAMETERS.looking.label_aside_m)
# An error above these is a wrong answer, not an inexact one: [mm], [deg].
WRONG_MM, WRONG_DEG = 3.0, 3.0
TAPE, GLARE = "tape over 15 %", "glare"
CONDITIONS = {
    "upright": Condition(),
    "askew": Condition(askew=True),
    "light 40 to 160 %": Condition(askew=True, light=(0.4, 1.6)),
    "uneven light": Condition(askew=True, uneven=0.4),
    "blur 1 to 2 px": Condition(askew=True, blur=(1.0, 2.0)),
    "clutter": Condition(askew=True, clutter=True),
    TAPE: Condition(askew=True, tape=0.15),
    GLARE: Condition(askew=True, glare=True),
    "all at once": Condition(True, (0.4, 1.6), 0.4, (0.0, 2.0), True),
}


@dataclass(frozen=True)
class Answer:
    """What came of one component.

    Attributes:
        above: whether it was seen from above.
        observations: from the hand.
        position: error of the first terminal's opening [mm]; infinite when it was refused.
        angle: error [deg]; likewise.
    """

    above: bool
    observations: int
    position: float = math.inf
    angle: float = math.inf


def locate(scene: LabelScene, component: Component) -> Answer:
    """Locate a component, and compare the answer with the truth."""
    nominal = BOARD @ component.panel_from_component
    corners = _label(scene, component, picture := scene.take_overhead_picture(), nominal)
    above = None if corners is None else locate_component(component, [LabelView(picture, corners)])
    coarse = above.world_from_component if above is not None and above.clear else nominal
    views: list[LabelView] = []
    for count, aside in enumerate(ASIDE_M, start=1):
        picture = scene.take_wrist_picture(coarse.position[:2] + aside)
        if (corners := _label(scene, component, picture, coarse)) is None:
            continue
        views.append(LabelView(picture, corners))
        observation = locate_component(component, views)
        if not observation.clear:
            views.pop()
        elif len(views) >= PARAMETERS.looking.enough_views and observation.reliable:
            found = observation.world_from_component
            return Answer(coarse is not nominal, count, *_errors(scene, component, found))
    return Answer(coarse is not nominal, len(ASIDE_M))


def _label(scene: LabelScene, component: Component, picture: Picture, near: Pose) -> Array | None:
    corners = find_labels(picture, scene.components).get(component.marker_id)
    return search_label(picture, component, near) if corners is None else corners


def _errors(scene: LabelScene, component: Component, found: Pose) -> tuple[float, float]:
    """Return the errors of a terminal's opening [mm] and of the direction [deg]."""
    true = scene.poses[component.id]
    opening = np.array(component.terminals[0].mouth)
    away = float(np.linalg.norm(found.apply(opening) - true.apply(opening)))
    cosine = (np.trace(found.rotation.T @ true.rotation) - 1) / 2
    return 1e3 * away, math.degrees(math.acos(float(np.clip(cosine, -1, 1))))


def run(task: tuple[Condition, int]) -> list[Answer]:
    """Locate all components of a scene."""
    cv2.setNumThreads(1)
    world = World(240.0)
    try:
        scene = LabelScene(world, read_panel(PANEL, read_wire_materials()), *task)
        return [locate(scene, component) for component in scene.components]
    finally:
        world.close()


def is_wrong(answer: Answer) -> bool:
    """Return whether an answer was accepted, and is wrong."""
    accepted = math.isfinite(answer.position)
    return accepted and (answer.position > WRONG_MM or answer.angle > WRONG_DEG)


def rows(name: str, answers: list[Answer]) -> Iterator[Row]:
    """Yield the figures of a condition."""
    positions = [a.position for a in answers if math.isfinite(a.position)]
    angles = [a.angle for a in answers if math.isfinite(a.angle)]
    wrong = [is_wrong(answer) for answer in answers]
    group = f"locate, {name}"
    yield Row(f"{group}: located", 100 * len(positions) / len(answers), "%")
    yield Row(f"{group}: seen from above", 100 * sum(a.above for a in answers) / len(answers), "%")
    yield Row(
        f"{group}: observations from the hand",
        float(np.mean([a.observations for a in answers])),
        "",
    )
    yield Row(f"{group}: position, median", float(np.median(positions)), "mm", at_most=0.5)
    yield Row(f"{group}: position, p90", float(np.quantile(positions, 0.9)), "mm", at_most=1.0)
    yield Row(f"{group}: angle, median", float(np.median(angles)), "deg", at_most=0.5)
    yield Row(f"{group}: angle, p90", float(np.quantile(angles, 0.9)), "deg", at_most=1.0)
    yield Row(f"{group}: wrong", 100 * sum(wrong) / len(answers), "%", at_most=1.0)


def table_row(name: str, answers: list[Answer]) -> dict[str, str]:
    """Return a row of the docs' table."""
    good = [a for a in answers if math.isfinite(a.position)]
    position = np.quantile([a.position for a in good] or [math.nan], [0.5, 0.9])
    angle = np.quantile([a.angle for a in good] or [math.nan], [0.5, 0.9])
    return {
        "components": name,
        "seen": str(len(answers)),
        "located": f"{100 * len(good) / len(answers):.0f} %",
        "position, median / p90 (0.5 / 1.0)": f"{position[0]:.2f} / {position[1]:.2f} mm",
        "angle, median / p90 (0.5 / 1.0)": f"{angle[0]:.2f} / {angle[1]:.2f} deg",
        "wrong (0)": str(sum(map(is_wrong, answers))),
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path, nargs="?", help="of the table, such as labels.jsonl")
    parser.add_argument("--scenes", type=int, default=200, help="an eighth per condition")
    parser.add_argument("--seed", type=int, default=5000, help="of the first scene")
    parser.add_argument("--processes", type=int, default=2)
    known = ", ".join(CONDITIONS)
    parser.add_argument("--conditions", help=f"only these, of {known}".replace("%", "%%"))
    options = parser.parse_args()
    chosen = (options.conditions or ",".join(CONDITIONS)).split(",")
    if unknown := set(chosen) - set(CONDITIONS):
        parser.error(f"--conditions: {', '.join(sorted(unknown))} unknown; allowed: {known}")
    seeds = range(options.seed, options.seed + max(3, options.scenes // 8))
    with multiprocessing.get_context("spawn").Pool(options.processes) as pool:
        covered: list[Answer] = []
        lines: list[str] = []
        for name in chosen:
            scenes = pool.map(run, [(CONDITIONS[name], seed) for seed in seeds], chunksize=1)
            answers = [answer for scene in scenes for answer in scene]
            for row in rows(name, answers):
                report(row)
            lines.append(json.dumps(table_row(name, answers)) + "\n")
            covered += answers if name in (TAPE, GLARE) else []
        if covered:
            accepted = sum(math.isfinite(a.position) for a in covered)
            what = f"under tape or glare: wrong of {accepted} accepted of {len(covered)}"
            report(Row(what, sum(map(is_wrong, covered)), at_most=0))
    if options.file is not None:
        options.file.write_text("".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
