#!/usr/bin/env python3
"""Other planners on our panels; run by an interpreter that has them (requirements-bench.txt).

peers.py gtpyhop PANEL.json plans a one-arm panel with greedy guidance, and prints the time from
loaded problem to plan [s] and the wires with their first ends. Its state is small and immutable
(sets are bits of an integer), since GTPyhop copies it for every action.

peers.py fast-downward FOLDER reads domain and problem in PDDL and HDDL, and plan.txt; it prints the
cost of an optimal plan, by A* without a heuristic, and what unified-planning finds of our plan.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import argparse
import contextlib
import io
import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

Json = dict[str, Any]
Steps = list[tuple[Any, ...]]
# What a greedy choice pays for a light wire as long as no light one has been picked.
LIGHT_SURCHARGE = 10
LIMIT_S = 300


class Domain:
    """Actions and methods of one panel for GTPyhop."""

    def __init__(self, panel: Json) -> None:
        self.panel, self.wires = panel, panel["wires"]
        number = {wire["id"]: i for i, wire in enumerate(self.wires)}
        terminals = {t["id"]: t for t in panel["terminals"]}
        components = {c["id"]: i for i, c in enumerate(panel["components"])}
        found = [[terminals[wire[end]] for end in "ab"] for wire in self.wires]
        self.ends = [[(t["x"], t["y"]) for t in both] for both in found]
        self.component = [[components[t["comp"]] for t in both] for both in found]
        self.before = [0] * len(self.wires)
        for item in panel["precedence"]:
            self.before[number[item["after"]]] |= 1 << number[item["before"]]
        self.station = tuple(panel["arms"][0]["station"])

    def travel(self, p: tuple[int, int], q: tuple[int, int]) -> int:
        """Return the ticks from one position to another."""
        return -(-max(abs(p[0] - q[0]), abs(p[1] - q[1])) // self.panel["speed"])

    def detour(self, state: Any, wire: int, first: int) -> int:  # noqa: ANN401
        """Return what a wire would cost as the next one, besides what every order pays."""
        row, weights = self.wires[wire], self.panel["weights"]
        slot, at = tuple(row["slot"]), state.position
        cost = self.travel(slot, self.ends[wire][first])
        if state.tool == row["tool"]:
            cost += self.travel(at, slot)
        else:
            cost += self.travel(at, self.station) + self.travel(self.station, slot)
            cost += self.panel["durations"]["tool"] + weights["tool"]
        if state.last >= 0:
            last = self.wires[state.last]
            cost += weights["colour"] * (last["colour"] != row["colour"])
            cost += weights["zone"] * max(0, last["zone"] - row["zone"])
        else:
            cost += weights["start"] * row["zone"]
        return cost + LIGHT_SURCHARGE * (not row["heavy"] and not state.light)

    def wire_panel(self, state: Any) -> Steps:  # noqa: ANN401
        """Decompose the panel: the cheapest wire that may come next, then the rest."""
        ready = [
            wire
            for wire in range(len(self.wires))
            if not state.done >> wire & 1 and self.before[wire] & ~state.done == 0
        ]
        if not ready:
            return []
        choices = ((self.detour(state, w, first), w, first) for w in ready for first in (0, 1))
        _, wire, first = min(choices)
        return [("place_wire", wire, first), ("wire_panel",)]

    def place_wire(self, state: Any, wire: int, first: int) -> Steps:  # noqa: ANN401
        """Decompose a wire into actions."""
        tool, located = self.wires[wire]["tool"], state.located
        steps: Steps = [("change_tool", tool)] if state.tool != tool else []
        steps.append(("pick", wire))
        for end in (first, 1 - first):
            if not located >> self.component[wire][end] & 1:
                steps.append(("locate", wire, end))
                located |= 1 << self.component[wire][end]
            steps.append(("insert", wire, end))
            if end == first:
                steps.append(("route", wire, 1 - first))
        return [*steps, ("fix", wire, 1 - first)]

    def plan(self) -> Steps:
        """Declare the domain to GTPyhop, and return a plan."""
        import gtpyhop

        def change_tool(state: gtpyhop.State, tool: str) -> gtpyhop.State:
            state.tool, state.position = tool, self.station
            return state

        def pick(state: gtpyhop.State, wire: int) -> gtpyhop.State | None:
            if state.holding >= 0 or state.tool != self.wires[wire]["tool"]:
                return None
            state.holding, state.position = wire, tuple(self.wires[wire]["slot"])
            state.last, state.light = wire, state.light or not self.wires[wire]["heavy"]
            return state

        def locate(state: gtpyhop.State, wire: int, end: int) -> gtpyhop.State:
            state.located |= 1 << self.component[wire][end]
            state.position = self.ends[wire][end]
            return state

        def insert(state: gtpyhop.State, wire: int, end: int) -> gtpyhop.State | None:
            if state.holding != wire or not state.located >> self.component[wire][end] & 1:
                return None
            state.position, state.inserted = self.ends[wire][end], state.inserted + 1
            return state

        def route(state: gtpyhop.State, wire: int, end: int) -> gtpyhop.State | None:
            if state.holding != wire or self.before[wire] & ~state.done:
                return None
            state.position, state.routed = self.ends[wire][end], state.routed + 1
            return state

        def fix(state: gtpyhop.State, wire: int, end: int) -> gtpyhop.State | None:
            if state.holding != wire:
                return None
            state.holding, state.done = -1, state.done | 1 << wire
            state.position = self.ends[wire][end]
            return state

        gtpyhop.declare_actions(change_tool, pick, locate, insert, route, fix)
        gtpyhop.declare_task_methods("wire_panel", self.wire_panel)
        gtpyhop.declare_task_methods("place_wire", self.place_wire)
        arm, state = self.panel["arms"][0], gtpyhop.State("start")
        state.position, state.tool, state.holding = tuple(arm["home"]), arm["tool"], -1
        state.done, state.located, state.last, state.light = 0, 0, -1, False
        state.inserted = state.routed = 0  # GTPyhop leaves out what changes nothing
        return gtpyhop.find_plan(state, [("wire_panel",)])


def by_gtpyhop(file: Path) -> Json:
    """Plan a panel."""
    panel = json.loads(file.read_text(encoding="utf-8"))
    with contextlib.redirect_stdout(io.StringIO()):
        import gtpyhop

        gtpyhop.set_verbose_level(0)
        gtpyhop.Domain("panel")
        gtpyhop.set_recursive_planning(False)
        started = time.perf_counter()
        steps = Domain(panel).plan()
        taken_s = time.perf_counter() - started
    firsts: dict[str, int] = {}
    for name, *arguments in steps:
        if name == "insert":
            firsts.setdefault(panel["wires"][arguments[0]]["id"], arguments[1])
    return {"seconds": taken_s, "wires": list(firsts.items())}


def by_fast_downward(folder: Path) -> Json:
    """Find the least cost of a problem, and judge a plan of it."""
    import up_fast_downward
    from unified_planning.engines import SequentialPlanValidator
    from unified_planning.io import PDDLReader

    domain, problem, optimal = (
        folder / name for name in ("domain.pddl", "problem.pddl", "optimal.txt")
    )
    driver = Path(up_fast_downward.__file__).parent / "downward" / "fast-downward.py"
    line = [sys.executable, driver, "--plan-file", optimal, domain, problem]
    subprocess.run(
        [*line, "--search", "astar(blind())"],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        timeout=LIMIT_S,
        check=True,
    )
    parsed = PDDLReader().parse_problem(str(domain), str(problem))
    PDDLReader().parse_problem(str(folder / "domain.hddl"), str(folder / "problem.hddl"))
    validator = SequentialPlanValidator()
    validator.skip_checks = True  # it does not know all features by name, and judges them well
    verdict = validator.validate(parsed, PDDLReader().parse_plan(parsed, str(folder / "plan.txt")))
    return {
        "optimal": int(optimal.read_text().partition("; cost = ")[2].split()[0]),
        "plan": int(next(iter(verdict.metric_evaluations.values()))),
        "valid": verdict.status.name == "VALID",
    }


if __name__ == "__main__":
    planners = {"gtpyhop": by_gtpyhop, "fast-downward": by_fast_downward}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("planner", choices=planners)
    parser.add_argument("path", type=Path)
    options = parser.parse_args()
    print(json.dumps(planners[options.planner](options.path)))
