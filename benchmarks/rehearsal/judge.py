#!/usr/bin/env python3
"""How good the forecasts of rehearsals are on seeds that they have not seen, and what they avoid.

judge.py [DESIGN ...] [--wires 6] [--seeds 100-107] [--held-out 200-207] [--workers 2]
[--states DIR] [--figures FILE]; the workspace must be sourced.

Wires of each design are rehearsed with both sets of seeds. The first set forecasts each wire; the
second is what happens. Brier's score of the forecasts is compared with those of the constant
predictor, which says of every wire the mean of the first set, and of what the use case expects
without a rehearsal. What helped with the first set is adopted as `remodel rehearse --adopt` does,
and the second set is run again with it: first attempts that failed before and after, and how many
less for each CPU hour of the rehearsal. Also printed: the share of a trial's CPU time that is not
physics, vision and skills, and CPU time of all trials over workers times wall time, if nothing was
computed before; and how much faster 100 workers are than one, by simulation of the scheduler.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from heapq import heappop, heappush
from math import prod
from pathlib import Path
from statistics import fmean

from distributed import Client

from remodel_planner.commands.options.common import seeds
from remodel_production.core.imports.formats import format_of, import_design
from remodel_production.core.production import Order
from remodel_production.edge.design_files import (
    catalogue_file,
    design_formats,
    read_catalogue,
    read_mappings,
)
from remodel_rehearsal.core.forecast import (
    adopted,
    brier_score,
    changes_within,
    forecast,
    to_check,
    with_changes,
)
from remodel_rehearsal.edge.cluster import Job, Rehearsing, connected
from remodel_rehearsal.edge.rehearsal_files import (
    KeptTrial,
    hash_of_sources,
    mark_of,
    read_uncertainty,
)
from remodel_rehearsal.stack import Setting, use_case_of
from remodel_tasks.core.use_case.model import UseCase

MANY = 100  # workers of a simulated cluster
HOUSEHOLD = Path("/usr/share/qelectrotech/examples/tableau_domestique.qet")


def order_of(file: Path) -> Order:
    """Return the order of a design."""
    data, catalogue = file.read_bytes(), read_catalogue(catalogue_file())
    form = format_of(data, design_formats(read_mappings(None)))
    return import_design(data, form, file.stem, file.name, catalogue).order.in_cabinet()


def rehearsing_of(
    setting: Setting, options: argparse.Namespace, of_seeds: tuple[int, ...], client: Client
) -> Rehearsing:
    """Return the rehearsal of a setting with these seeds."""
    table = read_uncertainty()
    job = Job(setting, table, options.states, mark_of(setting, table, hash_of_sources()))
    return Rehearsing(job, of_seeds, client, _tell)


def _tell(kept: KeptTrial, count: int, of: int) -> None:
    trial = kept.trial
    code = trial.failures[0].code if trial.failures else "placed at once"
    print(f"{count}/{of}: {trial.wire}, seed {trial.seed}: {code}", flush=True)


def stated(use_case: UseCase, trials: list[KeptTrial]) -> float:
    """Return how often a use case expects a wire's first attempt to succeed.

    Args:
        use_case: with an expectation of each ability.
        trials: of the wire; the one with the fewest calls shows which are needed.
    """
    calls = min((kept.calls for kept in trials), key=len)
    return prod(use_case.expectations.expect(c.ability, c.features).success for c in calls)


def scheduled_s(durations_s: Sequence[Sequence[float]], workers: int) -> float:
    """Return the wall time [s] of a rehearsal on so many workers, by simulation of its scheduler.

    As in Rehearsing: the trials of a wire, and the run that lays the board of the next one, may
    begin when the board before the wire is laid; such runs come first.

    Args:
        durations_s: of the trials, by wire in their order; a board takes as long as their mean.
        workers: each does one thing at a time.
    """
    ready: list[tuple[int, int, float]] = []  # rank, wire, duration: 0 lays its board, 1 is a trial
    running: list[tuple[float, int, int]] = []  # end, rank, wire
    now_s = 0.0

    def begin(wire: int) -> None:
        if wire + 1 < len(durations_s):
            heappush(ready, (0, wire, fmean(durations_s[wire])))
        for duration in durations_s[wire]:
            heappush(ready, (1, wire, duration))

    begin(0)
    while ready or running:
        while ready and len(running) < workers:
            rank, wire, duration = heappop(ready)
            heappush(running, (now_s + duration, rank, wire))
        now_s, rank, wire = heappop(running)
        if rank == 0:
            begin(wire + 1)
    return now_s


def rows(file: Path, options: argparse.Namespace) -> list[tuple[str, float, str]]:
    """Return the figures of a design: what, value, unit."""
    setting = Setting(order_of(file), wires=options.wires)
    use_case = use_case_of(setting)
    with connected("", options.workers) as client:
        began_s = time.monotonic()
        rehearsing = rehearsing_of(setting, options, options.seeds, client)
        known = rehearsing.trials()
        later = rehearsing_of(setting, options, options.held_out, client).trials()
        wall_s = time.monotonic() - began_s
        found = forecast(rehearsing.first, [kept.trial for kept in known])
        pushes = use_case.learned.get("InsertCable", {})
        changes = {w: changes_within(pushes, rehearsing.first[w]) for w in to_check(found)}
        tried = rehearsing.changed(changes)
        found = with_changes(
            found, {(w, c.text): [kept.trial for kept in of] for (w, c), of in tried.items()}
        )
        document = adopted(found, changes, None)
        changed = replace(setting, preferences=document)
        after = (
            rehearsing_of(changed, options, options.held_out, client).trials()
            if document is not None
            else later
        )
    happened = [(kept.trial.wire, kept.trial.at_once) for kept in later]
    mean = fmean(kept.trial.at_once for kept in known)
    without = {
        w: stated(use_case, [k for k in known if k.trial.wire == w]) for w in rehearsing.first
    }
    own = brier_score({wire.wire: wire.at_once.mean for wire in found.wires}, happened)
    constant = brier_score(dict.fromkeys(rehearsing.first, mean), happened)
    trials = [*known, *later]
    cpu_s = sum(kept.cpu_s for kept in trials)
    rehearsal_s = sum(k.cpu_s for k in (*known, *(k for of in tried.values() for k in of)))
    durations_s = [
        [kept.cpu_s for kept in trials if kept.trial.wire == wire] for wire in rehearsing.first
    ]
    alone_s, many_s = (scheduled_s(durations_s, workers) for workers in (1, MANY))
    failed, fails = (sum(not kept.trial.at_once for kept in each) for each in (later, after))
    return [
        ("trials", len(trials), ""),
        ("wires placed at the first attempt", 100 * fmean(s for _, s in happened), "%"),
        ("Brier score of the forecast", own, ""),
        ("Brier score of the constant predictor", constant, ""),
        ("Brier score of the use case's expectations", brier_score(without, happened), ""),
        ("better than the constant predictor", 100 * (1 - own / constant) if constant else 0, "%"),
        ("first attempts that failed", failed, ""),
        ("first attempts that failed with what was adopted", fails, ""),
        ("failures avoided per CPU hour", 3600 * (failed - fails) / rehearsal_s, "/h"),
        (
            "overhead beside physics, vision and skills",
            100 * (cpu_s / sum(kept.physics_s for kept in trials) - 1),
            "%",
        ),
        ("CPU time of a trial", cpu_s / len(trials), "s"),
        (f"efficiency of {options.workers} workers", cpu_s / wall_s / options.workers, ""),
        (f"times faster on {MANY} workers, simulated", alone_s / many_s, ""),
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
