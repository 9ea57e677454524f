#!/usr/bin/env python3
"""How good the forecasts of rehearsals are, on seeds that they have not seen.

judge.py [DESIGN ...] [--wires 6] [--seeds 100-107] [--held-out 200-207] [--workers 2]
[--states DIR] [--figures FILE]; the workspace must be sourced.

Wires of each design are rehearsed with both sets of seeds. The first set forecasts each wire; the
second is what happens. Brier's score of these forecasts is compared with that of the constant
predictor, which says of every wire the mean of the first set. Also printed: the share of a trial's
CPU time that is not physics, vision and skills, and CPU time of all trials over workers times wall
time, if nothing was computed before.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from pathlib import Path
from statistics import fmean

from remodel_planner.commands.options.common import seeds
from remodel_production.core.imports.formats import format_of, import_design
from remodel_production.core.production import Order
from remodel_production.edge.design_files import (
    catalogue_file,
    design_formats,
    read_catalogue,
    read_mappings,
)
from remodel_rehearsal.core.forecast import brier_score, forecast
from remodel_rehearsal.edge.cluster import Job, Rehearsing, connected
from remodel_rehearsal.edge.trial_store import KeptTrial, hash_of_sources, mark_of
from remodel_rehearsal.edge.uncertainty_file import read_uncertainty
from remodel_rehearsal.stack import Setting

HOUSEHOLD = Path("/usr/share/qelectrotech/examples/tableau_domestique.qet")


def order_of(file: Path) -> Order:
    """Return the order of a design."""
    data, catalogue = file.read_bytes(), read_catalogue(catalogue_file())
    form = format_of(data, design_formats(read_mappings(None)))
    return import_design(data, form, file.stem, file.name, catalogue).order.in_cabinet()


def rehearsed(
    file: Path, options: argparse.Namespace, of_seeds: tuple[int, ...]
) -> tuple[tuple[str, ...], list[KeptTrial], float]:
    """Return the wires of a design, their trials, and the wall time they took [s]."""
    setting, table = Setting(order_of(file), wires=options.wires), read_uncertainty()
    job = Job(setting, table, options.states, mark_of(setting, table, hash_of_sources()))
    with connected("", options.workers) as client:
        rehearsing = Rehearsing(job, of_seeds, client, _tell)
        began_s = time.monotonic()
        return rehearsing.names, rehearsing.trials(), time.monotonic() - began_s


def _tell(kept: KeptTrial, count: int, of: int) -> None:
    trial = kept.trial
    code = trial.failures[0].code if trial.failures else "placed at once"
    print(f"{count}/{of}: {trial.wire}, seed {trial.seed}: {code}", flush=True)


def rows(file: Path, options: argparse.Namespace) -> list[tuple[str, float, str]]:
    """Return the figures of a design: what, value, unit."""
    names, known, wall_s = rehearsed(file, options, options.seeds)
    _, later, more_s = rehearsed(file, options, options.held_out)
    found = forecast(names, [kept.trial for kept in known])
    happened = [(kept.trial.wire, kept.trial.at_once) for kept in later]
    own = brier_score({wire.wire: wire.at_once.mean for wire in found.wires}, happened)
    mean = fmean(kept.trial.at_once for kept in known)
    constant = brier_score(dict.fromkeys(names, mean), happened)
    trials = [*known, *later]
    cpu_s = sum(kept.cpu_s for kept in trials)
    overhead = cpu_s / sum(kept.physics_s for kept in trials) - 1
    return [
        ("trials", len(trials), ""),
        ("wires placed at the first attempt", 100 * fmean(s for _, s in happened), "%"),
        ("Brier score of the forecast", own, ""),
        ("Brier score of the constant predictor", constant, ""),
        ("better than the constant predictor", 100 * (1 - own / constant) if constant else 0, "%"),
        ("overhead beside physics, vision and skills", 100 * overhead, "%"),
        ("CPU time of a trial", cpu_s / len(trials), "s"),
        (
            f"efficiency of {options.workers} workers",
            cpu_s / (wall_s + more_s) / options.workers,
            "",
        ),
    ]


def main() -> int:
    """Print the figures of each design."""
    parser = argparse.ArgumentParser(description="How good the forecasts of rehearsals are.")
    parser.add_argument("designs", nargs="*", type=Path, metavar="DESIGN", default=[HOUSEHOLD])
    parser.add_argument("--wires", type=int, default=6, help="of each design, from the first")
    parser.add_argument("--seeds", type=seeds, default=seeds("100-107"), help="of the forecast")
    parser.add_argument("--held-out", type=seeds, default=seeds("200-207"), help="what happens")
    parser.add_argument("--workers", type=int, default=len(os.sched_getaffinity(0)))
    parser.add_argument("--states", default=str(Path("out/bench/rehearsal").absolute()))
    parser.add_argument("--figures", type=Path, help="file to which the rows are written")
    options = parser.parse_args()
    lines = []
    for file in options.designs:
        for what, value, unit in rows(file, options):
            print(f"{file.stem}: {what}: {value:.3g} {unit}".rstrip(), flush=True)
            lines.append({"design": file.stem, "figure": what, "value": value, "unit": unit})
    if options.figures is not None:
        options.figures.write_text("".join(f"{json.dumps(line)}\n" for line in lines))
    return 0


if __name__ == "__main__":
    sys.exit(main())
