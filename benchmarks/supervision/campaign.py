#!/usr/bin/env python3
"""Cause every kind of fault, and see whether the levels recover, end, and say why.

campaign.py [--kinds KIND ...] [--runs 20] [--seed 0] [--policies ...] [--physical] [--explore]
[--output out/campaign]; the workspace must be sourced. Each run places two wires of a real
cabinet's design with one fault of remodel_msgs/config/faults.yaml, caused at the interface of a
fake cell; once by the policy of the table of faults, once by "retry three times". With --physical
the cell is the simulated one, and faults have physical causes (remodel_msgs/InjectFault). Without
--explore every run uses the forces of the use case and the responses of its policy, so that runs
can be compared; durations and successes are learned all the same, and decide the order of tasks. A
line of JSON for each run stands in trials.jsonl when it has ended. Exits with 1 when a target is
missed.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import shutil
import signal
import sys
import threading
import time
import uuid
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Protocol

import rospy
import yaml
from remodel_msgs.msg import RunUseCaseAction, RunUseCaseGoal
from remodel_msgs.srv import InjectFault
from rosgraph_msgs.msg import Clock
from stack import ORDER, Stack, add_figures_option, stack, write_figures
from tqdm import tqdm
from trial import (
    BY_HAND,
    PHYSICAL_KINDS,
    WIRES,
    Trial,
    Verdict,
    cell_s,
    decided_first,
    docs_rows,
    drawn,
    drawn_physical,
    handled_first,
    is_complete,
    is_explained,
    needs_person,
    print_table,
)

from remodel_planner.commands.runs import explain_run, replay
from remodel_production.core.production import TerminalRef
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_states.edge.exported_tables import read_faults
from remodel_states.testing.world_file import WorldFile
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import Event, TaskBegun
from remodel_supervision.core.runs.state import Stage
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.ros.action_server import ActionServer
from remodel_supervision.ros.peers.cell import Cell
from remodel_tasks.core.use_case.model import DesignKind
from remodel_tasks.edge.use_case_files import VARIABLE, use_case_folder, use_case_for

# How the policies are called; the first is that of the table of faults.
TABLE, RETRY = "table", "retry three times"
PLAIN_RETRY = [{"do": "retry", "times": 3}, {"do": "set_aside"}]

# [s] wall time that the nodes get to come up, and that a run gets to stop.
_START_LIMIT_S, _STOP_LIMIT_S = 120.0, 60.0

# How many runs without a fault are compared with.
_PLAIN = 5


class Campaign:
    """Runs trials on one cell, one after another."""

    def __init__(self, site: Site, nodes: Stack, tables: Tables) -> None:
        """Connect to the nodes that run.

        Args:
            site: the cell.
            nodes: that run.
            tables: see Tables.
        """
        self._site = site
        self._output = nodes.output
        self._tables = tables
        self._url = nodes.database
        self._log = RunLog(ProductionDatabase(self._url))
        site.connect(nodes, self._log)
        self._server = ActionServer("remodel/run_use_case", RunUseCaseAction, "the supervisor")
        self._server.wait(_START_LIMIT_S)

    def use(self, policy: str) -> None:
        """Have the runs from now on follow a policy."""
        use_case = self._tables.use_case
        responses = dict.fromkeys(self._tables.faults, PLAIN_RETRY) if policy == RETRY else {}
        content = {**use_case, "recovery": {"responses": responses}}
        own = self._output / "use_cases" / f"{use_case['name']}.yaml"
        own.write_text(yaml.safe_dump(content), encoding="utf-8")

    def tried(self, trial: Trial) -> Verdict:
        """Do a trial, and return what became of it."""
        self._site.arm(trial)
        began = time.monotonic()
        goal = self._server.send(
            RunUseCaseGoal(id=uuid.uuid4().hex, order=ORDER, tasks=BY_HAND + WIRES, again=True)
        )
        hung = not goal.wait(self._site.limit_s)
        wall_s = time.monotonic() - began
        if hung:
            goal.cancel()
            if not goal.wait(_STOP_LIMIT_S):
                raise SystemExit("campaign: the supervisor does not stop; see nodes.log")
        if not goal.result or not goal.result.run:
            raise SystemExit(f"campaign: no run began: {goal.ending}")
        return self._judged(trial, goal.result.run, wall_s, hung=hung)

    def _judged(self, trial: Trial, run: int, wall_s: float, *, hung: bool) -> Verdict:
        events = [kept.event for kept in self._log.events(run)]
        tasks = state_after(events).tasks
        done = {name for name, task in tasks.items() if task.stage is Stage.DONE}
        words = [str(run), "--database", self._url]
        played = printed(replay.main, [*words, "--quiet"])
        return Verdict(
            run,
            struck=self._site.has_struck(trial),
            hung=hung,
            complete=is_complete(events),
            true=done == self._site.placed(tasks),
            hand_empty=self._site.hand_is_empty() or needs_person(events),
            first=self._first(trial, events),
            cell_s=self._site.cell_s(events),
            wall_s=wall_s,
            explained=is_explained(events, printed(explain_run.main, words)),
            replayed=played.endswith(" 0 differences\n"),
        )

    def _first(self, trial: Trial, events: Sequence[Event]) -> str:
        if "after" in self._tables.faults.get(trial.kind, {}):
            # A fault that shows only in a row of failures is handled when it is known.
            return decided_first(events, trial.kind)
        return handled_first(events, {self._tables.codes[name] for name in trial.codes})


class Tables:
    """What the campaign reads.

    Attributes:
        faults: rows of faults.yaml of abilities that the use case asks for, by name.
        codes: names of error codes -> numbers.
        use_case: the document of the use case.
        durations_s: [s] ability -> what the use case says that it takes.
        inspection_s: [s] of an inspection: as long as locating a component.
    """

    def __init__(self) -> None:
        tables = read_faults()
        self.codes = tables.numbers
        self.use_case = _yaml(use_case_folder() / f"{use_case_for(DesignKind.CABINET).name}.yaml")
        stated = self.use_case["abilities"]
        self.faults = {
            name: row
            for name, row in tables.faults.items()
            if row["cause"]["interface"]["ability"] in stated
        }
        self.durations_s = {name: float(row["duration_s"]) for name, row in stated.items()}
        self.inspection_s = self.durations_s["LocateGearboxComponent"]


def printed(command: Callable[[list[str]], int], words: list[str]) -> str:
    """Return what a command prints."""
    with contextlib.redirect_stdout(io.StringIO()) as text:
        command(words)
    return text.getvalue()


def _yaml(file: Path) -> Any:  # noqa: ANN401 - any document
    return yaml.safe_load(file.read_text(encoding="utf-8"))


def ends_of_runs(database: str, use_case: Mapping[str, Any]) -> tuple[TerminalRef, ...]:
    """Return the terminals of the wires that the robots place."""
    wires = ProductionDatabase(database).order(ORDER).in_cabinet().wires[: BY_HAND + WIRES]
    thickest_mm2 = use_case["characteristics"]["task"]["section_mm2"]["at_most"]
    placed = [wire for wire in wires if wire.section_mm2 <= thickest_mm2]
    return tuple(end for wire in placed for end in (wire.a, wire.b))


def main() -> int:
    """Run the campaign and print its table; return the exit code."""
    tables = Tables()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kinds", nargs="+", choices=[*tables.faults, *PHYSICAL_KINDS])
    parser.add_argument("--runs", type=int, default=20, help="of each kind and policy (default 20)")
    parser.add_argument("--seed", type=int, default=0, help="of the first run (default 0)")
    parser.add_argument("--policies", nargs="+", choices=(TABLE, RETRY), default=(TABLE, RETRY))
    parser.add_argument("--physical", action="store_true", help="in the simulated cell")
    parser.add_argument("--explore", action="store_true", help="runs choose forces and responses")
    parser.add_argument("--output", type=Path, default=Path("out/campaign"))
    add_figures_option(parser)
    options = parser.parse_args()
    kinds = options.kinds or list(PHYSICAL_KINDS if options.physical else tables.faults)
    known = PHYSICAL_KINDS if options.physical else tables.faults
    if strange := [kind for kind in kinds if kind not in known]:
        parser.error(f"--kinds {strange[0]}: here there are {', '.join(known)}")
    for number in (signal.SIGINT, signal.SIGTERM):  # either ends the nodes and shows what is done
        signal.signal(number, signal.default_int_handler)
    output = options.output.resolve()
    shutil.rmtree(output, ignore_errors=True)
    seeds = range(options.seed, options.seed + options.runs)
    fake = FakeSite(tables.durations_s, tables.inspection_s)
    site: Site = SimulatedSite() if options.physical else fake
    os.environ[VARIABLE] = str(output / "use_cases")
    supervisor = "--explore" if options.explore else ""
    with stack(site.launch, output, options=supervisor, **site.arguments(output)) as nodes:
        (output / "use_cases").mkdir()
        nodes.wait_for(*site.nodes)
        rospy.init_node("campaign", disable_signals=True)
        trials = [Trial("", seed) for seed in seeds[:_PLAIN]]
        if options.physical:
            ends = ends_of_runs(nodes.database, tables.use_case)
            trials += [drawn_physical(kind, seed, ends) for seed in seeds for kind in kinds]
        else:
            trials += [drawn(tables.faults[kind], seed) for seed in seeds for kind in kinds]
        results = run_all(Campaign(site, nodes, tables), trials, options.policies, output)
        rospy.signal_shutdown("the campaign is over")
    write_figures(options.figures, docs_rows(results))
    return 0 if print_table(results) else 1


def run_all(
    campaign: Campaign, trials: Sequence[Trial], policies: Sequence[str], output: Path
) -> dict[str, list[tuple[Trial, Verdict]]]:
    """Do all trials by each policy, or until a signal; write a line of JSON when one has ended."""
    results: dict[str, list[tuple[Trial, Verdict]]] = {policy: [] for policy in policies}
    total = len(policies) * len(trials)
    with (
        (output / "trials.jsonl").open("w") as lines,
        tqdm(total=total, unit="run") as bar,
        contextlib.suppress(KeyboardInterrupt),
    ):
        for policy in policies:
            campaign.use(policy)
            for trial in trials:
                bar.set_postfix_str(f"{policy}, {trial.kind or 'no fault'}")
                verdict = campaign.tried(trial)
                results[policy].append((trial, verdict))
                row = {"policy": policy, **asdict(trial), **asdict(verdict)}
                lines.write(json.dumps(row) + "\n")
                lines.flush()
                bar.update()
    return results


# The two cells that the campaign runs on: how a fault is caused there, and what is true there


HERE = Path(__file__).parent

# How much faster than the wall's the time of the fake cell passes.
_SPEED = 10.0

# [s] wall time between two checks whether a run has begun its first task.
_CHECK_S = 0.1


class Site(Protocol):
    """A cell.

    Attributes:
        launch: file that starts it, and all above it.
        nodes: that must be there.
        limit_s: [s] wall time after which a run counts as hung.
    """

    launch: Path
    nodes: tuple[str, ...]
    limit_s: float

    def arguments(self, output: Path) -> dict[str, object]:
        """Return arguments of the launch file, beside output and database."""

    def connect(self, nodes: Stack, log: RunLog) -> None:
        """Take the nodes that run, and the log of their runs."""

    def arm(self, trial: Trial) -> None:
        """See to it that the fault of a trial strikes in the run that begins next."""

    def has_struck(self, trial: Trial) -> bool:
        """Return whether it has."""

    def placed(self, wires: Collection[str]) -> set[str]:
        """Return which wires are where they belong."""

    def hand_is_empty(self) -> bool:
        """Return whether nothing is left in the hand, as far as the cell reports it."""

    def cell_s(self, events: Sequence[Event]) -> float:
        """Return how long a run takes in a cell [s], without what stands above it."""


class FakeSite:
    """The fake cell: faults at its interface, as quick as the processes above it allow."""

    launch = HERE / "campaign.launch"
    nodes = ("fake_cell", "picker", "use_case_supervisor", "behavior_action_server")
    limit_s = 120.0

    def __init__(self, durations_s: Mapping[str, float], inspection_s: float) -> None:
        """Take how long operations, by ability, and an inspection take in a true cell [s]."""
        self._durations_s = durations_s
        self._inspection_s = inspection_s

    def arguments(self, output: Path) -> dict[str, object]:
        """Return the file of the world."""
        return {"world": output / "world.sqlite"}

    def connect(self, nodes: Stack, _: RunLog) -> None:
        """Be the clock."""
        FastClock(_SPEED)
        self._world = WorldFile(nodes.output / "world.sqlite")

    def arm(self, trial: Trial) -> None:
        """Set the cell's faults, which it reads when the panel is loaded."""
        rospy.set_param("fake_cell/faults", list(trial.faults))

    def has_struck(self, trial: Trial) -> bool:
        """Return whether a goal was struck."""
        return any(f.struck for f in self._world.read().faults if f.name == trial.kind)

    def placed(self, wires: Collection[str]) -> set[str]:
        """Return which wires are fixed at both ends."""
        world = self._world.read().world
        return {name for name in wires if world.is_placed(name)}

    def hand_is_empty(self) -> bool:
        """Return whether nothing is held."""
        return not any(hands.held for hands in self._world.read().world.hands.values())

    def cell_s(self, events: Sequence[Event]) -> float:
        """Return what the operations would take in a true cell."""
        return cell_s(events, self._durations_s, self._inspection_s)


