#!/usr/bin/env python3
"""Measure how well components are located, by their labels and without.

components.py labels|devices [--scenes N] [--seed FIRST] [--processes N] [--figures FILE]; the
workspace must be sourced. Each component is observed from above and then from the hand, as
LocateGearboxComponent does, but without an arm. Prints a table of docs/vision.md.

labels: the cell's own panel, rendered with the cell's cameras; labels, sizes and poses are drawn by
lot. What the cell does not have is added to the pictures: uneven light, highlights, glare, blur.

devices: panels without labels as they are mounted. The panel lies a few millimetres and a degree or
so off its place; the devices of a rail stand further along it, and each a little aside and turned;
the light differs from picture to picture. Some seeds have a mistake about one device.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_work/test"))
from figures import add_figures_option, report_table
from panels import example

from remodel_sim.physics.fixtures.panel_scene import PanelScene
from remodel_sim.physics.wires.parked_wire import draw_parked
from remodel_sim.physics.world import NOISE_LEVELS, World, take_picture
from remodel_skills.edge.parameter_files import read_parameters
from remodel_states.core.wires import DISTINCT_COLOURS
from remodel_vision.device_pose import DeviceView, locate_device, search_device, stands_there
from remodel_vision.label_pose import LabelView, locate_component
from remodel_vision.labels import find_labels, search_label
from remodel_vision.panel_pose import register_panel
from remodel_work.camera import Picture, View, looking_down
from remodel_work.component_shape import LABEL_MARGIN_CELLS, Box, component_boxes, label_corners
from remodel_work.edge.bullet import add_static
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Array, Pose
from remodel_work.panel import BOARD, Component, Panel

LOOKING = read_parameters().parameters.looking
# Places of the hand's camera over the component and beside it [m], in the order of their trial.
ASIDE_M = ((0.0, 0.0), *LOOKING.label_aside_m)
# The wrist camera's height when it observes a component [m].
LENS_Z = 0.204
LIGHT = (0.4, 1.6)  # share of the usual light


@dataclass(frozen=True)
class Answer:
    """What came of one component.

    Attributes:
        group: row of the table.
        position: error of openings [mm]; infinite when the component was refused.
        angle: error [deg]; likewise.
    """

    group: str
    position: float = math.inf
    angle: float = math.inf

    @property
    def is_located(self) -> bool:
        """Whether there was an answer."""
        return math.isfinite(self.position)

    def is_off(self, most_mm: float, most_deg: float) -> bool:
        """Whether there was an answer, and it is further off than this."""
        return self.is_located and (self.position > most_mm or self.angle > most_deg)


def compared(group: str, true: Pose, found: Pose | None, openings: Array) -> Answer:
    """Compare what was found of a component with the truth, by openings (n, 3) in its frame."""
    if found is None:
        return Answer(group)
    away = np.linalg.norm(found.apply(openings) - true.apply(openings), axis=1).max()
    cosine = (np.trace(found.rotation.T @ true.rotation) - 1) / 2
    return Answer(group, 1e3 * float(away), math.degrees(math.acos(min(1.0, max(-1.0, cosine)))))


class Cameras:
    """The cameras of a cell over a scene of a seed."""

    def __init__(self, world: World, cell: str, random: np.random.Generator) -> None:
        self._world, self._random = world, random
        self.design = read_cell(cell)
        world.clear()

    def from_above(self, light: tuple[float, float] | None = None) -> Picture:
        """Take a picture of the whole plate, with depth if the light is drawn from a range."""
        return self._take(self.design.overheads[0], light, depth=light is not None)

    def from_hand(self, place: Array, light: tuple[float, float] | None = None) -> Picture:
        """Take a picture from the hand over a place (2,) [m]; the hand is turned by chance."""
        turn = self._random.uniform(-math.pi, math.pi)
        at = looking_down(float(place[0]), float(place[1]), LENS_Z, turn)
        return self._take(View(self.design.robots[0].camera.lens, at), light)

    def _take(
        self, view: View, light: tuple[float, float] | None, *, depth: bool = False
    ) -> Picture:
        share = 1.0 if light is None else self._random.uniform(*light)
        return take_picture(self._world, view, self._random, depth=depth, light=share)


# Components with labels.

# Changes of pose: along the plate [m], about its normal [rad]; off it [m], and tilted [rad].
SHIFT_M, TURN_RAD = 0.010, math.radians(8.0)
LIFT_M, TILT_RAD = 0.004, math.radians(5.0)
LABEL_M, LABELS = (0.018, 0.030), 250
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
# An error above these is a wrong answer, not an inexact one: [mm], [deg].
WRONG = (3.0, 3.0)


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

    askew: bool = True
    light: tuple[float, float] = (1.0, 1.0)
    uneven: float = 0.0
    blur: tuple[float, float] = (0.0, 0.0)
    clutter: bool = False
    tape: float = 0.0
    glare: bool = False


CONDITIONS = {
    "upright": Condition(askew=False),
    "askew": Condition(),
    "light 40 to 160 %": Condition(light=LIGHT),
    "uneven light": Condition(uneven=0.4),
    "blur 1 to 2 px": Condition(blur=(1.0, 2.0)),
    "clutter": Condition(clutter=True),
    "tape over 15 %": Condition(tape=0.15),
    "glare": Condition(glare=True),
    "all at once": Condition(light=LIGHT, uneven=0.4, blur=(0.0, 2.0), clutter=True),
}


class LabelScene:
    """A plate with components under the cameras.

    Attributes:
        components: with labels drawn by lot.
        poses: where each component stands, by its id, world frame.
    """

    def __init__(self, world: World, condition: Condition, seed: int) -> None:
        panel = example("panel")
        self._random = np.random.default_rng([seed, 7])
        self._world, self._condition = world, condition
        markers = self._random.permutation(LABELS)
        own = len(panel.components)
        self.components = tuple(
            replace(part, marker_id=int(marker), marker_size=self._random.uniform(*LABEL_M))
            for part, marker in zip(panel.components, markers[:own], strict=True)
        )
        self.poses = {part.id: self._stands(part) for part in self.components}
        self._cameras = Cameras(world, "one_panda", self._random)
        bare = replace(panel, components=self.components, wires=())
        PanelScene(world, self._cameras.design.table, bare, self.poses)
        if condition.clutter:
            for marker in markers[own : 2 * own]:
                self._add_stranger(int(marker))
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

    def _add_stranger(self, marker: int) -> None:
        """Stand a small component with another label on the plate."""
        x, y = self._random.uniform(-1, 1, 2) * (0.03, 0.25)
        size = self._random.uniform(*LABEL_M)
        wide = size * (1 + 2 * LABEL_MARGIN_CELLS / 6)
        part = Component("", "", marker, size, (x, y, 0.0), (wide, wide, 0.02), ())
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

    def _glare(self, part: Component) -> tuple[Array, float, float, float]:
        """Return a bright spot: place (3,) [m], levels, size [m], and share that it drifts."""
        aside = self._random.uniform(-0.5, 0.5, 2) * part.marker_size
        middle = label_corners(part).mean(axis=0) + np.array([*aside, 0.0])
        place, levels = self.poses[part.id].apply(middle), self._random.uniform(*GLARE_LEVELS)
        size = self._random.uniform(*GLARE_SIDE) * part.marker_size
        return place, levels, size, self._random.uniform(0.0, GLARE_DRIFT)

    def locate(self, component: Component) -> Pose | None:
        """Return where a component stands, by pictures from above and from the hand."""
        nominal = BOARD @ component.panel_from_component
        corners = self._label(component, above := self._worse(self._cameras.from_above()), nominal)
        seen = None if corners is None else locate_component(component, [LabelView(above, corners)])
        coarse = seen.world_from_component if seen is not None and seen.clear else nominal
        views: list[LabelView] = []
        for aside in ASIDE_M:
            picture = self._worse(self._cameras.from_hand(coarse.position[:2] + aside))
            if (corners := self._label(component, picture, coarse)) is None:
                continue
            views.append(LabelView(picture, corners))
            observation = locate_component(component, views)
            if not observation.clear:
                views.pop()
            elif len(views) >= LOOKING.enough_views and observation.reliable:
                return observation.world_from_component
        return None

    def _label(self, component: Component, picture: Picture, near: Pose) -> Array | None:
        corners = find_labels(picture, self.components).get(component.marker_id)
        return search_label(picture, component, near) if corners is None else corners

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
        for place, bright, size, drift in self._glares:
            lens = picture.view.world_from_camera.position[:2]
            moved = place + np.array([*(drift * (lens - place[:2])), 0.0])
            middle = picture.view.project(moved)[0]
            spread = size / picture.view.metres_per_pixel(float(moved[2]))
            columns, rows = np.meshgrid(np.arange(width), np.arange(height))
            away = np.square(columns - middle[0]) + np.square(rows - middle[1])
            levels = levels + bright * np.exp(-away / (2 * spread**2))[..., None]
        blur = random.uniform(*condition.blur)
        if blur > 0:
            levels = cv2.GaussianBlur(levels, (0, 0), blur)
            levels += random.normal(0, NOISE_LEVELS, levels.shape)
        rgb = np.clip(np.rint(levels), 0, 255).astype(np.uint8)
        return Picture(rgb, None, picture.view)


def locate_labels(world: World, name: str, seed: int) -> Iterator[Answer]:
    """Locate all components of a scene; compare one opening of each."""
    scene = LabelScene(world, CONDITIONS[name], seed)
    for part in scene.components:
        openings = np.array([part.terminals[0].mouth])
        yield compared(name, scene.poses[part.id], scene.locate(part), openings)


def label_row(name: str, answers: list[Answer]) -> dict[str, str]:
    """Return a row of the table of labels."""
    good = [a for a in answers if a.is_located]
    position, angle = errors(good, (0.5, 0.9))
    return {
        "components": name,
        "seen": str(len(answers)),
        "located": f"{100 * len(good) / len(answers):.0f} %",
        "position, median / p90 (0.5 / 1.0)": f"{position} mm",
        "angle, median / p90 (0.5 / 1.0)": f"{angle} deg",
        "wrong (0)": str(sum(a.is_off(*WRONG) for a in answers)),
    }


def errors(good: list[Answer], shares: tuple[float, ...]) -> tuple[str, str]:
    """Return quantiles of the errors of position and angle."""
    found = ([a.position for a in good], [a.angle for a in good])
    position, angle = (
        " / ".join(f"{q:.2f}" for q in np.quantile(each or [math.nan], shares)) for each in found
    )
    return position, angle


# Devices without labels.

# How far the panel lies off its place along x and y [m], and turned [rad].
PANEL_M, PANEL_RAD = 0.008, math.radians(1.5)
# So many devices of a scene are located, drawn by lot.
DEVICES = 6
# A device is located when it is no further off than this; further off is wrong: [mm], [deg].
WITHIN = (0.5, 0.5)
MISSING, TURNED, OTHER = "missing", "turned by 180 degrees", "another device in its place"
# One scene of so many has each of the mistakes.
MISTAKES = ("", "", "", MISSING, TURNED, OTHER)


@dataclass(frozen=True)
class Board:
    """A panel and how its devices are mounted.

    Attributes:
        cell: whose cameras see it.
        panel: the example panel.
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
    "household": Board("cabinet", "household", 0.003, 0.0006, 0.0003, math.radians(0.4)),
    # Devices screwed to the plate, each by itself.
    "example": Board("one_panda", "panel", 0.0, 0.004, 0.003, math.radians(1.5)),
}


