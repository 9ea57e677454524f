#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Measure how well the cell's own wires are found from above, against the physics.

A wire of each colour is fed to the example panel with each seed, and found as DetectCable finds it.
Prints a line for each wire, and writes the table of docs/vision.md to a file that is named.

Usage: wires.py [--seeds FIRST-LAST] [--colours CODE,CODE] [--processes N] [FILE]
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np

from remodel_sim.physics.plant import SimulatedPlant
from remodel_skills.cell import Cell
from remodel_states.core.wires import DISTINCT_COLOURS
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_vision.wire_ends import find_ends, line_between
from remodel_work.geometry import Array
from remodel_work.panel import WireEnd
from remodel_work.ros.panel_message import read_panel

PANEL = Path(__file__).parents[2] / "src" / "remodel_sim" / "config" / "panel.yaml"
# Of a wire is seen what lies this near to its line [mm].
SEEN_MM = 3.0
# Points of wires are so far apart [m].
STEP_M = 0.001


@dataclass(frozen=True)
class Answer:
    """What was found of a wire.

    Attributes:
        colour: of the wire.
        seed: of the cell.
        turned: ends that were found the wrong way round.
        tips: errors of the tips that were found [mm].
        off: the largest distance of the line from the wire [mm]; infinite without a line from tip
            to tip.
        missed: of the wire, by its line [mm].
    """

    colour: str
    seed: int
    turned: int
    tips: tuple[float, ...]
    off: float = math.inf
    missed: float = math.inf


def run(task: tuple[str, int]) -> Answer:
    """Feed a wire and find it."""
    colour, seed = task
    cv2.setNumThreads(1)
    panel = read_panel(PANEL, read_wire_materials())
    of_panel = panel.wires[seed % len(panel.wires)]
    wire = replace(of_panel, colour=colour)
    cell = Cell(SimulatedPlant(replace(panel, wires=(wire,)), seed=seed))
    try:
        opening = panel.panel_from_socket(*wire.goes_to(WireEnd.A)).position
        cell.feed(wire.id, panel.channel_in_front_of(opening).id)
        picture = cell.plant.take_overhead_picture()
        ends, lines = find_ends(picture, wire, cell.context.belief.expected)
        assert cell.plant.live is not None, "it was fed"
        cable = cell.plant.live.cable
        true = {end: cable.tip(end) for end in ends}
        turned = sum(
            math.cos(seen.tip.out_yaw) * true[end][1][0]
            + math.sin(seen.tip.out_yaw) * true[end][1][1]
            < 0
            for end, seen in ends.items()
        )
        tips = tuple(
            1e3 * float(np.linalg.norm((seen.tip.tip - true[end][0])[:2]))
            for end, seen in ends.items()
        )
        whole = line_between((ends[WireEnd.A], ends[WireEnd.B]), lines) if len(ends) == 2 else None
        if whole is None:
            return Answer(colour, seed, turned, tips)
        line = _dense(picture.view.on_plane(whole, wire.radius)[:, :2])
        nodes = _dense(cable.nodes()[:, :2])
        away = 1e3 * np.linalg.norm(line[:, None] - nodes[None], axis=2)
        missed = 1e3 * STEP_M * float(np.count_nonzero(away.min(axis=0) > SEEN_MM))
        return Answer(colour, seed, turned, tips, float(away.min(axis=1).max()), missed)
    finally:
        cell.close()


def _dense(line: Array) -> Array:
    """Return a polyline (n, 2) [m] with a point every millimetre."""
    pieces = [
        np.linspace(a, b, max(2, math.ceil(float(np.linalg.norm(b - a)) / STEP_M)), endpoint=False)
        for a, b in pairwise(line)
    ]
    return np.concatenate([*pieces, line[-1:]])


def table_row(name: str, answers: list[Answer]) -> dict[str, str]:
    """Return a row of the docs' table."""
    whole = [a for a in answers if math.isfinite(a.off)]
    tips = [tip for a in answers for tip in a.tips]
    off = [a.off for a in whole] or [math.nan]
    return {
        "wires": name,
        "seen": str(len(answers)),
        "ends found": f"{len(tips)} of {2 * len(answers)}",
        "the wrong way round": str(sum(a.turned for a in answers)),
        "tip error, median / max": f"{np.median(tips):.1f} / {max(tips):.1f} mm",
        "followed from tip to tip": str(len(whole)),
        "line off the wire, median / max": f"{np.median(off):.1f} / {max(off):.1f} mm",
        "wire missed, max": f"{max([a.missed for a in whole] or [math.nan]):.0f} mm",
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path, nargs="?", help="of the table, such as wires.jsonl")
    parser.add_argument("--seeds", default="20-23", help="of the cells, FIRST-LAST")
    parser.add_argument("--colours", help="codes of IEC 60757; without, all")
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    first, _, last = options.seeds.partition("-")
    colours = options.colours.split(",") if options.colours else list(DISTINCT_COLOURS)
    tasks = [(c, s) for c in colours for s in range(int(first), int(last or first) + 1)]
    with multiprocessing.get_context("spawn").Pool(options.processes) as pool:
        answers = pool.map(run, tasks, chunksize=1)
    for a in answers:
        tips = ", ".join(f"{tip:.2f}" for tip in a.tips)
        print(f"{a.colour:<5}seed {a.seed}: tips off {tips} mm, turned {a.turned}; ", end="")
        print(f"line off {a.off:.2f} mm, missed {a.missed:.0f} mm")
    light = [a for a in answers if a.colour in ("WH", "GY")]
    rows = [
        table_row("all colours", answers),
        *([table_row("white, grey", light)] if light else []),
    ]
    for row in rows:
        print(json.dumps(row))
    if options.file is not None:
        options.file.write_text("".join(f"{json.dumps(row)}\n" for row in rows), encoding="utf-8")


if __name__ == "__main__":
    main()
