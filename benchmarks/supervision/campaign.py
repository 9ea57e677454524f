#!/usr/bin/env python3
"""Cause every kind of fault, and see whether the levels recover, end, and say why.

campaign.py [--kinds KIND ...] [--runs 20] [--seed 0] [--policies ...] [--output out/campaign]
[--figures FILE]; the workspace must be sourced. Each run places two wires of a real cabinet's
design with one fault of remodel_msgs/config/faults.yaml, caused at the interface of a fake cell;
once by the policy of the table of faults, once by "retry three times". Every run uses the forces of
the use case and the responses of its policy, so that runs can be compared; durations and successes
are learned all the same, and decide the order of tasks. A line of JSON for each run stands in
trials.jsonl when it has ended. Exits with 1 when a target is missed.
"""
# ruff: noqa: T201 - a benchmark prints

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
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from random import Random
from statistics import median
from typing import Any

import rospy
import yaml

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_planner/test/rostest"))
from figures import add_figures_option, report_table
from order_client import OrderClient
from rosgraph_msgs.msg import Clock
from stack import Stack, stack

from remodel_planner.commands import explain
from remodel_planner.commands.runs import replay
from remodel_states.edge.exported_tables import read_faults
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import (
    Ending,
    Event,
    OperationEnded,
    RunEnded,
    Settled,
)
from remodel_supervision.core.runs.state import PERSON_FIRST, Stage
from remodel_tasks.core.use_case.model import DesignKind
from remodel_tasks.edge.use_case_files import VARIABLE, use_case_folder, use_case_for

# How the policies are called; the first is that of the table of faults.
TABLE, RETRY = "table", "retry three times"
PLAIN_RETRY = [{"do": "retry", "times": 3}, {"do": "set_aside"}]
NODES = ("fake_cell", "picker", "use_case_supervisor", "behavior_action_server")

# How often an ability is asked for in a wire that goes well.
GOALS_OF_A_WIRE = {
    "DetectCable": 1,
    "LocateGearboxComponent": 2,
    "InsertCable": 2,
    "FixCable": 2,
    "PickCable": 2,
    "LayWire": 1,
}
# Wires that robots place, and how many of the first wires of the order are too thick for them.
WIRES, BY_HAND = 2, 3
# How many runs without a fault are compared with; [%] that is to recover.
PLAIN, LEAST_RECOVERED = 5, 95.0

# Responses that the fake cell knows as cures, beside an operator's, who is absent here.
CURES = ("retry", "retry_with", "look_again", "new_part", "replan")
OPERATOR, OPERATOR_SHARE = "ask_operator", 0.1

# remodel_msgs/ErrorCode SERVER_HUNG and TIMEOUT: such a goal took as long as it was waited for.
WAITED_FOR = (1, 7)

# [s] wall time after which a run counts as hung; how much faster than the wall's ROS time passes,
# so that no one waits long for a server that hangs.
HUNG_S, SPEED = 120.0, 10.0


@dataclass(frozen=True)
class Trial:
    """One run.

    Attributes:
        kind: name of the fault; empty: nothing goes wrong.
        seed: of what was drawn.
        cure: response that cures it; empty: none does.
        fault: parameters of the fake cell; empty: nothing goes wrong.
    """

    kind: str
    seed: int
    cure: str
    fault: dict[str, Any]

    @property
    def can_recover(self) -> bool:
        """Whether something that can be done without a person cures it."""
        return self.cure not in ("", OPERATOR)


@dataclass(frozen=True)
class Verdict:
    """What became of a run.

    Attributes:
        run: its number.
        wrong: what is not as it should be, in words, beside that it may not be complete.
        complete: whether all is done, by its report and by the cell's world.
        cell_s: [s] that its operations take in the cell.
        wall_s: [s] wall time.
    """

    run: int
    wrong: tuple[str, ...]
    complete: bool
    cell_s: float
    wall_s: float


Results = Sequence[tuple[Trial, Verdict]]


class Tables:
    """What the campaign reads.

    Attributes:
        faults: rows of faults.yaml of abilities that the use case asks for, by name.
        use_case: the document of the use case.
        durations_s: [s] ability -> what the use case says that it takes.
    """

    def __init__(self) -> None:
        file = use_case_folder() / f"{use_case_for(DesignKind.CABINET).name}.yaml"
        self.use_case = yaml.safe_load(file.read_text(encoding="utf-8"))
        stated = self.use_case["abilities"]
        self.faults = {
            name: row
            for name, row in read_faults().faults.items()
            if row["cause"]["interface"]["ability"] in stated
        }
        self.durations_s = {name: float(row["duration_s"]) for name, row in stated.items()}


