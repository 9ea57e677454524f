#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Measure how often the abilities succeed, or refuse rightly, over seeds, and how long it takes.

evaluate_abilities.py [FILE] [--seeds 0-99] [--trials NAME ...] [--panel PANEL] [--formboard PANEL]
[--connectors PANEL] [--rate HZ] [--jobs N]; the workspace must be sourced. A seed gives a wire its
curvature and the cameras their noise; wires of the panel take turns; the trial "route" has the
formboard instead, those named "connector" have that of the connectors. Every push and pull of a
trial is recorded, and compared with its force limit. Each trial that goes wrong is printed with its
seed and code as it ends, and `--seeds SEED --trials NAME` runs it again with the same outcome. FILE
(out/bench/abilities.jsonl) gets a line of JSON for each trial, then for each figure. Exits with 1
when a target is missed.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path

import numpy as np

# The record of forces is that of the unit tests.
sys.path.insert(0, str(Path(__file__).parents[2] / "src" / "remodel_sim" / "test" / "unit"))

from row import Row, head, report
from trials import TRIALS, Outcome, Trial, run

from remodel_states.edge.exported_tables import read_wire_materials
from remodel_work.ros.panel_message import read_panel

CONFIG = Path(__file__).parents[2] / "src" / "remodel_sim" / "config"
# Share of good outcomes in percent, by trial: its description and target.
SHARES = {
    "wire": ("whole wires placed", None),
    "pick": ("pick", 98.0),
    "offset": ("6 mm beside the opening: INSERTION_MISALIGNED", 98.0),
    "blocked": ("blocked socket: INSERTION_JAMMED", 98.0),
    "push": ("pushed with 4 to 25 N: seated", 98.0),
    "push_blocked": ("blocked, pushed with 4 to 25 N: INSERTION_JAMMED", 98.0),
    "other_component": ("wrong socket, of another component: INVALID_GOAL", 98.0),
    "neighbour": ("wrong socket, the one beside it: INVALID_GOAL", 98.0),
    "occupied": ("wrong socket, occupied: TERMINAL_OCCUPIED", 98.0),
    "connector": ("connector latched, first attempt", 95.0),
    "connector_offset": ("connector 6 mm aside: INSERTION_MISALIGNED", 98.0),
    "connector_blocked": ("connector, one opening blocked: INSERTION_JAMMED", 98.0),
    "route": ("six clips, the whole wire in them after release", 95.0),
    "discard": ("wires discarded, placed or half placed", 98.0),
    "connections": ("trials of CheckConnection without a wrong answer", None),
    "locate": ("located", None),
    "locate_moved": ("located, moved by up to 10 mm and 8 deg", None),
    "locate_light": ("located, 40 to 160 % of the light", None),
}
# Targets of the errors of locating: median, 90 % quantile.
ERRORS = {"position [mm]": (0.5, 1.0), "angle [deg]": (0.5, 1.0)}
WALL_S = 10.0

Outcomes = Mapping[str, Sequence[Outcome]]


def parse_seeds(text: str) -> list[int]:
    """Return the seeds of a text such as "0-99" or "3,7,20-29"."""
    seeds: list[int] = []
    for part in text.split(","):
        first, dash, last = part.partition("-")
        try:
            found = range(int(first), int(last if dash else first) + 1)
        except ValueError:
            found = range(0)
        if not found:
            raise argparse.ArgumentTypeError(f"{part!r} are no seeds; allowed: 3 or 0-99 or 3,7-9")
        seeds += found
    return seeds


def run_all(trials: Sequence[Trial], jobs: int, file: Path) -> dict[str, list[Outcome]]:
    """Run trials in processes of their own; print the bad ones, add a line of each to the file."""
    outcomes: dict[str, list[Outcome]] = {}
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=spawn) as pool, file.open("w") as lines:
        for trial, outcome in zip(trials, pool.map(run, trials), strict=True):
            outcomes.setdefault(trial.name, []).append(outcome)
            if not outcome.good:
                print(f"{trial.name}, seed {trial.seed}: {outcome.found}", flush=True)
            line = {"trial": trial.name, "seed": trial.seed, **asdict(outcome)}
            lines.write(json.dumps(line) + "\n")
            lines.flush()
    return outcomes


