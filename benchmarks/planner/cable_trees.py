#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Order the public Cable Tree Wiring instances, and compare with the best known costs.

Takes a folder of .dzn files with a `reference.csv` (columns instance, best_cost); an instance
without a best cost is expected to have no order.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Callable
from pathlib import Path

from remodel_cable_tree.cable_tree_planner import Feasibility, sequence
from remodel_cable_tree.problem import cost_of, parse_cable_tree, violations


def main() -> None:
    """Run all instances and print what differs, then the count."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--time-limit", type=float, default=10.0, metavar="S")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--whole",
        action="store_true",
        help="do all the work of the time limit, however long it takes: as on an idle machine",
    )
    options = parser.parse_args()
    clock = (lambda: 0.0) if options.whole else time.monotonic
    counts = {"equalled": 0, "better": 0, "worse": 0, "proved unsatisfiable": 0, "wrong": 0}
    with (options.folder / "reference.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    started = time.monotonic()
    for row in rows:
        counts[_run(options.folder, row, options.time_limit, options.seed, clock=clock)] += 1
    good = len(rows) - counts["worse"] - counts["wrong"]
    print(", ".join(f"{count} {what}" for what, count in counts.items()))
    print(
        f"{good} of {len(rows)} = {100 * good / len(rows):.1f} % (target 95 %), "
        f"{time.monotonic() - started:.0f} s"
    )


def _run(
    folder: Path, row: dict[str, str], limit_s: float, seed: int, clock: Callable[[], float]
) -> str:
    name = row["instance"]
    tree = parse_cable_tree((folder / f"{name}.dzn").read_text(encoding="utf-8"))
    started = time.monotonic()
    found = sequence(tree, limit_s, seed, clock=clock)
    took = time.monotonic() - started
    if found.feasibility is not Feasibility.FOUND:
        return "wrong" if row["best_cost"] else "proved unsatisfiable"
    if not row["best_cost"] or any(violations(tree, found.order)):
        return "wrong"
    cost, best = cost_of(tree, found.order), int(row["best_cost"])
    if cost.total == best:
        return "equalled"
    verdict = "better" if cost.total < best else "worse"
    print(f"{name}: {verdict}: {cost.total} against {best} after {took:.1f} s; {cost}", flush=True)
    return verdict


if __name__ == "__main__":
    main()
