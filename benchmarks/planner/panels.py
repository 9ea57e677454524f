#!/usr/bin/env python3
"""Measure the planner on random panels: times, costs above the best known, memory.

panels.py [--sizes N ...] [--peers PYTHON] [--whole] [--figures FILE]; the workspace must be
sourced. Prints medians over three seeds, targets in brackets; of a time, each seed's least of some
repetitions, counted from the loaded problem. Every plan is checked. With --peers GTPyhop plans the
one-arm panels too, and Fast Downward, which knows nothing of ours, the smallest ones to optimality:
exits with 1 if a cost differs. With --whole, searches do all the work of their time also on a
machine under load.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import argparse
import itertools
import json
import math
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from remodel_pddl import hddl, pddl
from remodel_pddl.symbolic import steps_of, symbols_of
from remodel_tasks.core.plan.checker import check
from remodel_tasks.core.problem.instance import problem_from
from remodel_tasks.core.problem.problem import ActionKind, End, Mode
from remodel_tasks.core.search import Planned, Tables, tables_of
from remodel_tasks.edge.anytime_planner import AnytimePlanner, Limits, plan_problem
from remodel_tasks.edge.search_kernel import Kernel

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_tasks/test"))
from failures import after_jam, after_move, remaining_order
from figures import add_figures_option, report_table
from random_panel import random_panel

SIZES = (10, 30, 100, 300, 1000)
SEEDS = (1, 2, 3)
PATCHED = {
    "patched after jam [ms]": (0.1, 0.1, 0.5, 1, 5),
    "patched after move [ms]": (0.1, 0.1, 0.5, 1, 5),
}
# By arms: name of the row, targets for each size.
TARGETS = {
    1: {
        "first plan [ms]": (0.6, 0.8, 2, 15, 100),
        "first plan above best [%]": (2, 1.2, 1.2, 1.2, 1.1),
        **PATCHED,
        "after 1 s above best [%]": (0, 0, 0.06, 0.18, 0.28),
        "after 10 s above best [%]": (0, 0, 0.04, 0.1, 0.08),
    },
    2: {
        "first plan [ms]": (0.3, 1, 4, 100, 400),
        "first plan above best [%]": (13, 13, 13, 13, 13),
        **PATCHED,
        "after 10 s above best [%]": (0, 1, 1.5, 4, 4.5),
    },
}
REPETITIONS = 7
# Of panels that Fast Downward solves: wires, seeds, and the time of our search [s].
OPTIMAL_WIRES, OPTIMAL_SEEDS, PLANNING_S = 10, (1, 2, 3, 4, 5), 1.0
# Best known costs of random panels, by arms and wires, for the seeds: from annealing runs of up to
# eight minutes in compiled code.
BEST_KNOWN = {
    (1, 10): (2751, 3099, 3216),
    (1, 30): (9044, 8922, 8802),
    (1, 100): (34047, 35529, 35426),
    (1, 300): (133241, 136119, 134177),
    (1, 1000): (662586, 649656, 662351),
    (2, 10): (2239, 2926, 3216),
    (2, 30): (5136, 5225, 4759),
    (2, 100): (18206, 19403, 19123),
    (2, 300): (69917, 72626, 71543),
    (2, 1000): (355791, 355298, 358045),
}
# Arms, row and size -> a value for each seed.
Values = dict[tuple[int, str, int], list[float]]


def measured(
    kernel: Kernel, size: int, seed: int, arms: int, peers: str | None, clock: Callable[[], float]
) -> Iterator[tuple[str, float]]:
    """Yield rows and values of one panel; `clock` returns the time that searches may take [s]."""
    document = random_panel(size, seed, arms)
    tables = tables_of(problem_from(document))
    best = BEST_KNOWN[arms, size][seed - 1] if (arms, size) in BEST_KNOWN else math.nan

    def above(planned: Planned) -> float:
        require_valid(planned)
        return 100 * (planned.cost / best - 1)

    took_s, first = timed(lambda: AnytimePlanner(kernel, tables).first())
    yield "first plan [ms]", 1e3 * took_s
    yield "first plan above best [%]", above(first)
    for kind in ("jam", "move"):
        yield f"patched after {kind} [ms]", 1e3 * patched_s(kernel, first, kind)
    for limit_s in (1, 10):
        row = f"after {limit_s} s above best [%]"
        if row in TARGETS[arms]:
            planner = AnytimePlanner(kernel, tables)
            yield row, above(planner.improved(Limits(limit_s), clock=clock).planned)
    if peers and arms == 1:
        took_s, planned = by_gtpyhop(kernel, peers, document, tables)
        yield "GTPyhop [ms]", 1e3 * took_s
        yield "GTPyhop above best [%]", above(planned)


def timed(make: Callable[[], Planned]) -> tuple[float, Planned]:
    """Return the least time [s] of some repetitions, and what was made."""
    times = []
    for _ in range(REPETITIONS):
        started = time.perf_counter()
        planned = make()
        times.append(time.perf_counter() - started)
    return min(times), planned


def require_valid(planned: Planned) -> None:
    """End the program if a plan breaks a rule, or its cost is another one."""
    verdict = check(planned.tables.problem, planned.plan)
    if not verdict.valid or verdict.cost != planned.cost:
        raise SystemExit(f"{planned.tables.problem.name}: {verdict.violations[:3]}")


def patched_s(kernel: Kernel, planned: Planned, kind: str) -> float:
    """Return the time to a new plan [s] after a failure half-way."""
    plan, problem = planned.plan, planned.tables.problem
    wanted = ActionKind.INSERT if kind == "jam" else ActionKind.PICK
    half = len(plan.actions) // 2
    index = next(i for i, a in enumerate(plan.actions) if i >= half and a.kind is wanted)
    if kind == "jam":
        left = after_jam(problem, plan, index)
    else:
        wire = problem.wire[str(plan.actions[index].wire)]
        component = problem.end_terminal(wire, End.A).component
        left = after_move(problem, plan, index, component, (-46, 25))
    tables = tables_of(left)
    order = remaining_order(planned, tables)
    took_s, patched = timed(lambda: AnytimePlanner(kernel, tables).patched(*order))
    require_valid(patched)
    return took_s


def peer(python: str, name: str, path: str) -> Any:  # noqa: ANN401 - JSON
    """Return what another planner prints."""
    line = [python, str(Path(__file__).with_name("peers.py")), name, path]
    return json.loads(subprocess.check_output(line, text=True).splitlines()[-1])


def by_gtpyhop(
    kernel: Kernel, python: str, document: dict[str, object], tables: Tables
) -> tuple[float, Planned]:
    """Return how long GTPyhop plans a panel [s], and its plan."""
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(document, file)
        file.flush()
        found = peer(python, "gtpyhop", file.name)
    number = {name: i for i, name in enumerate(tables.wires)}
    order = np.array([number[name] for name, _ in found["wires"]], np.int32)
    modes = np.zeros(len(order), np.int32)
    for name, first in found["wires"]:
        modes[number[name]] = Mode(0, End(first), False).number
    return found["seconds"], AnytimePlanner(kernel, tables).patched(order, modes)


def is_optimal(python: str, seed: int) -> bool:
    """Return whether our cost of a small panel is the least, and what others find of our plan."""
    problem = problem_from(random_panel(OPTIMAL_WIRES, seed, 1))
    planned = plan_problem(problem, PLANNING_S)
    symbols = symbols_of(problem)
    with tempfile.TemporaryDirectory() as folder:
        for name, form in (("pddl", pddl), ("hddl", hddl)):
            Path(folder, f"domain.{name}").write_text(form.domain_text())
            Path(folder, f"problem.{name}").write_text(form.problem_text(symbols))
        steps = steps_of(problem, planned.plan, symbols)
        Path(folder, "plan.txt").write_text(pddl.plan_text(steps, planned.cost))
        found = peer(python, "fast-downward", folder)
    print(f"sw1-{OPTIMAL_WIRES}-{seed}: ours {planned.cost}, Fast Downward: {found}")
    return bool(found["valid"]) and planned.cost == found["plan"] == found["optimal"]


def rows(values: Values) -> Iterator[dict[str, str]]:
    """Yield the rows of the docs' table: measured, and the target in brackets."""
    sizes = sorted({size for _, _, size in values})
    for arms, row in dict.fromkeys((arms, row) for arms, row, _ in values):
        words = f"{'one arm' if arms == 1 else 'two arms'}: {row}"
        yield {
            "median of three panels": words,
            **{f"{size} wires": cell(values, arms, row, size) for size in sizes},
        }


