#!/usr/bin/env python3
"""Disturb a running order at random moments: chaos.py [--faults N] [--seed N] [--kinds ...].

kill        SIGKILL of the use case supervisor, the behavior engine, its action server, the
            synthesizer, the console, each of a fake cell's four processes, or all at once
terminate   SIGTERM or SIGINT of the supervisor, the engine or its action server
stall       SIGSTOP of any of them or of the ROS master, then SIGCONT
launch      Ctrl-C of roslaunch; all is launched again
master      end or SIGKILL of the ROS master; master and launch are started again
database    a crash and restart of PostgreSQL (--postgresql), or a long lock of the SQLite file
pause, protective   by an operator or a safety controller; later the run is resumed
skip        of a task, which is retried later

The fake cell's world is a file with a ledger of what cannot be undone, which judges: an end that
was fixed twice was repeated, an end that was not fixed was omitted. Each run must be complete, and
`replay` must find no difference. After the answer to a pause or a protective stop nothing may be
sent or done.

resume: from the moment at which what was disturbed answers again to the next event of the run,
which is a finished operation or a decision; 0 when the run went on meanwhile.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import argparse
import contextlib
import io
import json
import shutil
import statistics
import sys
import tempfile
import time
from collections import Counter, defaultdict
from pathlib import Path
from random import Random

sys.path.insert(0, str(Path(__file__).parents[1]))
from disturbances import NODES, WEIGHTS, Disturbances, PostgresServer, SqliteFile, Struck
from figures import add_figures_option, report_table, write_rows
from stack import LIMIT_S, Runs, free_port, stack, wait_until

from remodel_planner.commands.runs import replay
from remodel_states.testing.world import account
from remodel_states.testing.world_file import WorldFile
from remodel_supervision.core.runs.events import Command, Commanded, Ending
from remodel_supervision.core.runs.state import Stage

# [s] that a run may take to go on, and wall time between two disturbances.
RESUME_TARGET_S, BETWEEN_S = 2.0, (0.2, 2.5)


class Chaos:
    """Runs orders while it disturbs them.

    Attributes:
        struck: disturbances that were caused.
        counts: of orders, and of what is wrong, by the words of the docs' table.
        violations: what must never be, in words.
    """

    def __init__(self, disturbances: Disturbances, runs: Runs, world: WorldFile, url: str) -> None:
        self.struck: list[Struck] = []
        self.counts: Counter[str] = Counter()
        self.violations: list[str] = []
        self._disturbances, self._runs, self._world, self._url = disturbances, runs, world, url

    def run(self, count: int, wires: int, kinds: list[str], random: Random) -> None:
        """Cause so many disturbances, over as many orders of so many wires as that takes."""
        while len(self.struck) < count:
            run = self._begin(wires)
            while not self._runs.has_ended(run):
                end = time.monotonic() + random.uniform(*BETWEEN_S)
                while time.monotonic() < end and not self._runs.has_ended(run):
                    time.sleep(0.01)
                if len(self.struck) < count and not self._runs.has_ended(run):
                    kind = random.choices(kinds, [WEIGHTS[each] for each in kinds])[0]
                    self._strike(kind, run)
            self._judge(run)

    def _begin(self, wires: int) -> int:
        """Have the order done again, and return the number of the run."""
        end = time.monotonic() + LIMIT_S
        while time.monotonic() < end:
            before, bystander = self._runs.newest(), self._disturbances.bystander
            with contextlib.suppress(AssertionError):
                bystander.order(wires)
                wait_until(lambda n=before: self._runs.newest() > n, "the run's begin", 5.0)
                return self._runs.newest()
            print(f"no run yet: {bystander.refusal()}", flush=True)
        raise AssertionError("no run begins")

    def _strike(self, kind: str, run: int) -> None:
        if (struck := self._disturbances.strike(kind, run)) is None:
            return
        self.struck.append(struck)
        late = f"; begun after the answer: {', '.join(struck.late)}" if struck.late else ""
        self.violations += [f"run {run}: {struck.kind}{late}"] if late else []
        after = f"back at work after {struck.resume_s:.2f} s{late}"
        print(f"{len(self.struck):4d}: {struck.kind:<34} {after}", flush=True)

    def _judge(self, run: int) -> None:
        """Compare a run that has ended with the ledger of the world and with its replay."""
        state = self._runs.state(run)
        found = account(self._world.ledger(), list(state.tasks))
        # A cell takes up only the wire fed last: a half placed one that was skipped is replaced.
        events = [kept.event for kept in self._runs.events(run)]
        skipped = {e.task for e in events if isinstance(e, Commanded) and e.command is Command.SKIP}
        done = state.in_stage(Stage.DONE)
        is_complete = state.ended is not None and state.ended.ending is Ending.COMPLETE
        wrong = {
            "fixed twice": [end for end in found.fixed_again if end[:-2] not in skipped],
            "left out": [end for end in found.omitted if is_complete or end[:-2] in done],
            "scrapped": [wire for wire in found.scrapped if wire not in skipped],
            "differs when replayed": differences(self._url, run),
            "not complete": [] if is_complete else [str(state.ended)],
        }
        self.counts.update({"orders": 1, **{what: len(each) for what, each in wrong.items()}})
        violations = [f"run {run}: {what}: {e}" for what, each in wrong.items() for e in each]
        print("".join(f"VIOLATION {each}\n" for each in violations), end="", flush=True)
        self.violations += violations

    def report(self) -> None:
        """Print a line for each kind of disturbance, and what is wrong."""
        times: dict[str, list[float]] = defaultdict(list)
        for struck in self.struck:
            times[struck.kind].append(struck.resume_s)
        for kind, each in sorted(times.items()):
            middle, worst = statistics.median(each), max(each)
            print(f"{kind:<34}{len(each):5d} times, resume: {middle:.2f} s, worst {worst:.2f} s")
        for violation in self.violations:
            print(f"  {violation}")

    def row(self, options: str) -> dict[str, str]:
        """Return the row of the docs' table."""
        counts, times = self.counts, [struck.resume_s for struck in self.struck]
        return {
            "options": f"`{options}`",
            "orders complete": f"{counts['orders'] - counts['not complete']} of {counts['orders']}",
            "ends fixed twice, left out": f"{counts['fixed twice']}, {counts['left out']}",
            "pieces scrapped": str(counts["scrapped"]),
            "differences when replayed": str(counts["differs when replayed"]),
            "resume: slowest": f"{max(times, default=0.0):.2f} s",
            f"over {RESUME_TARGET_S:g} s": str(sum(each > RESUME_TARGET_S for each in times)),
        }