class DeviceScene:
    """A panel without labels.

    Attributes:
        devices: that are to be located: some of the panel's; a mistake is about the first.
        poses: where each device stands, by its id, world frame.
    """

    def __init__(self, world: World, board: Board, seed: int, mistake: str) -> None:
        self._random = random = np.random.default_rng([seed, 11])
        self._panel = example(board.panel)
        self._cameras = Cameras(world, board.cell, random)
        dx, dy, turn = random.uniform(-1, 1, 3) * (PANEL_M, PANEL_M, PANEL_RAD)
        panel_at = BOARD @ Pose.level(dx, dy, 0.0, turn)
        row = random.uniform(-1, 1) * board.row
        self.poses = {}
        for part in self._panel.components:
            offs = (board.along, board.across, board.turn)
            along, across, turn = random.uniform(-1, 1, 3) * offs
            shifted = Pose.level(across, along + row, 0.0) @ part.panel_from_component
            self.poses[part.id] = panel_at @ shifted @ Pose.level(0.0, 0.0, 0.0, turn)
        chosen = random.permutation(len(self._panel.components))[:DEVICES]
        self.devices = tuple(self._panel.components[i] for i in chosen)
        stands = self._with(mistake, self.devices[0]) if mistake else self._panel.components
        shown = replace(self._panel, components=stands, wires=())
        table = self._cameras.design.table
        PanelScene(world, table, shown, self.poses, world_from_panel=panel_at, labels=False)
        self._above = self._cameras.from_above(LIGHT)
        self._panel_at = register_panel(self._above, self._panel)

    def _with(self, mistake: str, wrong: Component) -> tuple[Component, ...]:
        """Return the components with a mistake about one of them."""
        others = [c for c in self._panel.components if c is not wrong]
        if mistake == MISSING:
            return tuple(others)
        if mistake == TURNED:
            self.poses[wrong.id] @= Pose.level(0.0, 0.0, 0.0, math.pi)
            return self._panel.components
        like = [c for c in others if c.size != wrong.size and c.size[1] < wrong.size[1] * 1.1]
        if like:
            other = like[int(self._random.integers(len(like)))]
        else:  # 4 mm wider and without its last terminal
            depth, width, height = wrong.size
            size = (depth, width + 0.004, height)
            other = replace(wrong, size=size, terminals=wrong.terminals[:-1])
        return (*others, replace(other, id=wrong.id, pose=wrong.pose))

    def locate(self, device: Component) -> Pose | None:
        """Return where a device stands, by pictures from above and from the hand."""
        if self._panel_at is None:
            return None
        near = self._panel_at @ device.panel_from_component
        views: list[DeviceView] = []
        for aside in ASIDE_M:
            picture = self._cameras.from_hand(near.position[:2] + aside, LIGHT)
            view = search_device(picture, self._panel, device, near)
            if view is None or not (seen := locate_device(device, [*views, view])).clear:
                continue
            views.append(view)
            if len(views) >= LOOKING.enough_views and seen.reliable:
                found = seen.world_from_component
                return found if stands_there(self._above, device, found) else None
        return None