class SimulatedSite:
    """The PyBullet cell: faults by their physical causes, once the first wire of a run is fed."""

    launch = HERE.parents[1] / "src" / "remodel_planner" / "launch" / "order.launch"
    nodes = ("cell", "use_case_supervisor", "behavior_action_server")
    limit_s = 1800.0

    def arguments(self, _: Path) -> dict[str, object]:
        """Return none."""
        return {}

    def connect(self, _: Stack, log: RunLog) -> None:
        """Take the log, which shows when a run has begun."""
        self._log = log
        self._cell = Cell()
        self._struck = threading.Event()
        self._armed = threading.Event()

    def arm(self, trial: Trial) -> None:
        """Begin to wait for the run's first behavior; its wire is fed by then."""
        self._armed.clear()  # the waiting of the trial before is over
        self._struck, self._armed = threading.Event(), threading.Event()
        self._armed.set()
        if trial.kind:
            arguments = (trial, self._struck, self._armed)
            threading.Thread(target=self._strike, args=arguments, daemon=True).start()

    def has_struck(self, _: Trial) -> bool:
        """Return whether the cell has caused it."""
        return self._struck.is_set()

    def placed(self, wires: Collection[str]) -> set[str]:
        """Return which wires are fixed where they belong, by the cell's ground truth."""
        return {name for name in wires if self._cell.placed(name)}

    def hand_is_empty(self) -> bool:
        """Return true: the cell does not report what it holds."""
        return True

    def cell_s(self, events: Sequence[Event]) -> float:
        """Return the simulated time of all behaviors."""
        return state_after(events).cell_s

    def _strike(self, trial: Trial, struck: threading.Event, armed: threading.Event) -> None:
        fault = trial.faults[0]
        never = threading.Event()
        while armed.is_set() and not rospy.is_shutdown():
            run = self._log.unfinished("cell")
            begun = run is not None and any(
                isinstance(kept.event, TaskBegun) for kept in self._log.events(run)
            )
            if begun:
                inject = rospy.ServiceProxy("cell/inject_fault", InjectFault)
                answer = inject(fault["kind"], fault["target"], fault["values"])
                if not answer.success:
                    rospy.logerr("fault %s: %s", fault, answer.message)
                elif armed.is_set():
                    struck.set()
                return
            never.wait(_CHECK_S)


# ROS time that is faster than the wall's: no one waits long for a server that hangs


# [s] wall time between two messages.
_EVERY_S = 0.02


class FastClock:
    """Publishes /clock until the process ends."""

    def __init__(self, speed: float) -> None:
        self._speed = speed
        self._publisher = rospy.Publisher("/clock", Clock, queue_size=1)
        self._begun = time.monotonic()
        threading.Thread(target=self._tick, name="clock", daemon=True).start()

    def _tick(self) -> None:
        while not rospy.is_shutdown():
            now_s = 1.0 + self._speed * (time.monotonic() - self._begun)
            with contextlib.suppress(rospy.ROSException):  # at shutdown topics are closed
                self._publisher.publish(Clock(rospy.Time.from_sec(now_s)))
            time.sleep(_EVERY_S)


if __name__ == "__main__":
    sys.exit(main())
