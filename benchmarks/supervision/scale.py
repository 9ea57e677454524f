#!/usr/bin/env python3
"""A run of 5,000 tasks: database size, events kept per second, and what resuming it takes.

scale.py [--tasks N] [--figures FILE]; the workspace must be sourced. The events are appended
without ROS, and without waiting for the disk except for the last ones, by which the rate is
measured. The state is then loaded by processes of their own, which report their time and their peak
memory. Exits with 1 when a target is missed.
"""

from __future__ import annotations

import argparse
import multiprocessing
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from sqlalchemy import event
from sqlalchemy.engine import Engine

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_supervision/test/unit"))
from figures import Figure, add_figures_option, report
from long_run import long_order, long_run

from remodel_production.edge.database.cell_ownership import CellOwnership, Owned
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.edge.run_log import RunLog

# How many events the rate is measured by.
MEASURED = 300


def append_run(url: str, tasks: int) -> tuple[int, float]:
    """Append a run that is cut short before its end; return its events, and how many a second."""
    order = long_order(tasks)
    events = list(long_run(order))
    with _hasty():
        database = ProductionDatabase(url)
        database.add_order(order)
        owned = CellOwnership(database, "cell", "bench", "the benchmark", 3600.0).acquire()
        assert isinstance(owned, Owned), "the database is new"
        log = RunLog(database)
        run, begun = log.begin(events[0], owned.token)
        state = state_after([begun])
        for each in events[1:-MEASURED]:
            state = log.append(run, each, state, owned.token)
    log = RunLog(ProductionDatabase(url))
    start = time.monotonic()
    for each in events[-MEASURED:]:
        state = log.append(run, each, state, owned.token)
    return len(events), MEASURED / (time.monotonic() - start)


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


def resume(url: str) -> tuple[float, float]:
    """Load the state of the first run; return the time [s] and the peak memory [MB]."""
    database = ProductionDatabase(url)
    start = time.monotonic()
    RunLog(database).state(1)
    took_s = time.monotonic() - start
    database.close()
    # Of this program; the kernel's resource usage includes what the process was before.
    status = Path("/proc/self/status").read_text(encoding="ascii")
    return took_s, int(status.partition("VmHWM:")[2].split()[0]) / 1024


def measured(tasks: int) -> Iterator[Figure]:
    """Yield the figures of an order of so many tasks."""
    with tempfile.TemporaryDirectory() as folder:
        url = f"sqlite:///{folder}/production.sqlite"
        count, rate = append_run(url, tasks)
        with multiprocessing.get_context("spawn").Pool(1, maxtasksperchild=1) as pool:
            times_s, peaks_mb = zip(*pool.map(resume, [url] * 3, chunksize=1), strict=True)
        size_mb = sum(each.stat().st_size for each in Path(folder).iterdir()) / 1e6
    yield Figure("load the state", min(times_s), "s", most=0.5)
    yield Figure("peak memory of the process that loads it", max(peaks_mb), "MB", most=100.0)
    yield Figure("database (SQLite)", size_mb, "MB", most=40.0)
    yield Figure("events of the run", count)
    yield Figure("events kept per second, each on disk", rate)


def main() -> int:
    """Print the figures, and return 1 if one misses its target."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tasks", type=int, default=5000, help="of the order (default 5000)")
    add_figures_option(parser)
    options = parser.parse_args()
    return 0 if report(measured(options.tasks), options.figures) else 1


if __name__ == "__main__":
    sys.exit(main())