def differences(url: str, run: int) -> list[str]:
    """Return how a run differs from what `replay` makes of its record."""
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exit_code = replay.main([str(run), "--quiet", "--database", url])
    lines = [line for line in printed.getvalue().splitlines() if line.startswith("DIFFERS")]
    return lines or ([f"exit code {exit_code}"] if exit_code else [])


def main() -> int:
    """Print what came of it, and return 1 if something is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faults", type=int, default=200, help="disturbances")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kinds", nargs="+", choices=WEIGHTS, default=list(WEIGHTS))
    parser.add_argument("--long-stalls", action="store_true", help="a third of them for 45 s")
    parser.add_argument("--postgresql", action="store_true", help="in place of SQLite")
    add_figures_option(parser)
    options = parser.parse_args()
    output = Path(tempfile.mkdtemp(prefix="remodel_chaos_")) / "run"
    postgresql = output.parent / "postgresql"
    server = PostgresServer(postgresql) if options.postgresql else SqliteFile(output)
    given = {"duration_s": 0.06, "console_port": free_port()}
    random = Random(options.seed)
    try:
        launch = Path(__file__).with_name("chaos.launch")
        with stack(launch, output, url=server.url, **given) as nodes:
            nodes.wait_for(*NODES)
            runs = Runs(server.url)
            disturbances = Disturbances(
                nodes, server, runs, random, long_stalls=options.long_stalls
            )
            chaos = Chaos(disturbances, runs, WorldFile(output / "world.sqlite"), server.url)
            try:
                chaos.run(options.faults, 14, options.kinds, random)
            finally:
                chaos.report()
                disturbances.end()
    finally:
        server.end()
    chosen = f"--faults {options.faults} --seed {options.seed}"
    chosen += " --postgresql" * options.postgresql + " --long-stalls" * options.long_stalls
    row, file = chaos.row(chosen), options.figures
    report_table([row])
    if file is not None:  # a row for each set of options
        before = map(json.loads, file.read_text().splitlines()) if file.is_file() else ()
        rows = {each["options"]: each for each in before}
        write_rows({**rows, row["options"]: row}.values(), file)
    if chaos.violations:
        print(f"logs in {output}")
        return 1
    shutil.rmtree(output.parent)
    return 0


if __name__ == "__main__":
    sys.exit(main())