def locate_devices(world: World, name: str, seed: int) -> Iterator[Answer]:
    """Locate devices of a scene; compare all their openings."""
    mistake = MISTAKES[seed % len(MISTAKES)]
    scene = DeviceScene(world, BOARDS[name], seed, mistake)
    for device in scene.devices:
        group = mistake if mistake and device is scene.devices[0] else name
        openings = np.array([terminal.mouth for terminal in device.terminals])
        yield compared(group, scene.poses[device.id], scene.locate(device), openings)


def device_row(name: str, answers: list[Answer]) -> dict[str, str]:
    """Return a row of the table of devices; nothing about a mistake is where it was drawn."""
    good = [a for a in answers if a.is_located]
    wrong = [a for a in good if a.is_off(*WITHIN) or name not in BOARDS]
    position, angle = errors(good, (0.5, 0.9, 1.0))
    share = 100 * (len(good) - len(wrong)) / len(answers)
    is_board = name in BOARDS
    return {
        "devices": name,
        "seen": str(len(answers)),
        "within 0.5 mm and 0.5 deg (95 %)": f"{share:.1f} %" if is_board else "",
        "position, median / p90 / max": f"{position} mm" if is_board else "",
        "angle, median / p90 / max": f"{angle} deg" if is_board else "",
        "wrong (target)": f"{len(wrong)} (0)",
    }