def drawn(row: Mapping[str, Any], seed: int) -> Trial:
    """Return a trial of a fault of the table.

    A cure is drawn from the responses that the table lists for the fault; one fault in ten, of
    those for which an operator is asked in the end, has no other cure. A fault that action
    or behavior handle first may also pass by itself.
    """
    kind, ability = row["fault"], row["cause"]["interface"]["ability"]
    random = Random(f"{kind} {seed}")
    times = {response["do"]: response.get("times", 1) for response in row["responses"]}
    if row["first_level"] in ("action", "behavior"):
        times.setdefault("retry", 2)
    cures = [do for do in times if do in CURES]
    if "after" in row:  # what a behavior does by itself would end it before it shows
        cures = [do for do in cures if do not in ("retry", "look_again")]
    cure = random.choice(cures) if cures else ""
    if OPERATOR in times and random.random() < OPERATOR_SHARE:
        cure = OPERATOR
    goals = GOALS_OF_A_WIRE.get(ability, 1)
    # There must be another wire left for the plan to change.
    nth = random.randint(1, goals if cure == "replan" else WIRES * goals)
    fault: dict[str, Any] = {"name": kind, "cure": cure or OPERATOR, "nth": nth}
    if cure == "retry":
        fault["times"] = random.randint(1, times["retry"])
    if cure == "retry_with":
        fault["at_least"] = random.uniform(15.0, 20.0)  # what 14 N and two changes reach
    return Trial(kind, seed, cure, fault)


class Campaign:
    """Runs trials on one fake cell, one after another, and is its clock."""

    def __init__(self, nodes: Stack, tables: Tables) -> None:
        self._output, self._tables, self._url = nodes.output, tables, nodes.database
        clock, begun = rospy.Publisher("/clock", Clock, queue_size=1), time.monotonic()

        def tick() -> None:
            while not rospy.is_shutdown():
                now_s = 1.0 + SPEED * (time.monotonic() - begun)
                with contextlib.suppress(rospy.ROSException):  # at shutdown topics are closed
                    clock.publish(Clock(rospy.Time.from_sec(now_s)))
                time.sleep(0.02)

        threading.Thread(target=tick, name="clock", daemon=True).start()
        self._orders = OrderClient(nodes.output)

    def use(self, policy: str) -> None:
        """Have the runs from now on follow a policy."""
        responses = dict.fromkeys(self._tables.faults, PLAIN_RETRY) if policy == RETRY else {}
        content = {**self._tables.use_case, "recovery": {"responses": responses}}
        file = self._output / "use_cases" / f"{content['name']}.yaml"
        file.write_text(yaml.safe_dump(content), encoding="utf-8")

    def tried(self, trial: Trial) -> Verdict:
        """Do a trial, and return what became of it."""
        # The cell reads its faults when the panel is loaded.
        rospy.set_param("fake_cell/faults", [trial.fault] if trial.fault else [])
        began, is_hung = time.monotonic(), False
        run = self._orders.start(BY_HAND + WIRES)
        try:
            self._orders.wait_for_end(run, HUNG_S)
        except AssertionError:
            is_hung = True
            self._orders.require("stop")
            self._orders.wait_for_end(run, HUNG_S)
        return self._judged(trial, run, time.monotonic() - began, is_hung=is_hung)

    def _judged(self, trial: Trial, run: int, wall_s: float, *, is_hung: bool) -> Verdict:
        events = self._orders.events(run)
        tasks = state_after(events).tasks
        done = {name for name, task in tasks.items() if task.stage is Stage.DONE}
        found = self._orders.world.read()
        placed = {name for name in tasks if found.world.is_placed(name)}
        words = [str(run), "--database", self._url]
        explanation = printed(explain.main, words)
        played = printed(replay.main, [*words, "--quiet"])
        wrong = {
            "hung": is_hung,
            "what it says of the wires is not true": done != placed,
            "the hand is not empty": bool(self._orders.held) and not needs_person(events),
            "not explained": not is_explained(events, explanation),
            "not replayed": not played.endswith(" 0 differences\n"),
            "the fault has not shown": bool(trial.kind)
            and not any(fault.struck for fault in found.faults if fault.name == trial.kind),
        }
        last = events[-1]
        is_complete = isinstance(last, RunEnded) and last.ending is Ending.COMPLETE
        return Verdict(
            run,
            tuple(what for what, is_so in wrong.items() if is_so),
            is_complete and done == placed,
            cell_s(events, self._tables.durations_s),
            wall_s,
        )


def printed(command: Callable[[list[str]], int], words: list[str]) -> str:
    """Return what a command prints."""
    with contextlib.redirect_stdout(io.StringIO()) as text:
        command(words)
    return text.getvalue()


def needs_person(events: Sequence[Event]) -> bool:
    """Return whether nothing may move, not even to empty the hand, before a person answers."""
    last = next((e.operation for e in reversed(events) if isinstance(e, OperationEnded)), None)
    return last is not None and last.error_code in PERSON_FIRST


def is_explained(events: Sequence[Event], explanation: str) -> bool:
    """Return whether a run's explanation has each failed operation, and how the run ended."""
    operations = [event.operation for event in events if isinstance(event, OperationEnded)]
    failures = (f"error {each.error_code}: {each.text}" for each in operations if each.error_code)
    return all(line in explanation for line in failures) and "\nended " in explanation


