"""What runs have left behind, read while they run, and judged when they have ended."""

from __future__ import annotations

import contextlib
import io
import os
import shutil
import sqlite3
import subprocess
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, TypeVar

from stack import TroubleError, wait_until

from remodel_planner.commands.runs import replay
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.errors import LostError
from remodel_states.testing.world import account
from remodel_states.testing.world_file import WorldFile
from remodel_supervision.core.runs.events import (
    Command,
    Commanded,
    Ending,
    Event,
    Interrupted,
    Part,
    TaskBegun,
)
from remodel_supervision.core.runs.state import RunState, Stage
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.edge.run_rows import KeptEvent

T = TypeVar("T")

# [s] wall time for what must happen; beyond it the run hangs.
LIMIT_S = 90.0
_RETRY_S = 0.1

# What happens to a run, and is no progress.
_NO_NEWS = (Interrupted, Commanded)


@dataclass(frozen=True)
class Struck:
    """A fault that was caused.

    Attributes:
        kind: row of the table.
        position: how many events its run had before.
        resume_s: [s] wall time until the run went on.
        late: what was begun after a command was answered that stops all motion.
    """

    kind: str
    position: int
    resume_s: float
    late: tuple[str, ...] = ()


@dataclass
class Score:
    """What came of all runs.

    Attributes:
        retried: kind -> the most tasks that were attempted again after one of its faults.
        violations: what must never be, in words.
    """

    faults: list[Struck] = field(default_factory=list)
    retried: dict[str, int] = field(default_factory=dict)
    orders: int = 0
    complete: int = 0
    tasks: int = 0
    repeated: int = 0
    omitted: int = 0
    scrapped: int = 0
    differences: int = 0
    violations: list[str] = field(default_factory=list)


class Records:
    """The production database and the fake cell's ledger."""

    def __init__(self, url: str, world: Path) -> None:
        self._url = url
        self._log = RunLog(ProductionDatabase(url))
        self._world = WorldFile(world)

    def newest(self) -> int:
        """Return the number of the newest run; 0 without any."""
        return max((head.number for head in _insist(self._log.heads)), default=0)

    def has_ended(self, run: int) -> bool:
        """Return whether a run has ended."""
        return next(head.ended for head in _insist(self._log.heads) if head.number == run)

    def state(self, run: int) -> RunState:
        """Return what is known of a run."""
        return _insist(lambda: self._log.state(run))

    def events(self, run: int, since: int = 0) -> list[KeptEvent]:
        """Return what happened in a run since a position."""
        return _insist(lambda: list(self._log.events(run, since)))

    def news(self, run: int, since: int) -> list[Event]:
        """Return the events since a position by which the run went on."""
        events = [kept.event for kept in self.events(run, since)]
        return [event for event in events if not isinstance(event, _NO_NEWS)]

    def deeds_after(self, at_s: float) -> list[str]:
        """Return what the fake cell did after a wall time [s] since 1970."""
        return [f"{e.deed.value} {e.wire}/{e.end}" for e in self._world.ledger() if e.at_s > at_s]

    def resumed_s(self, run: int, since: int, what: str) -> float:
        """Return after how long [s] from now a run goes on; 0 if it has since a position."""
        begun = time.monotonic()
        if self.news(run, since) or self.has_ended(run):
            return 0.0
        wait_until(
            lambda: bool(self.news(run, since)) or self.has_ended(run), LIMIT_S, f"news: {what}"
        )
        return time.monotonic() - begun

    def judge(self, run: int, faults: Sequence[Struck], score: Score) -> None:
        """Add a run that has ended, and the faults that it met."""
        state = self.state(run)
        done = state.in_stage(Stage.DONE)
        is_complete = state.ended is not None and state.ended.ending is Ending.COMPLETE
        found = account(self._world.ledger(), list(state.tasks))
        omitted = [end for end in found.omitted if end[:-2] in done]
        # A cell takes up only the wire fed last: a half placed one that was skipped is replaced.
        skipped = self._skipped(run)
        repeated = [end for end in found.fixed_again if end[:-2] not in skipped]
        scrapped = [wire for wire in found.scrapped if wire not in skipped]
        differences = _differences(self._url, run)
        score.faults += faults
        score.orders += 1
        score.tasks += len(state.tasks)
        score.complete += is_complete
        score.repeated += len(repeated)
        score.omitted += len(omitted)
        score.scrapped += len(scrapped)
        score.differences += len(differences)
        violations = [f"{end} fixed twice" for end in repeated]
        violations += [f"{end} left out" for end in omitted]
        violations += [f"a piece of {wire} scrapped with an end fixed" for wire in scrapped]
        violations += [f"replay: {difference}" for difference in differences]
        violations += [f"{late} after the answer to {f.kind}" for f in faults for late in f.late]
        if not is_complete:
            violations.append(f"not complete: {state.ended}")
        elif found.omitted:
            violations.append(f"reported complete without {found.omitted}")
        score.violations += [f"run {run}: {violation}" for violation in violations]
        self._count_retried(run, faults, score)

    def _skipped(self, run: int) -> set[str]:
        """Return the tasks that were skipped on request."""
        events = [kept.event for kept in self.events(run)]
        return {e.task for e in events if isinstance(e, Commanded) and e.command is Command.SKIP}

    def _count_retried(self, run: int, faults: Sequence[Struck], score: Score) -> None:
        """Count the tasks that were attempted again between each fault and the next one."""
        events = [kept.event for kept in self.events(run)]
        ends = [fault.position for fault in faults[1:]] + [len(events)]
        for fault, end in zip(faults, ends, strict=True):
            again = {
                event.task
                for event in events[fault.position : end]
                if isinstance(event, TaskBegun)
                and event.part.is_attempt
                and (event.part is not Part.WHOLE or event.attempt > 1)
            }
            score.retried[fault.kind] = max(score.retried.get(fault.kind, 0), len(again))


