#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Plan one-arm panels with GTPyhop and greedy guidance, in the environment that has GTPyhop.

Usage: gtpyhop_panel.py INSTANCE.json. Prints one JSON object: the time from loaded problem to plan
[s], and the plan as a list of wires with their first ends. The state is small and immutable (sets
are bits of an integer), since GTPyhop copies it for every action.
"""

from __future__ import annotations

import contextlib
import io
import json
import sys
import time
from pathlib import Path
from typing import Any

with contextlib.redirect_stdout(io.StringIO()):
    import gtpyhop

Json = dict[str, Any]
# What a greedy choice pays for a light wire as long as no light one has been picked.
_LIGHT_SURCHARGE = 10


class Domain:
    """Actions and methods of one panel."""

    def __init__(self, panel: Json) -> None:
        self.panel = panel
        self.wires = panel["wires"]
        self.number = {wire["id"]: i for i, wire in enumerate(self.wires)}
        terminals = {t["id"]: t for t in panel["terminals"]}
        self.ends = [
            [(terminals[w[e]]["x"], terminals[w[e]]["y"]) for e in "ab"] for w in self.wires
        ]
        components = {c["id"]: i for i, c in enumerate(panel["components"])}
        self.component = [[components[terminals[w[e]]["comp"]] for e in "ab"] for w in self.wires]
        self.before = [0] * len(self.wires)
        for item in panel["precedence"]:
            self.before[self.number[item["after"]]] |= 1 << self.number[item["before"]]
        self.station = tuple(panel["arms"][0]["station"])

    def travel(self, p: tuple[int, int], q: tuple[int, int]) -> int:
        """Return the ticks from one position to another."""
        return -(-max(abs(p[0] - q[0]), abs(p[1] - q[1])) // self.panel["speed"])

    def detour(self, state: gtpyhop.State, wire: int, first: int) -> int:
        """Return what a wire would cost as the next one, besides what every order pays."""
        row, weights = self.wires[wire], self.panel["weights"]
        slot, at = tuple(row["slot"]), state.position
        cost = self.travel(slot, self.ends[wire][first])
        if state.tool == row["tool"]:
            cost += self.travel(at, slot)
        else:
            way = self.travel(at, self.station) + self.travel(self.station, slot)
            cost += way + self.panel["durations"]["tool"] + weights["tool"]
        if state.last >= 0:
            last = self.wires[state.last]
            cost += weights["colour"] * (last["colour"] != row["colour"])
            cost += weights["zone"] * max(0, last["zone"] - row["zone"])
        else:
            cost += weights["start"] * row["zone"]
        return cost + _LIGHT_SURCHARGE * (not row["heavy"] and not state.light)

    def wire_panel(self, state: gtpyhop.State) -> list[tuple[Any, ...]]:
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

    def place_wire(self, state: gtpyhop.State, wire: int, first: int) -> list[tuple[Any, ...]]:
        """Decompose a wire into actions."""
        steps: list[tuple[Any, ...]] = []
        if state.tool != self.wires[wire]["tool"]:
            steps.append(("change_tool", self.wires[wire]["tool"]))
        steps.append(("pick", wire))
        located = state.located
        for end in (first, 1 - first):
            if not located >> self.component[wire][end] & 1:
                steps.append(("locate", wire, end))
                located |= 1 << self.component[wire][end]
            steps.append(("insert", wire, end))
            if end == first:
                steps.append(("route", wire, 1 - first))
        return [*steps, ("fix", wire, 1 - first)]

    def declare(self) -> None:
        """Declare the domain to GTPyhop."""

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


def _plan(panel: Json) -> Json:
    gtpyhop.set_verbose_level(0)
    gtpyhop.Domain("panel")
    gtpyhop.set_recursive_planning(False)
    started = time.perf_counter()
    Domain(panel).declare()
    arm = panel["arms"][0]
    state = gtpyhop.State("start")
    state.position, state.tool, state.holding = tuple(arm["home"]), arm["tool"], -1
    state.done = state.located = state.inserted = state.routed = 0
    state.last, state.light = -1, False
    steps = gtpyhop.find_plan(state, [("wire_panel",)])
    taken = time.perf_counter() - started
    firsts = {}
    for name, *arguments in steps:
        if name == "insert":
            firsts.setdefault(panel["wires"][arguments[0]]["id"], arguments[1])
    return {"seconds": taken, "wires": list(firsts.items())}


def main() -> None:
    """Plan the panel that is named."""
    panel = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    with contextlib.redirect_stdout(io.StringIO()):
        result = _plan(panel)
    print(json.dumps(result))


if __name__ == "__main__":
    main()
