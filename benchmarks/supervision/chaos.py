#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Kill processes of a running order at random moments: chaos.py [--kills N] [--seed N].

Every target is killed by SIGKILL: the use case supervisor, the behavior engine, its action server,
the synthesizer, the console, each of a fake cell's four processes, or all at once. The fake cell's
world is a file with a ledger of what cannot be undone, which judges: an end that was fixed twice
was repeated, an end that was not fixed was omitted.

resume: from the moment at which the killed nodes answer again to the next event of the run, which
is a finished operation or a decision; 0 when the run went on meanwhile.
"""

from __future__ import annotations

import argparse
import shutil
import statistics
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

import rospy
from remodel_msgs.msg import RunUseCaseAction, RunUseCaseGoal
from stack import ORDER, Stack, TroubleError, free_port, stack, wait_until

from remodel_planner.core.supervision.events import Ending, Interrupted
from remodel_planner.core.supervision.state import Stage, state_after
from remodel_planner.edge.production_database import ProductionDatabase
from remodel_planner.edge.run_log import RunLog
from remodel_planner.ros.action_server import ActionServer
from remodel_states.testing.ledger import account
from remodel_states.testing.world_file import WorldFile

HERE = Path(__file__).parent
SUPERVISOR = "use_case_supervisor"
CELL = ("feeder", "eyes", "hand", "screwdriver")
TARGETS = (SUPERVISOR, "behavior", "behavior_action_server", "synthesis_server", "console", *CELL)
ALL = "all of them"

# [s] that a run may take to go on.
RESUME_TARGET_S = 2.0

# [s] wall time for what must happen; beyond it the run hangs.
_LIMIT_S = 90.0


@dataclass
class Score:
    """What came of the kills."""

    resumes_s: dict[str, list[float]] = field(default_factory=dict)
    orders: int = 0
    complete: int = 0
    tasks: int = 0
    repeated: list[str] = field(default_factory=list)
    omitted: list[str] = field(default_factory=list)
    scrapped: list[str] = field(default_factory=list)

    @property
    def kills(self) -> int:
        """How many there were."""
        return sum(len(times) for times in self.resumes_s.values())


class Chaos:
    """Runs orders while it kills."""

    def __init__(self, nodes: Stack, wires: int, seed: int) -> None:
        """Take the nodes."""
        self._nodes = nodes
        self._wires = wires
        self._random = Random(seed)
        self._log = RunLog(ProductionDatabase(nodes.database))
        self._world = WorldFile(nodes.output / "world.sqlite")
        self._server = ActionServer("remodel/run_use_case", RunUseCaseAction, SUPERVISOR)
        self.score = Score()

    def run(self, kills: int) -> None:
        """Kill so many times, over as many orders as that takes."""
        while self.score.kills < kills:
            run = self._begin()
            while not self._ended(run):
                if self.score.kills < kills:
                    self._strike(run)
                else:
                    self._wait_for_end(run)
            self._judge(run)

    def _begin(self) -> int:
        """Have the order done again, and return the number of the run."""
        before = max((head.number for head in self._log.heads()), default=0)
        end = time.monotonic() + _LIMIT_S
        while time.monotonic() < end:
            self._server.wait(_LIMIT_S)
            sent = self._server.send(
                RunUseCaseGoal(id=f"chaos {before}", order=ORDER, tasks=self._wires, again=True)
            )
            try:
                wait_until(lambda: self._newest() > before, 5.0, "the run's begin")
            except TroubleError:
                if sent.wait(0.0):
                    print(f"refused: {sent.ending}")
                continue
            return self._newest()
        raise TroubleError("no run begins")

    def _wait_for_end(self, run: int) -> None:
        wait_until(lambda: self._ended(run), _LIMIT_S * 5, f"the end of run {run}")

    def _newest(self) -> int:
        return max((head.number for head in self._log.heads()), default=0)

    def _ended(self, run: int) -> bool:
        return next(head.ended for head in self._log.heads() if head.number == run)

    def _strike(self, run: int) -> None:
        """Kill something at a random moment, and measure how long the run takes to go on."""
        end = time.monotonic() + self._random.uniform(0.2, 2.5)
        while time.monotonic() < end and not self._ended(run):
            time.sleep(0.01)
        if self._ended(run):
            return
        name = self._random.choice((*TARGETS, ALL))
        killed = self._nodes.kill(*(TARGETS if name == ALL else (name,)))
        at = sum(1 for _ in self._log.events(run))
        for node, pid in killed.items():
            wait_until(lambda n=node, p=pid: self._nodes.pid(n) not in (0, p), _LIMIT_S, node)
        back = time.monotonic()
        gone_on = len(self._news(run, at)) > 0
        wait_until(lambda: self._news(run, at) or self._ended(run), _LIMIT_S, f"news after {name}")
        took_s = 0.0 if gone_on else time.monotonic() - back
        self.score.resumes_s.setdefault(name, []).append(took_s)
        count = self.score.kills
        print(f"kill {count:4d}: {name:<24} back at work after {took_s:.2f} s", flush=True)

    def _news(self, run: int, since: int) -> list[object]:
        """Return the events of a run since a position that are more than an interruption."""
        events = [kept.event for kept in self._log.events(run, since)]
        return [event for event in events if not isinstance(event, Interrupted)]

    def _judge(self, run: int) -> None:
        state = self._log.state(run)
        done = state.in_stage(Stage.DONE)
        found = account(self._world.ledger(), list(state.tasks))
        score = self.score
        score.orders += 1
        score.tasks += len(state.tasks)
        score.complete += state.ended is not None and state.ended.ending is Ending.COMPLETE
        score.repeated += [f"run {run} {end}" for end in found.fixed_again]
        score.omitted += [f"run {run} {end}" for end in found.omitted if end[:-2] in done]
        score.scrapped += [f"run {run} {wire}" for wire in found.scrapped]
        if len(done) < len(state.tasks):
            print(f"run {run}: {state.ended}")


def main() -> int:
    """Print what came of it, and return 1 if a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--wires", type=int, default=14, help="of each order")
    parser.add_argument("--operation", type=float, default=0.06, help="[s] wall time of one")
    parser.add_argument("--keep", action="store_true", help="keep the folder with all logs")
    options = parser.parse_args()
    output = Path(tempfile.mkdtemp(prefix="remodel_chaos_")) / "run"
    launch = HERE / "chaos.launch"
    given = {"duration_s": options.operation, "console_port": free_port()}
    started = time.monotonic()
    with stack(launch, output, **given) as nodes:
        nodes.wait_for(*TARGETS)
        rospy.init_node("chaos", disable_signals=True)
        chaos = Chaos(nodes, options.wires, options.seed)
        try:
            chaos.run(options.kills)
        except TroubleError as error:
            print(f"TROUBLE: {error}; logs in {output}")
            return 1
    if not options.keep:
        shutil.rmtree(output.parent)
    return _tell(chaos.score, time.monotonic() - started)


def _tell(score: Score, wall_s: float) -> int:
    print(f"\n{'killed':<26}{'times':>6}{'resume: median':>17}{'worst':>9}")
    for name, times in sorted(score.resumes_s.items()):
        print(f"{name:<26}{len(times):6d}{statistics.median(times):15.2f} s{max(times):7.2f} s")
    times = sorted(time_s for times in score.resumes_s.values() for time_s in times)
    late = sum(time_s > RESUME_TARGET_S for time_s in times)
    print(
        f"{score.kills} kills in {wall_s:.0f} s: {score.complete} of {score.orders} orders "
        f"complete ({score.tasks} tasks), {len(score.repeated)} ends fixed twice, "
        f"{len(score.omitted)} left out, {len(score.scrapped)} pieces scrapped with an end fixed; "
        f"resume: slowest {times[-1]:.2f} s, over {RESUME_TARGET_S:.0f} s: {late}"
    )
    for line in (*score.repeated, *score.omitted, *score.scrapped):
        print(f"  {line}")
    met = score.complete == score.orders and not score.repeated and not score.omitted
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