def _differences(url: str, run: int) -> list[str]:
    """Return how a run differs from what `replay` makes of its record."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exit_code = replay.main([str(run), "--quiet", "--database", url])
    lines = [line for line in printed.getvalue().splitlines() if line.startswith("DIFFERS")]
    return lines or ([f"exit code {exit_code}"] if exit_code else [])


def _insist(ask: Callable[[], T]) -> T:
    """Return what the database answers, once it answers."""
    end = time.monotonic() + LIMIT_S
    while True:
        try:
            return ask()
        except LostError as error:
            if time.monotonic() > end:
                raise TroubleError(str(error)) from error
            time.sleep(_RETRY_S)


# The production database of a benchmark, and what may happen to it: a lock, a restart


_PROGRAMS = Path("/usr/lib/postgresql")
_LIMIT_S = 60.0


class Server(Protocol):
    """A production database.

    Attributes:
        url: at which the planner finds it.
    """

    url: str

    def disturb(self, for_s: float) -> None:
        """Have it take no writes for some wall time [s]."""

    def end(self) -> None:
        """End it, if it is a process."""


class SqliteFile:
    """A file; another program's writer can lock it."""

    def __init__(self, folder: Path) -> None:
        """Name the file; the first process that opens it creates it."""
        self._file = folder / "production.sqlite"
        self.url = f"sqlite:///{self._file}"

    def disturb(self, for_s: float) -> None:
        """Hold the lock of a writer."""
        with closing(sqlite3.connect(self._file, timeout=_LIMIT_S, isolation_level=None)) as writer:
            writer.execute("BEGIN IMMEDIATE")
            time.sleep(for_s)
            writer.execute("ROLLBACK")

    def end(self) -> None:
        """Do nothing: there is no process."""


class PostgresServer:
    """A PostgreSQL server that listens on a socket in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self._programs = max(_PROGRAMS.glob("*/bin"))
        self._folder = folder
        folder.mkdir(parents=True)
        if os.geteuid() == 0:  # PostgreSQL refuses to be run by root
            for each in (folder, *folder.parents[:1]):
                shutil.chown(each, "postgres", "postgres")
        self.url = f"postgresql+psycopg2://test@/postgres?host={folder}"
        self._run("initdb", "-D", str(folder / "data"), "-U", "test", "-A", "trust", "-N")
        self._start()

    def disturb(self, for_s: float) -> None:
        """Restart it as after a crash, some time later."""
        self.end()
        time.sleep(for_s)
        self._start()

    def end(self) -> None:
        """End it without a word to its clients."""
        self._run("pg_ctl", "stop", "-w", "-m", "immediate", "-D", str(self._folder / "data"))

    def _start(self) -> None:
        settings = f"-c listen_addresses= -c unix_socket_directories={self._folder} -c fsync=off"
        line = ("start", "-w", "-D", str(self._folder / "data"), "-o", settings)
        self._run("pg_ctl", *line, "-l", str(self._folder / "log"))

    def _run(self, program: str, *arguments: str) -> None:
        user = {"user": "postgres", "group": "postgres", "extra_groups": []}
        subprocess.run(
            [str(self._programs / program), *arguments],
            check=True,
            timeout=_LIMIT_S,
            cwd=self._folder,
            stdout=subprocess.DEVNULL,
            **(user if os.geteuid() == 0 else {}),  # type: ignore[arg-type]
        )
