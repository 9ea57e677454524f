#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Disturb a running order at random moments: chaos.py [--faults N] [--seed N] [--kinds ...].

kill        SIGKILL of the use case supervisor, the behavior engine, its action server, the
            synthesizer, the console, each of a fake cell's four processes, or all at once
terminate   SIGTERM or SIGINT of the supervisor, the engine or its action server
stall       SIGSTOP of any of them or of the ROS master, then SIGCONT
launch      Ctrl-C of roslaunch; all is launched again
master      end or SIGKILL of the ROS master; master and launch are started again
database    a crash and restart of PostgreSQL (--postgresql), or a long lock of the SQLite file
station     another ROS master and supervisor claim the same cell
duplicate   a latched goal, which each supervisor that starts gets
pause, protective   by an operator or a safety controller; later the run is resumed
skip        of a task, which is retried later

The fake cell's world is a file with a ledger of what cannot be undone, which judges: an end that
was fixed twice was repeated, an end that was not fixed was omitted. Each run must be complete, and
`replay` must find no difference. After the answer to a pause or a protective stop nothing may be
sent or done.

resume: from the moment at which what was disturbed answers again to the next event of the run,
which is a finished operation or a decision; 0 when the run went on meanwhile.
"""

from __future__ import annotations

import argparse
import shutil
import statistics
import sys
import tempfile
import time
from pathlib import Path
from random import Random

from chaos_faults import NODES, WEIGHTS, BystanderProcess, Faults, Site
from chaos_records import LIMIT_S, PostgresServer, Records, Score, Server, SqliteFile, Struck
from stack import (
    ORDER,
    TroubleError,
    add_figures_option,
    free_port,
    replace_row,
    stack,
    wait_until,
)

from remodel_production.errors import LostError

HERE = Path(__file__).parent

# [s] that a run may take to go on.
RESUME_TARGET_S = 2.0

# [s] wall time between two faults.
_BETWEEN_S = (0.2, 2.5)


class Chaos:
    """Runs orders while it disturbs them."""

    def __init__(self, site: Site, wires: int, kinds: list[str], faults: Faults) -> None:
        self._site = site
        self._records = site.records
        self._wires = wires
        self._kinds = kinds
        self._faults = faults
        self.score = Score()

    def run(self, count: int, random: Random) -> None:
        """Cause so many faults, over as many orders as that takes."""
        caused = 0
        while caused < count:
            run = self._begin()
            struck: list[Struck] = []
            violations = len(self.score.violations)
            while not self._records.has_ended(run):
                if caused + len(struck) < count:
                    if (fault := self._strike(run, random)) is not None:
                        struck.append(fault)
                        _print(caused + len(struck), fault)
                else:
                    self._await_end(run)
            self._records.judge(run, struck, self.score)
            caused += len(struck)
            for violation in self.score.violations[violations:]:
                print(f"VIOLATION {violation}", flush=True)

    def _begin(self) -> int:
        """Have the order done again, and return the number of the run."""
        end = time.monotonic() + LIMIT_S
        while time.monotonic() < end:
            before = self._records.newest()
            bystander = self._site.bystander.now
            try:
                bystander.order(ORDER, self._wires, LIMIT_S)
                wait_until(lambda n=before: self._records.newest() > n, 5.0, "the run's begin")
            except (TroubleError, LostError):
                if refusal := bystander.refusal():
                    print(f"refused: {refusal}")
                continue
            return self._records.newest()
        raise TroubleError("no run begins")

    def _await_end(self, run: int) -> None:
        wait_until(lambda: self._records.has_ended(run), LIMIT_S * 5, f"the end of run {run}")

    def _strike(self, run: int, random: Random) -> Struck | None:
        """Cause one fault after a random time, unless the run ends before."""
        end = time.monotonic() + random.uniform(*_BETWEEN_S)
        while time.monotonic() < end and not self._records.has_ended(run):
            time.sleep(0.01)
        if self._records.has_ended(run):
            return None
        weights = [WEIGHTS[kind] for kind in self._kinds]
        return self._faults.strike(random.choices(self._kinds, weights)[0], run)


def _print(number: int, fault: Struck) -> None:
    late = f"; {len(fault.late)} begun after the answer" if fault.late else ""
    resume = f"back at work after {fault.resume_s:.2f} s"
    print(f"fault {number:4d}: {fault.kind:<34} {resume}{late}", flush=True)


def main() -> int:
    """Print what came of it, and return 1 if a target is missed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--faults", "--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kinds", nargs="+", choices=WEIGHTS, default=list(WEIGHTS))
    parser.add_argument("--wires", type=int, default=14, help="of each order")
    parser.add_argument("--operation", type=float, default=0.06, help="[s] wall time of one")
    parser.add_argument("--long-stalls", action="store_true", help="a third of them for 45 s")
    parser.add_argument("--postgresql", action="store_true", help="in place of SQLite")
    parser.add_argument("--keep", action="store_true", help="keep the folder with all logs")
    add_figures_option(parser)
    options = parser.parse_args()
    output = Path(tempfile.mkdtemp(prefix="remodel_chaos_")) / "run"
    started = time.monotonic()
    server: Server = (
        PostgresServer(output.parent / "postgresql") if options.postgresql else SqliteFile(output)
    )
    try:
        score = _disturbed(options, output, server)
    except TroubleError as error:
        print(f"TROUBLE: {error}; logs in {output}")
        return 1
    finally:
        server.end()
    is_clean = _report(score, time.monotonic() - started)
    replace_row(options.figures, _row(options, score))
    if options.keep or not is_clean:
        print(f"logs in {output}")
    else:
        shutil.rmtree(output.parent)
    return 0 if is_clean else 1