def cell_s(events: Sequence[Event], durations_s: Mapping[str, float]) -> float:
    """Return how long the operations of a run take in the cell [s], by ability.

    An inspection takes as long as locating a component.
    """

    def took_s(operation: Operation) -> float:
        usual_s = durations_s.get(operation.ability, 0.0)
        is_waited = operation.error_code in WAITED_FOR
        return max(usual_s, operation.elapsed_s) if is_waited else usual_s

    inspections = sum(isinstance(event, Settled) for event in events)
    operations = (event.operation for event in events if isinstance(event, OperationEnded))
    return sum(map(took_s, operations)) + inspections * durations_s["LocateGearboxComponent"]


def rows(results: Mapping[str, Results]) -> Iterator[dict[str, str]]:
    """Yield the rows of the docs' table: a kind of fault each, then all; the first policy fully."""
    (policy, done), *others = results.items()
    plain = [verdict for trial, verdict in done if not trial.kind]
    kinds = dict.fromkeys(trial.kind for trial, _ in done if trial.kind)
    for kind in (*kinds, ""):
        own = _of_kind(done, kind)
        recovered = [v for t, v in own if t.can_recover and v.complete]
        row = {
            "kind": kind or "all",
            f"{policy}: recovered": _recovered(own),
            "extra cell": _more([v.cell_s for v in recovered], [v.cell_s for v in plain]),
            "extra wall": _more([v.wall_s for v in recovered], [v.wall_s for v in plain]),
            "ended well": f"{sum(not v.wrong for _, v in own)} of {len(own)}",
        }
        for other, tried in others:
            row[f"{other}: recovered"] = _recovered(_of_kind(tried, kind))
        yield row


def _of_kind(done: Results, kind: str = "") -> Results:
    return [(t, v) for t, v in done if t.kind and kind in ("", t.kind)]


def _recovered(done: Results) -> str:
    can = [verdict.complete for trial, verdict in done if trial.can_recover]
    return f"{sum(can)} of {len(can)}" if can else "cannot"


def _more(with_fault: Sequence[float], without: Sequence[float]) -> str:
    """Return by how many seconds the median run with a fault is longer."""
    if not with_fault or not without:
        return "-"
    return f"{median(with_fault) - median(without):+.1f} s"


def run_all(
    campaign: Campaign, trials: Sequence[Trial], policies: Sequence[str], output: Path
) -> dict[str, list[tuple[Trial, Verdict]]]:
    """Do all trials by each policy, or until a signal; write a line of JSON when one has ended."""
    results: dict[str, list[tuple[Trial, Verdict]]] = {policy: [] for policy in policies}
    with (output / "trials.jsonl").open("w") as lines, contextlib.suppress(KeyboardInterrupt):
        for policy in policies:
            campaign.use(policy)
            for number, trial in enumerate(trials, start=1):
                verdict = campaign.tried(trial)
                results[policy].append((trial, verdict))
                row = {"policy": policy, **asdict(trial), **asdict(verdict)}
                lines.write(json.dumps(row) + "\n")
                lines.flush()
                found = ", ".join(("complete" if verdict.complete else "not done", *verdict.wrong))
                what = f"{trial.kind or 'no fault'}, cure {trial.cure or 'none'}"
                print(f"{policy} {number}/{len(trials)}: {what}: {found}", flush=True)
    return results


def main() -> int:
    """Run the campaign and print its table; return the exit code."""
    tables = Tables()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kinds", nargs="+", choices=tables.faults, default=list(tables.faults))
    parser.add_argument("--runs", type=int, default=20, help="of each kind and policy (default 20)")
    parser.add_argument("--seed", type=int, default=0, help="of the first run (default 0)")
    parser.add_argument("--policies", nargs="+", choices=(TABLE, RETRY), default=(TABLE, RETRY))
    parser.add_argument("--output", type=Path, default=Path("out/campaign"))
    add_figures_option(parser)
    options = parser.parse_args()
    for number in (signal.SIGINT, signal.SIGTERM):  # either ends the nodes and shows what is done
        signal.signal(number, signal.default_int_handler)
    output = options.output.resolve()
    shutil.rmtree(output, ignore_errors=True)
    os.environ[VARIABLE] = str(output / "use_cases")
    seeds = range(options.seed, options.seed + options.runs)
    trials = [Trial("", seed, "", {}) for seed in seeds[:PLAIN]]
    trials += [drawn(tables.faults[kind], seed) for seed in seeds for kind in options.kinds]
    with stack(Path(__file__).with_name("campaign.launch"), output) as nodes:
        (output / "use_cases").mkdir()
        nodes.wait_for(*NODES)
        rospy.init_node("campaign", disable_signals=True)
        results = run_all(Campaign(nodes, tables), trials, options.policies, output)
        rospy.signal_shutdown("the campaign is over")
    report_table(rows(results), options.figures)
    first = _of_kind(results[options.policies[0]])
    can = [verdict.complete for trial, verdict in first if trial.can_recover]
    is_met = 100 * sum(can) >= LEAST_RECOVERED * len(can)
    return 0 if is_met and not any(verdict.wrong for _, verdict in first) else 1


if __name__ == "__main__":
    sys.exit(main())
