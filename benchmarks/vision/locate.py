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
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from label_scenes import Condition, LabelScene
from row import Row, report

from remodel_sim.physics.world import World
from remodel_skills.edge.parameter_files import read_parameters
from remodel_states.edge.wire_material_file import read_wire_materials
from remodel_vision.label_pose import LabelView, locate_component
from remodel_vision.labels import find_labels, search_label
from remodel_work.camera import Picture
from remodel_work.geometry import Array, Pose
from remodel_work.panel import BOARD, Component
from remodel_work.ros.panel_message import read_panel

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