def _row(options: argparse.Namespace, score: Score) -> dict[str, str]:
    """Return the row of the docs' table."""
    times = [fault.resume_s for fault in score.faults]
    chosen = [f"--faults {options.faults} --seed {options.seed}"]
    chosen += ["--postgresql"] * options.postgresql + ["--long-stalls"] * options.long_stalls
    return {
        "options": f"`{' '.join(chosen)}`",
        "orders complete": f"{score.complete} of {score.orders}",
        "ends fixed twice, left out": f"{score.repeated}, {score.omitted}",
        "pieces scrapped": str(score.scrapped),
        "differences when replayed": str(score.differences),
        "resume: slowest": f"{max(times, default=0.0):.2f} s",
        f"over {RESUME_TARGET_S:g} s": str(sum(time_s > RESUME_TARGET_S for time_s in times)),
    }


def _disturbed(options: argparse.Namespace, output: Path, server: Server) -> Score:
    """Return what came of the orders; TroubleError if one hangs."""
    launch = HERE / "chaos.launch"
    given = {"duration_s": options.operation, "console_port": free_port()}
    random = Random(options.seed)
    with stack(launch, output, url=server.url, **given) as nodes:
        nodes.wait_for(*NODES)
        bystander = BystanderProcess()
        records = Records(server.url, output / "world.sqlite")
        site = Site(nodes, server, bystander, records)
        faults = Faults(site, random, long_stalls=options.long_stalls)
        chaos = Chaos(site, options.wires, options.kinds, faults)
        try:
            chaos.run(options.faults, random)
        except TroubleError:
            _report(chaos.score, 0.0)
            raise
        finally:
            bystander.end()
    return chaos.score


def _report(score: Score, wall_s: float) -> bool:
    """Print the table; return whether all targets but the times are met."""
    kinds: dict[str, list[Struck]] = {}
    for struck in score.faults:
        kinds.setdefault(struck.kind, []).append(struck)
    heads = f"{'times':>6}{'resume: median':>17}{'worst':>9}{'retried':>9}{'late':>6}"
    print(f"\n{'what was done':<34}{heads}")
    for kind, faults in sorted(kinds.items()):
        times = [fault.resume_s for fault in faults]
        late = sum(len(fault.late) for fault in faults)
        print(
            f"{kind:<34}{len(faults):6d}{statistics.median(times):15.2f} s{max(times):7.2f} s"
            f"{score.retried[kind]:9d}{late:6d}"
        )
    times = [fault.resume_s for fault in score.faults]
    print(
        f"{len(times)} faults in {wall_s:.0f} s: {score.complete} of {score.orders} orders "
        f"complete ({score.tasks} tasks), {score.repeated} ends fixed twice, {score.omitted} left "
        f"out, {score.scrapped} pieces scrapped with an end fixed, {score.differences} differences "
        f"when replayed; resume: slowest {max(times, default=0.0):.2f} s, over "
        f"{RESUME_TARGET_S:.0f} s: {sum(time_s > RESUME_TARGET_S for time_s in times)}"
    )
    for violation in score.violations:
        print(f"  {violation}")
    return not score.violations


if __name__ == "__main__":
    sys.exit(main())
