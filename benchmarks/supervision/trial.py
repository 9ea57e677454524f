# ruff: noqa: T201 - a benchmark prints
"""What goes wrong in one run of the campaign, drawn from a seed, and what became of it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from random import Random
from statistics import median
from typing import Any

from remodel_production.core.production import TerminalRef
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import (
    Decided,
    Ending,
    Event,
    OperationEnded,
    RunEnded,
    Settled,
    TaskEnded,
)
from remodel_supervision.core.runs.state import PERSON_FIRST
from remodel_tasks.core.use_case.fault import Do

# How often an ability is asked for in a wire that goes well.
GOALS_OF_A_WIRE = {
    "DetectCable": 1,
    "LocateGearboxComponent": 2,
    "InsertCable": 2,
    "FixCable": 2,
    "PickCable": 2,
    "LayWire": 1,
}
WIRES = 2
# Of the first wires of the order, which are too thick for the robots.
BY_HAND = 3

# Responses that the fake cell knows as cures, beside an operator's, who is absent here.
_CURES = ("retry", "retry_with", "look_again", "new_part", "replan")
_OPERATOR = "ask_operator"
_OPERATOR_SHARE = 0.1

# Who tries again by itself.
_INSIDE = ("action", "behavior")


@dataclass(frozen=True)
class Trial:
    """One run.

    Attributes:
        kind: name of the fault; empty: nothing goes wrong.
        seed: of what was drawn.
        first_level: who is to handle it first.
        codes: names of the error codes that report it.
        cure: response that cures it; empty: none does.
        faults: parameters of the fake cell.
    """

    kind: str
    seed: int
    first_level: str = ""
    codes: tuple[str, ...] = ()
    cure: str = ""
    faults: tuple[dict[str, Any], ...] = ()

    @property
    def can_recover(self) -> bool:
        """Whether something that can be done without a person cures it."""
        return self.cure not in ("", _OPERATOR)


def drawn(row: Mapping[str, Any], seed: int) -> Trial:
    """Return a trial of a fault.

    A cure is drawn from the responses that the table lists for the fault; one fault in ten, of
    those for which an operator is asked in the end, has no other cure. A fault that action
    or behavior handle first may also pass by itself.

    Args:
        row: of remodel_msgs/config/faults.yaml.
        seed: of the draw.
    """
    kind, cause = row["fault"], row["cause"]["interface"]
    random = Random(f"{kind} {seed}")
    times = {response["do"]: response.get("times", 1) for response in row["responses"]}
    if row["first_level"] in _INSIDE:
        times.setdefault("retry", 2)
    cures = [do for do in times if do in _CURES]
    if "after" in row:  # what a behavior does by itself would end it before it shows
        cures = [do for do in cures if do not in ("retry", "look_again")]
    cure = random.choice(cures) if cures else ""
    if _OPERATOR in times and random.random() < _OPERATOR_SHARE:
        cure = _OPERATOR
    fault: dict[str, Any] = {"name": kind, "cure": cure or _OPERATOR}
    goals = GOALS_OF_A_WIRE.get(cause["ability"], 1)
    # There must be another wire left for the plan to change.
    fault["nth"] = random.randint(1, goals if cure == "replan" else WIRES * goals)
    if cure == "retry":
        fault["times"] = random.randint(1, times["retry"])
    if cure == "retry_with":
        fault["at_least"] = random.uniform(15.0, 20.0)  # what 14 N and two changes reach
    return Trial(kind, seed, row["first_level"], tuple(row["codes"]), cure, (fault,))


# Faults by their physical causes in the simulated cell, drawn from a seed


# Kind of remodel_msgs/InjectFault -> whether it can be put right without a person. A blocked
# opening stays blocked. The shares and shifts are such as a cell meets: a mount that gives way by
# millimetres, pads that are worn or oily, a lamp that is out.
PHYSICAL_KINDS = {
    "component_moved": True,
    "socket_blocked": False,
    "friction_lowered": True,
    "grip_weakened": True,
    "camera_bumped": True,
    "light_changed": True,
    "tip_bent": True,
}


def drawn_physical(kind: str, seed: int, ends: Sequence[TerminalRef]) -> Trial:
    """Return a trial of a physical fault.

    Args:
        kind: of PHYSICAL_KINDS.
        seed: of the draw.
        ends: terminals into which wires are inserted.
    """
    random = Random(f"{kind} {seed}")
    end = random.choice(ends)
    sign = random.choice([-1.0, 1.0])
    target, values = {
        "component_moved": (
            end.component,
            [random.uniform(-0.006, 0.006), random.uniform(-0.006, 0.006), 0.0],
        ),
        "socket_blocked": (f"{end.component}/{end.terminal}", []),
        "friction_lowered": ("", [random.uniform(0.3, 0.7)]),
        "grip_weakened": ("", [random.uniform(0.3, 0.7)]),
        "camera_bumped": (
            "overhead",
            [random.uniform(-0.003, 0.003), random.uniform(-0.003, 0.003), 0.0, 0.0],
        ),
        "light_changed": ("", [random.uniform(0.4, 1.6)]),
        "tip_bent": (random.choice("ab"), [sign * random.uniform(0.1, 0.4)]),
    }[kind]
    fault = {"kind": kind, "target": target, "values": values}
    cure = "any" if PHYSICAL_KINDS[kind] else ""
    return Trial(kind, seed, cure=cure, faults=(fault,))


# What became of one run of the campaign, from its events


# Who has handled a fault first.
INSIDE, TASK, USE_CASE = "action or behavior", "task", "use case"
LEVELS = {"action": INSIDE, "behavior": INSIDE, "task": TASK, "use_case": USE_CASE}
_OF_THE_TASK = (Do.RETRY, Do.RETRY_WITH, Do.LOOK_AGAIN, Do.NEW_PART)

# The abilities that withdraw an end and empty the hand when a behavior gives up; they handle
# nothing.
_GIVES_UP = ("ExtractCable", "PlaceCable")

# remodel_msgs/ErrorCode SERVER_HUNG and TIMEOUT: such a goal took as long as it was waited for.
_WAITED_FOR = (1, 7)


@dataclass(frozen=True)
class Verdict:
    """What became of a run.

    Attributes:
        run: its number; 0 if none was begun.
        struck: whether the fault has shown.
        hung: whether it did not end within its limit.
        complete: whether it says that all is done.
        true: whether what it says of each task is what the cell's truth says.
        hand_empty: whether nothing is left in the hand, unless a person was to answer first.
        first: who handled the failure first; empty if nothing failed.
        cell_s: [s] that its operations take in the cell.
        wall_s: [s] wall time.
        explained: whether `explain` names the cause, and the end.
        replayed: whether `replay` finds no difference.
    """

    run: int
    struck: bool = False
    hung: bool = False
    complete: bool = False
    true: bool = False
    hand_empty: bool = False
    first: str = ""
    cell_s: float = 0.0
    wall_s: float = 0.0
    explained: bool = False
    replayed: bool = False

    @property
    def recovered(self) -> bool:
        """Whether all was done in spite of the fault."""
        return self.complete and self.true

    @property
    def ended_well(self) -> bool:
        """Whether it ended by itself, safely, and can be explained."""
        safe = not self.hung and self.true and self.hand_empty
        return safe and self.explained and self.replayed


def is_complete(events: Sequence[Event]) -> bool:
    """Return whether a run has ended with all tasks done."""
    last = events[-1]
    return isinstance(last, RunEnded) and last.ending is Ending.COMPLETE


def needs_person(events: Sequence[Event]) -> bool:
    """Return whether nothing may move, not even to empty the hand, before a person answers."""
    last = next((e.operation for e in reversed(events) if isinstance(e, OperationEnded)), None)
    return last is not None and last.error_code in PERSON_FIRST


def is_explained(events: Sequence[Event], explanation: str) -> bool:
    """Return whether a run's explanation has each failed operation, and how the run ended."""
    failed = [
        event.operation
        for event in events
        if isinstance(event, OperationEnded) and event.operation.error_code
    ]
    failures = (f"error {operation.error_code}: {operation.text}" for operation in failed)
    return all(line in explanation for line in failures) and "\nended " in explanation


