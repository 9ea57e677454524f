#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""A run of 5,000 tasks: database size, appends a second, and what resuming it takes.

The events are appended without ROS, and without waiting for the disk except for the last ones, by
which the rate is measured. The state is then loaded by a process of its own, which reports its time
and its peak memory.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from long_run import long_order, long_run
from sqlalchemy import event
from sqlalchemy.engine import Engine
from stack import add_figures_option, write_figures

from remodel_production.core.production import Order
from remodel_production.edge.database.cell_ownership import CellOwnership, Owned
from remodel_production.edge.database.database_backup import back_up
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.edge.run_log import RunLog

# [s], [MB], [MB]: resume, its memory, and the database, for 5,000 tasks.
_TARGETS = (0.5, 100.0, 40.0)
_TASKS = 5000
# How many events the rate is measured by.
_MEASURED = 300


def append_run(url: str, tasks: int) -> tuple[int, float]:
    """Append a run that is cut short before its end; return its events, and how many a second."""
    order = long_order(tasks)
    events = list(long_run(order))
    with _hasty():
        log, token = _opened(url, order)
        run, begun = log.begin(events[0], token)
        state = state_after([begun])
        for each in events[1:-_MEASURED]:
            state = log.append(run, each, state, token)
    log = RunLog(ProductionDatabase(url))
    start = time.monotonic()
    for each in events[-_MEASURED:]:
        state = log.append(run, each, state, token)
    return len(events), _MEASURED / (time.monotonic() - start)


@contextmanager
def _hasty() -> Iterator[None]:
    """Let SQLite's new connections not wait for the disk."""

    def hurry(connection: object, _: object) -> None:
        connection.execute("PRAGMA synchronous=OFF")  # type: ignore[attr-defined]

    event.listen(Engine, "connect", hurry)
    try:
        yield
    finally:
        event.remove(Engine, "connect", hurry)


def _opened(url: str, order: Order) -> tuple[RunLog, int]:
    """Return the log of a database with an order, and the token of the cell's ownership."""
    database = ProductionDatabase(url)
    database.add_order(order)
    owned = CellOwnership(database, "cell", "bench", "the benchmark", 3600.0).acquire()
    if not isinstance(owned, Owned):
        raise SystemExit(f"scale: {owned.holder} has the cell")
    return RunLog(database), owned.token


def resume(url: str) -> None:
    """Load the state of the first run, and print the time [s], the peak memory [MB] and it."""
    database = ProductionDatabase(url)
    start = time.monotonic()
    state = RunLog(database).state(1)
    took_s = time.monotonic() - start
    # Of this program; the kernel's resource usage includes what the process was before.
    status = Path("/proc/self/status").read_text(encoding="ascii")
    peak_mb = int(status.partition("VmHWM:")[2].split()[0]) / 1024
    database.close()
    print(f"{took_s} {peak_mb} {_done(state)}")


def _done(state: RunState) -> int:
    return sum(task.stage.is_lasting for task in state.tasks.values())


def main() -> int:
    """Print the figures, and return 1 if one of 5,000 tasks misses its target."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument(
        "--tasks", type=int, default=_TASKS, help="of the order (default %(default)s)"
    )
    parser.add_argument("--keep", metavar="FILE", help="where the database is kept afterwards")
    add_figures_option(parser)
    parser.add_argument("--resume", metavar="URL", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.resume:
        resume(options.resume)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "production.sqlite"
        url = f"sqlite:///{file}"
        count, rate = append_run(url, options.tasks)
        line = [sys.executable, __file__, "--resume", url]
        took = [subprocess.run(line, check=True, capture_output=True, text=True) for _ in range(3)]
        runs = [tuple(map(float, each.stdout.split())) for each in took]
        if options.keep:
            back_up(url, Path(options.keep), replace=True)
        size_mb = sum(each.stat().st_size for each in Path(folder).iterdir()) / 1e6
    resume_s, peak_mb = min(r[0] for r in runs), max(r[1] for r in runs)
    print(f"{options.tasks} tasks, {count} events, {runs[0][2]:.0f} tasks ended")
    print(f"appends a second:   {rate:10.0f}")
    print(f"resume [s]:         {resume_s:10.3f}   target {_TARGETS[0]} (best of 3)")
    print(f"peak memory [MB]:   {peak_mb:10.1f}   target {_TARGETS[1]}")
    print(f"database [MB]:      {size_mb:10.1f}   target {_TARGETS[2]}")
    write_figures(
        options.figures,
        (
            {"what": what, "value": value, "unit": unit, "most": most}
            for what, value, unit, most in (
                ("load the state", resume_s, "s", _TARGETS[0]),
                ("peak memory of the process that loads it", peak_mb, "MB", _TARGETS[1]),
                ("database (SQLite)", size_mb, "MB", _TARGETS[2]),
                ("events of the run", count, "", None),
                ("events kept per second, each on disk", rate, "", None),
            )
        ),
    )
    missed = [v for v, t in zip((resume_s, peak_mb, size_mb), _TARGETS, strict=True) if v > t]
    return 1 if missed and options.tasks <= _TASKS else 0


if __name__ == "__main__":
    sys.exit(main())
