#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Map what InsertCable does by error of its goal: insertion_map.py [FILE] makes insertion-map.png.

The goal's opening lies off to the side and is turned about the vertical, as after a bad
observation; nothing is corrected. Each point is one insertion of end a in a cell of its own; the
truth shows whether it is seated, also where it was refused (a point with a dot). A line of JSON for
each goes to out/bench/insertion-map.jsonl.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, dataclass
from pathlib import Path

import cv2
import numpy as np
from plots import BLACK, MARGIN, RED, WIDTH, Axes, axes
from wire_task import ROBOT

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth
from remodel_skills.abilities.inserting import InsertGoal, insert_cable
from remodel_skills.cell import Cell
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import Panel, WireEnd
from remodel_work.ros.panel_message import read_panel

PANEL = Path(__file__).parents[2] / "src" / "remodel_sim" / "config" / "panel.yaml"
LINES = Path("out/bench/insertion-map.jsonl")
OFFSETS_MM = (0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
ANGLES_DEG = (0.0, 5.0, 10.0, 15.0, 20.0)
FORCE_LIMIT_N = 8.0
SEED = 1
GREEN, ORANGE, GREY = (60, 150, 60), (20, 140, 240), (150, 150, 150)
SEATED = "seated"
COLOURS = {
    SEATED: GREEN,
    "INSERTION_MISALIGNED": ORANGE,
    "INSERTION_JAMMED": RED,
    "INSERTION_NO_CONTACT": GREY,
}


@dataclass(frozen=True)
class Point:
    """One insertion.

    Attributes:
        offset_mm: of the opening in the goal, along its y.
        angle_deg: by which it was turned.
        found: the error code, "seated", or "silently wrong".
        at_bottom: whether the end is seated by the truth.
    """

    offset_mm: float
    angle_deg: float
    found: str
    at_bottom: bool


def measure(panel: Panel, offset_mm: float, angle_deg: float) -> Point:
    """Insert end a of the panel's first wire with an error."""
    wire = panel.wires[0]
    terminal = wire.goes_to(WireEnd.A)
    cell = Cell(SimulatedPlant(panel, seed=SEED))
    opening = panel.panel_from_socket(*terminal).position
    cell.feed(wire.id, panel.channel_in_front_of(opening).id)
    error = Pose.level(0.0, offset_mm / 1e3, 0.0, np.radians(angle_deg))
    given = cell.plant.world_from_socket(*terminal) @ error
    goal = InsertGoal(ROBOT, wire.id, WireEnd.A, *terminal, given, FORCE_LIMIT_N)
    found = SEATED
    try:
        cell.run(insert_cable(cell.context, goal))
    except AbilityError as failure:
        found = failure.code.name
    (truth,) = ground_truth(cell.plant, [wire.id])
    cell.close()
    if found == SEATED and not truth.a.seated:
        found = "silently wrong"
    return Point(offset_mm, angle_deg, found, truth.a.seated)


def draw(points: list[Point]) -> np.ndarray:
    """Return the map."""
    plot = axes(
        "InsertCable by error of its goal, 3.0 mm wire, 3.8 mm opening, 1.5 mm chamfer",
        ("beside the axis [mm]", "turned [deg]"),
        OFFSETS_MM,
        ANGLES_DEG,
        legend=False,
    )
    for point in points:
        place = plot.pixel(point.offset_mm, point.angle_deg)
        cv2.circle(plot.picture, place, 11, COLOURS.get(point.found, BLACK), -1, cv2.LINE_AA)
        if point.at_bottom and point.found != SEATED:
            cv2.circle(plot.picture, place, 5, COLOURS[SEATED], -1, cv2.LINE_AA)
    _legend(plot, sorted({point.found for point in points}))
    plot.text("dot: seated all the same", (WIDTH - 270, 60), COLOURS[SEATED])
    return plot.picture


def _legend(plot: Axes, names: list[str]) -> None:
    for i, name in enumerate(names):
        text = "refused: " + name.lower().replace("_", " ") if name.isupper() else name
        plot.text(text, (MARGIN + 90 + 290 * i, 60), COLOURS.get(name, BLACK))


def main() -> None:
    """Measure, draw, and print the counts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", nargs="?", type=Path, default=Path("out/bench/insertion-map.png"))
    file = parser.parse_args().file
    for each in (file, LINES):
        each.parent.mkdir(parents=True, exist_ok=True)
    panel = read_panel(PANEL, read_wire_materials())
    points = []
    with LINES.open("w") as lines:
        for angle in ANGLES_DEG:
            for offset in OFFSETS_MM:
                points.append(measure(panel, offset, angle))
                lines.write(json.dumps(asdict(points[-1])) + "\n")
                lines.flush()
    cv2.imwrite(str(file), draw(points))
    for name in sorted({point.found for point in points}):
        print(f"{name}: {sum(point.found == name for point in points)} of {len(points)}")


if __name__ == "__main__":
    main()
