#!/usr/bin/env python3
"""Cause every kind of fault, and see whether the levels recover, end, and say why.

campaign.py [--kinds KIND ...] [--runs 20] [--seed 0] [--output out/campaign]; the workspace must be
sourced. Each run places two wires of a real cabinet's design with one fault of
remodel_msgs/config/faults.yaml, caused at the interface of a fake cell; once by the policy of the
table of faults, once by "retry three times". A line of JSON for each run stands in trials.jsonl
when it has ended. Exits with 1 when a target is missed.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import os
import shutil
import sys
import time
import uuid
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import rospy
import yaml
from fast_clock import FastClock
from remodel_msgs.msg import RunUseCaseAction, RunUseCaseGoal
from rospkg import RosPack
from stack import ORDER, stack
from table import told
from tqdm import tqdm
from trial import WIRES, Trial, drawn
from verdict import Verdict, cell_s, decided_first, handled_first, is_complete

from remodel_planner.commands import explain_run, replay
from remodel_planner.core.supervision.events import Event
from remodel_planner.core.supervision.state import Stage, state_after
from remodel_planner.edge.package_files import use_case_folder
from remodel_planner.edge.production_database import ProductionDatabase
from remodel_planner.edge.run_log import RunLog
from remodel_planner.edge.use_case_files import VARIABLE
from remodel_planner.ros.action_server import ActionServer
from remodel_states.testing.world_file import WorldFile

HERE = Path(__file__).parent

# How the policies are called; the first is that of the table of faults.
TABLE, RETRY = "table", "retry three times"
PLAIN_RETRY = [{"do": "retry", "times": 3}, {"do": "set_aside"}]

# [s] wall time that the nodes get to come up; that a run may take; and that it gets to stop.
_START_LIMIT_S, _RUN_LIMIT_S, _STOP_LIMIT_S = 120.0, 120.0, 40.0

# How much faster than the wall's the ROS time passes.
_SPEED = 10.0


class Campaign:
    """Runs trials on one cell, one after another."""

    def __init__(self, output: Path, database: str, tables: Tables) -> None:
        """Connect to the nodes that run.

        Args:
            output: folder of world and use cases.
            database: its URL.
            tables: see Tables.
        """
        self._output = output
        self._tables = tables
        self._url = database
        self._log = RunLog(ProductionDatabase(self._url))
        self._world = WorldFile(output / "world.sqlite")
        self._server = ActionServer("remodel/run_use_case", RunUseCaseAction, "the supervisor")
        self._server.wait(_START_LIMIT_S)

    def use(self, policy: str) -> None:
        """Have the runs from now on follow a policy."""
        own = self._output / "use_cases" / "switchgear.yaml"
        if policy == TABLE:
            own.unlink(missing_ok=True)
            return
        responses = dict.fromkeys(self._tables.faults, PLAIN_RETRY)
        content = {**self._tables.use_case, "recovery": {"responses": responses}}
        own.write_text(yaml.safe_dump(content), encoding="utf-8")

    def tried(self, trial: Trial) -> Verdict:
        """Do a trial, and return what became of it."""
        rospy.set_param("fake_cell/faults", list(trial.faults))
        began = time.monotonic()
        goal = self._server.send(
            RunUseCaseGoal(id=uuid.uuid4().hex, order=ORDER, tasks=WIRES, again=True)
        )
        hung = not goal.wait(_RUN_LIMIT_S)
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
        draft = self._world.read()
        codes = {self._tables.codes[name] for name in trial.codes}
        story = printed(explain_run.main, [str(run), "--database", self._url])
        explained = " ended " in story.replace("\n", " ") and (
            not trial.kind or any(f"error {code}:" in story for code in codes)
        )
        return Verdict(
            run,
            struck=any(f.struck for f in draft.faults if f.name == trial.kind),
            hung=hung,
            complete=is_complete(events),
            true=is_true(events, draft.world),
            hand_empty=not any(hand.held for hand in draft.world.hands.values()),
            # A fault that shows only in a row of failures is handled when it is known.
            first=decided_first(events, trial.kind)
            if "after" in self._tables.faults.get(trial.kind, {})
            else handled_first(events, codes),
            cell_s=cell_s(events, self._tables.durations_s, self._tables.look_s),
            wall_s=wall_s,
            explained=explained,
            replayed=bool(
                printed(replay.main, [str(run), "--quiet", "--database", self._url]).endswith(
                    " 0 differences\n"
                )
            ),
        )


class Tables:
    """What the campaign reads.

    Attributes:
        faults: rows of faults.yaml, by name.
        codes: names of error codes -> numbers.
        use_case: the document of the use case.
        durations_s: [s] ability -> what the use case says that it takes.
        look_s: [s] of a look what is done: as long as one at a component.
    """

    def __init__(self) -> None:
        """Read them."""
        config = Path(RosPack().get_path("remodel_msgs")) / "config"
        self.faults = {row["fault"]: row for row in _yaml(config / "faults.yaml")}
        self.codes = {row["name"]: row["code"] for row in _yaml(config / "error_codes.yaml")}
        self.use_case = _yaml(use_case_folder() / "switchgear.yaml")
        stated = self.use_case["abilities"]
        self.durations_s = {name: float(row["duration_s"]) for name, row in stated.items()}
        self.durations_s["ExtractCable"] = float(self.use_case["cell"]["extract_s"])
        self.look_s = self.durations_s["LocateGearboxComponent"]


def is_true(events: Sequence[Event], world: Any) -> bool:  # noqa: ANN401
    """Return whether the wires that a run calls done are those that sit in their terminals."""
    tasks = state_after(events).tasks
    done = {name for name, task in tasks.items() if task.stage is Stage.DONE}
    return done == {name for name in tasks if world.is_placed(name)}


def printed(command: Any, words: list[str]) -> str:  # noqa: ANN401
    """Return what a command prints."""
    with contextlib.redirect_stdout(io.StringIO()) as text:
        command(words)
    return text.getvalue()


def _yaml(file: Path) -> Any:  # noqa: ANN401
    return yaml.safe_load(file.read_text(encoding="utf-8"))


def main() -> int:
    """Run the campaign and print its table; return the exit code."""
    tables = Tables()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kinds", nargs="+", choices=tables.faults, default=list(tables.faults))
    parser.add_argument("--runs", type=int, default=20, help="of each kind and policy (default 20)")
    parser.add_argument("--seed", type=int, default=0, help="of the first run (default 0)")
    parser.add_argument("--policies", nargs="+", choices=(TABLE, RETRY), default=(TABLE, RETRY))
    parser.add_argument("--output", type=Path, default=Path("out/campaign"))
    options = parser.parse_args()
    output = options.output.resolve()
    shutil.rmtree(output, ignore_errors=True)
    seeds = range(options.seed, options.seed + options.runs)
    plain = [Trial("", seed) for seed in range(options.seed - 5, options.seed)]
    trials = plain + [drawn(tables.faults[kind], seed) for kind in options.kinds for seed in seeds]
    results: dict[str, list[tuple[Trial, Verdict]]] = {}
    os.environ[VARIABLE] = str(output / "use_cases")
    with stack(HERE / "campaign.launch", output, world=output / "world.sqlite") as nodes:
        (output / "use_cases").mkdir()
        nodes.wait_for("fake_cell", "picker", "use_case_supervisor", "behavior_action_server")
        rospy.init_node("campaign", disable_signals=True)
        FastClock(_SPEED)
        campaign = Campaign(output, nodes.database, tables)
        total = len(options.policies) * len(trials)
        with (output / "trials.jsonl").open("w") as lines, tqdm(total=total, unit="run") as bar:
            for policy in options.policies:
                campaign.use(policy)
                for trial in trials:
                    bar.set_postfix_str(f"{policy}, {trial.kind or 'no fault'}")
                    verdict = campaign.tried(trial)
                    results.setdefault(policy, []).append((trial, verdict))
                    row = {"policy": policy, **asdict(trial), **asdict(verdict)}
                    lines.write(json.dumps(row) + "\n")
                    lines.flush()
                    bar.update()
        rospy.signal_shutdown("the campaign is over")
    return 0 if told(results) else 1


if __name__ == "__main__":
    sys.exit(main())