def decided_first(events: Sequence[Event], fault: str) -> str:
    """Return who decided first about a fault of a name; empty if no level did."""
    return next(
        (_level(event) for event in events if isinstance(event, Decided) and event.fault == fault),
        "",
    )


def _level(event: Decided) -> str:
    return TASK if event.do in _OF_THE_TASK else USE_CASE


def handled_first(events: Sequence[Event], codes: Collection[int]) -> str:
    """Return who did something first about the first failure with one of some codes."""
    failed = ""
    for event in events:
        match event:
            case OperationEnded() if not failed and event.operation.error_code in codes:
                failed = event.task
            case OperationEnded() if failed and event.operation.ability not in _GIVES_UP:
                return INSIDE
            case TaskEnded() if failed and event.outcome == "finished":
                return INSIDE
            case Decided() if failed:
                return _level(event)
    return ""


def cell_s(events: Sequence[Event], durations_s: Mapping[str, float], inspection_s: float) -> float:
    """Return how long the operations of a run take in the cell [s].

    Args:
        events: of the run.
        durations_s: [s] ability -> what it takes there.
        inspection_s: [s] of an inspection.
    """
    total_s = 0.0
    for event in events:
        if isinstance(event, OperationEnded):
            total_s += _took_s(event.operation, durations_s)
        elif isinstance(event, Settled):
            total_s += inspection_s
    return total_s


def _took_s(operation: Operation, durations_s: Mapping[str, float]) -> float:
    usual_s = durations_s.get(operation.ability, 0.0)
    waited = operation.error_code in _WAITED_FOR
    return max(usual_s, operation.elapsed_s) if waited else usual_s