def rows(outcomes: Outcomes) -> Iterator[Row]:
    """Yield the figures of the trials that were run."""
    for name, done in outcomes.items():
        what, least = SHARES[name]
        yield _share(what, [outcome.good for outcome in done], least)
        if name == "wire":
            yield from _wire_rows(done)
        if name == "connections":
            yield from _connection_rows(done)
    yield from _force_rows([o for done in outcomes.values() for o in done])
    located = [o for name, done in outcomes.items() if name.startswith("locate") for o in done]
    for figure, (median, p90) in ERRORS.items():
        errors = [o.figures[figure] for o in located if figure in o.figures]
        if errors:
            what, unit = figure.rstrip("]").split(" [")
            yield Row(f"locate: {what}, median", float(np.median(errors)), unit, most=median)
            yield Row(f"locate: {what}, p90", float(np.quantile(errors, 0.9)), unit, most=p90)


def _wire_rows(done: Sequence[Outcome]) -> Iterator[Row]:
    """Yield the figures of insertions, of ends that were tried, and of time."""
    placed, first = [], []
    for outcome in done:
        for end in ("a", "b"):
            if f"attempts at {end}" in outcome.figures:
                good = bool(outcome.figures[f"placed {end}"])
                placed.append(good)
                first.append(good and outcome.figures[f"attempts at {end}"] == 1)
    if placed:
        yield _share("insertion, at the first attempt", first, 95.0)
        yield _share("insertion, with at most 3 attempts", placed, 99.0)
    times = [(o.figures["wall [s]"], o.figures["cpu [s]"]) for o in done if o.good]
    if times:
        wall, cpu = (float(median) for median in np.median(times, axis=0))
        yield Row("a whole wire, wall time, median", wall, "s", most=WALL_S)
        yield Row("a whole wire, wall time, slowest", max(times)[0], "s")
        yield Row("a whole wire, CPU time, median", cpu, "s")


def _connection_rows(done: Sequence[Outcome]) -> Iterator[Row]:
    """Yield the shares of right answers, and of refusals to answer."""
    asked, wrong, refused = (
        int(sum(outcome.figures[name] for outcome in done))
        for name in ("asked", "wrong", "refused")
    )
    right = asked - wrong - refused
    what = f"CheckConnection: right answers ({right} of {asked}, {wrong} wrong)"
    yield Row(what, 100 * right / asked, "%", 99.0)
    yield Row(f"CheckConnection: refused ({refused} of {asked})", 100 * refused / asked, "%")


def _force_rows(done: Sequence[Outcome]) -> Iterator[Row]:
    """Yield how many pushes and pulls kept to their force limit, in truth and as reported."""
    pushes = np.array([push for outcome in done for push in outcome.pushes])
    if not pushes.size:
        return
    limits, peaks, reported, allowed = pushes.T
    yield _share("forces at the wrist within 1.15 limits + 0.5 N", list(peaks <= allowed), 99.0)
    known = reported[reported > 0] <= allowed[reported > 0]
    yield _share("the same, as the abilities report them", list(known), 99.0)
    yield Row("largest force at the wrist over its limit", float(np.max(peaks / limits)), "")


def _share(what: str, good: Sequence[bool], least: float | None) -> Row:
    return Row(f"{what} ({sum(good)} of {len(good)})", 100 * sum(good) / len(good), "%", least)


def main() -> int:
    """Run the trials and print the table; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", nargs="?", type=Path, default=Path("out/bench/abilities.jsonl"))
    parser.add_argument("--seeds", type=parse_seeds, default="0-3", help="such as 0-99 or 3,7-9")
    parser.add_argument("--trials", nargs="+", choices=TRIALS, default=list(TRIALS), metavar="NAME")
    parser.add_argument("--panel", type=Path, default=CONFIG / "panel.yaml")
    parser.add_argument("--formboard", type=Path, default=CONFIG / "formboard.yaml")
    parser.add_argument("--connectors", type=Path, default=CONFIG / "connectors.yaml")
    parser.add_argument("--rate", type=float, default=240.0, help="of the physics [Hz]")
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    options = parser.parse_args()
    options.file.parent.mkdir(parents=True, exist_ok=True)
    materials = read_wire_materials()
    panel = read_panel(options.panel, materials)
    panels = {name: panel for name in options.trials}
    for name in options.trials:
        if name == "route":
            panels[name] = read_panel(options.formboard, materials)
        elif name.startswith("connector_") or name == "connector":
            panels[name] = read_panel(options.connectors, materials)
    trials = [
        Trial(name, seed, panels[name], options.rate)
        for name in options.trials
        for seed in options.seeds
    ]
    outcomes = run_all(trials, options.jobs, options.file)
    print(head())
    return 0 if report(rows(outcomes), options.file) else 1


if __name__ == "__main__":
    sys.exit(main())