# By kind: the names of conditions or boards, what yields the answers of a scene and returns a row
# of the table, and by default the scenes of each name and the first seed.
KINDS = {
    "labels": (CONDITIONS, locate_labels, label_row, 6, 8200),
    "devices": (BOARDS, locate_devices, device_row, 24, 6000),
}


def run(task: tuple[str, str, int]) -> list[Answer]:
    """Locate the components of a scene: kind, name, seed."""
    kind, name, seed = task
    cv2.setNumThreads(1)
    world = World(240.0)
    try:
        return list(KINDS[kind][1](world, name, seed))
    finally:
        world.close()


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("--scenes", type=int, help="of each condition or board")
    parser.add_argument("--seed", type=int, help="of the first scene")
    parser.add_argument("--processes", type=int, default=2)
    add_figures_option(parser)
    options = parser.parse_args()
    names, _, row, scenes, seed = KINDS[options.kind]
    first = seed if options.seed is None else options.seed
    seeds = range(first, first + (options.scenes or scenes))
    tasks = [(options.kind, name, seed) for name in names for seed in seeds]
    groups: dict[str, list[Answer]] = defaultdict(list)
    with multiprocessing.get_context("spawn").Pool(options.processes) as pool:
        for answer in chain.from_iterable(pool.imap(run, tasks)):
            groups[answer.group].append(answer)
    order = [*names, *(name for name in MISTAKES if name)]
    report_table([row(name, groups[name]) for name in order if groups[name]], options.figures)


if __name__ == "__main__":
    main()
