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
import time
import uuid
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import figures
import physical
import rospy
import yaml
from remodel_msgs.msg import RunUseCaseAction, RunUseCaseGoal
from sites import FakeSite, SimulatedSite, Site
from stack import ORDER, Stack, stack
from table import docs_rows, print_table
from tqdm import tqdm
from trial import BY_HAND, WIRES, Trial, drawn
from verdict import (
    Verdict,
    decided_first,
    handled_first,
    is_complete,
    is_explained,
    needs_person,
)

from remodel_planner.commands.runs import explain_run, replay
from remodel_planning.core.use_case.designs import DesignKind
from remodel_planning.edge.use_case_files import VARIABLE, use_case_folder, use_case_for
from remodel_production.core.production import TerminalRef
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_states.edge.exported_tables import read_faults
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import Event
from remodel_supervision.core.runs.state import Stage
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.ros.action_server import ActionServer

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
        """Read them."""
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
    parser.add_argument("--kinds", nargs="+", choices=[*tables.faults, *physical.KINDS])
    parser.add_argument("--runs", type=int, default=20, help="of each kind and policy (default 20)")
    parser.add_argument("--seed", type=int, default=0, help="of the first run (default 0)")
    parser.add_argument("--policies", nargs="+", choices=(TABLE, RETRY), default=(TABLE, RETRY))
    parser.add_argument("--physical", action="store_true", help="in the simulated cell")
    parser.add_argument("--explore", action="store_true", help="runs choose forces and responses")
    parser.add_argument("--output", type=Path, default=Path("out/campaign"))
    figures.add_option(parser)
    options = parser.parse_args()
    kinds = options.kinds or list(physical.KINDS if options.physical else tables.faults)
    known = physical.KINDS if options.physical else tables.faults
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
            trials += [physical.drawn(kind, seed, ends) for seed in seeds for kind in kinds]
        else:
            trials += [drawn(tables.faults[kind], seed) for seed in seeds for kind in kinds]
        results = run_all(Campaign(site, nodes, tables), trials, options.policies, output)
        rospy.signal_shutdown("the campaign is over")
    figures.write(options.figures, docs_rows(results))
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


if __name__ == "__main__":
    sys.exit(main())