# The figures of the campaign, of each kind of fault and in sum


Results = Sequence[tuple[Trial, Verdict]]

# In percent.
_LEAST_RECOVERED = 95.0

_HEAD = (
    f"{'':<22}{'runs':>6}{'can':>6}{'recovered':>11}{'right level':>13}{'extra cell':>12}"
    f"{'extra wall':>12}{'ended well':>12}{'hangs':>7}"
)


def print_table(results: Mapping[str, Results]) -> bool:
    """Print a table of each policy; return whether the first one meets the targets."""
    for policy, done in results.items():
        plain = [verdict for trial, verdict in done if not trial.kind]
        faulty = [(trial, verdict) for trial, verdict in done if trial.kind]
        print(f"\npolicy: {policy}; {len(plain)} runs without a fault")
        print(_HEAD)
        for kind in dict.fromkeys(trial.kind for trial, _ in faulty):
            print(_line(kind, [(t, v) for t, v in faulty if t.kind == kind], plain))
        print(_line("all", faulty, plain))
        for trial, verdict in done:
            if problem := _problem(trial, verdict):
                print(f"  run {verdict.run}: {trial.kind}, seed {trial.seed}, {problem}")
    first = [(trial, verdict) for trial, verdict in next(iter(results.values())) if trial.kind]
    recovered = _share([verdict.recovered for trial, verdict in first if trial.can_recover])
    ended_well = bool(first) and all(verdict.ended_well for _, verdict in first)
    return recovered >= _LEAST_RECOVERED and ended_well


def docs_rows(results: Mapping[str, Results]) -> Iterator[dict[str, str]]:
    """Yield the rows of the docs' table: a kind of fault each, then all; the first policy fully."""
    (policy, done), *others = results.items()
    plain = [verdict for trial, verdict in done if not trial.kind]
    faulty = [(trial, verdict) for trial, verdict in done if trial.kind]
    for kind in (*dict.fromkeys(trial.kind for trial, _ in faulty), ""):
        of_kind = [(t, v) for t, v in faulty if kind in ("", t.kind)]
        recovered = [v for t, v in of_kind if t.can_recover and v.recovered]
        row = {
            "kind": kind or "all",
            f"{policy}: recovered": _recovered(of_kind),
            "extra cell": _more([v.cell_s for v in recovered], [v.cell_s for v in plain]),
            "extra wall": _more([v.wall_s for v in recovered], [v.wall_s for v in plain]),
            "ended well": f"{sum(v.ended_well for _, v in of_kind)} of {len(of_kind)}",
        }
        for other, tried in others:
            found = [(t, v) for t, v in tried if t.kind and kind in ("", t.kind)]
            row[f"{other}: recovered"] = _recovered(found)
        yield row


def _recovered(done: Results) -> str:
    can = [verdict.recovered for trial, verdict in done if trial.can_recover]
    return f"{sum(can)} of {len(can)}" if can else "cannot"


def _line(kind: str, done: Results, plain: Sequence[Verdict]) -> str:
    can = [verdict for trial, verdict in done if trial.can_recover]
    recovered = [verdict for verdict in can if verdict.recovered]
    right = [
        verdict.first == LEVELS[trial.first_level]
        for trial, verdict in done
        if verdict.first and trial.first_level
    ]
    hangs = sum(verdict.hung for _, verdict in done)
    return (
        f"{kind:<22}{len(done):>6}{len(can):>6}{_percent([v.recovered for v in can]):>11}"
        f"{_percent(right):>13}"
        f"{_more([v.cell_s for v in recovered], [v.cell_s for v in plain]):>12}"
        f"{_more([v.wall_s for v in recovered], [v.wall_s for v in plain]):>12}"
        f"{_percent([v.ended_well for _, v in done]):>12}{hangs:>7}"
    )


def _problem(trial: Trial, verdict: Verdict) -> str:
    """Return what is not as it should be about a run; empty if all is."""
    found = [
        text
        for text, bad in (
            ("hung", verdict.hung),
            (f"not recovered, cure {trial.cure}", trial.can_recover and not verdict.recovered),
            ("what it says of the wires is not true", not verdict.true),
            ("the hand is not empty", not verdict.hand_empty),
            ("not explained", not verdict.explained),
            ("not replayed", not verdict.replayed),
            ("the fault has not shown", bool(trial.kind) and not verdict.struck),
        )
        if bad
    ]
    return "; ".join(found)


def _share(good: Sequence[bool]) -> float:
    return 100.0 * sum(good) / len(good) if good else 100.0


def _percent(good: Sequence[bool]) -> str:
    return f"{_share(good):.0f} %" if good else "-"


def _more(with_fault: Sequence[float], without: Sequence[float]) -> str:
    """Return by how many seconds the median run with a fault is longer."""
    if not with_fault or not without:
        return "-"
    return f"{median(with_fault) - median(without):+.1f} s"