def cell(values: Values, arms: int, row: str, size: int) -> str:
    """Return a cell of the table."""
    value = statistics.median(values[arms, row, size])
    shown = f"{value:.2f}" if "[%]" in row else f"{value:.2g}" if value < 100 else f"{value:.0f}"
    target = dict(zip(SIZES, TARGETS[arms].get(row, ()), strict=False)).get(size)
    if target is None:
        return shown
    return f"{shown} ({target:g})" + " (missed)" * (float(shown) > target)


def main() -> int:
    """Measure and print; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES)
    parser.add_argument("--peers", metavar="PYTHON", help="that has GTPyhop and Fast Downward")
    parser.add_argument("--whole", action="store_true", help="do all the work of the time limits")
    add_figures_option(parser)
    options = parser.parse_args()
    kernel, clock = Kernel(), (lambda: 0.0) if options.whole else time.monotonic
    values: Values = defaultdict(list)
    for arms, size, seed in itertools.product(TARGETS, options.sizes, SEEDS):
        for row, value in measured(kernel, size, seed, arms, options.peers, clock):
            values[arms, row, size].append(value)
    report_table(rows(values), options.figures)
    megabytes = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"memory: {megabytes:.0f} MB")
    optimal = [is_optimal(options.peers, seed) for seed in OPTIMAL_SEEDS if options.peers]
    return 0 if all(optimal) else 1


if __name__ == "__main__":
    sys.exit(main())
