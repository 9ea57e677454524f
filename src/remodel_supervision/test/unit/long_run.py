"""A long run, for tests and benchmarks: an order of many wires, and the events of its run."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Sequence
from pathlib import Path

from remodel_production.core.production import Component, Order, Side, Terminal, TerminalRef, Wire
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import (
    Decided,
    Event,
    OperationEnded,
    Part,
    Planned,
    RunBegun,
    Settled,
    TaskBegun,
    TaskEnded,
)
from remodel_tasks.core.use_case.fault import Do

# How many terminals a component has, and at which wires one insertion jams.
_TERMINALS = 20
_JAM_EVERY = 25

_CHART = Path(__file__).parent / "long_run_chart.xml"

# What abilities are asked for and measure; {} are the wire's own values.
_POSE = "world {x:.6g} {y:.6g} 0.0{z} 0 0 0.7071{z} 0.7071{z}"
_CLAMP = (("component_id", "{component}"), ("terminal_id", "{terminal}"))
_WIRE, _END, _LIMIT = (("cable_id", "{wire}"),), ("cable_end", "{end}"), ("timeout", "30.0")
_ARM = (("robot_name", "robot_1"), *_WIRE)
_PUSH = (*_ARM, _END, *_CLAMP, ("socket_pose", _POSE), ("force_limit", "8.0"), _LIMIT)
_LOCATED = (("component_pose", _POSE), ("socket_pose", _POSE), ("residual", "0.000{z}"))
_PICKED = (("grasp_pose", _POSE), ("grip_width", "0.00{z}"))
_FIXED = (("slip", "0.0000{z}"),)
_CONNECTED = (("connected", "True"), ("residual", "0.000{z}"))
_PATH = f"{_POSE}; {_POSE}"
# Ability -> outcome, parameters, measurements, text.
_ABILITIES = {
    "DetectCable": ("detected", (*_WIRE, ("view", "0"), _LIMIT), (), "{wire} lies in view"),
    "PickCable": (
        "picked",
        (*_ARM, _END, ("grasp_distance", "0.03"), _LIMIT),
        _PICKED,
        "{wire} is held {z} mm from its tip",
    ),
    "LocateGearboxComponent": (
        "located",
        (*_CLAMP, ("view", "0"), _LIMIT),
        _LOCATED,
        "{component}:{terminal} is located to 0.{z} mm",
    ),
    "InsertCable": (
        "inserted",
        _PUSH,
        (("depth", "0.0090{z}"), ("peak_force", "6.{z}")),
        "end {end} of {wire} sits in {component}:{terminal}",
    ),
    "FixCable": (
        "fixed",
        (*_ARM, *_CLAMP, ("pull_test_force", "10.0"), _LIMIT),
        _FIXED,
        "{wire} withstood 10 N at {component}:{terminal}",
    ),
    "RouteWire": (
        "routed",
        (*_ARM, ("path", _PATH), _LIMIT),
        (("reached", "2"),),
        "{wire} is routed",
    ),
    "CheckConnection": (
        "connected",
        (*_WIRE, _END, *_CLAMP, _LIMIT),
        _CONNECTED,
        "end {end} of {wire} is in {component}:{terminal}",
    ),
}
_CONNECTING = ("LocateGearboxComponent", "InsertCable", "FixCable")
# State and ability of each operation of a wire.
_STATES = (
    ("/Detect", "DetectCable"),
    ("/Pick a", "PickCable"),
    *((f"/Connect a/{ability}", ability) for ability in _CONNECTING),
    ("/Pick b", "PickCable"),
    ("/Route b", "RouteWire"),
    *((f"/Connect b/{ability}", ability) for ability in _CONNECTING),
    *((f"/Check {end}", "CheckConnection") for end in "ab"),
)


def long_order(wires: int, name: str = "long") -> Order:
    """Return an order of many wires, each between two terminals of its own."""
    parts = []
    for letter, side in (("Q", Side.BOTTOM), ("X", Side.TOP)):
        terminals = tuple(Terminal(f"{side.value[0]}{i}", side) for i in range(_TERMINALS))
        rows = range(-(-wires // _TERMINALS))
        parts += [Component(f"{letter}{row}", "terminal block", terminals) for row in rows]
    placed = []
    for number in range(wires):
        row, i = divmod(number, _TERMINALS)
        ends = TerminalRef(f"Q{row}", f"b{i}"), TerminalRef(f"X{row}", f"t{i}")
        placed.append(Wire(f"W{number}", *ends, "BU", 1.5, f"line {number}"))
    return Order(name, "", "", tuple(parts), tuple(placed))


def long_run(order: Order, cell: str = "cell") -> Iterator[Event]:
    """Yield the events of a run of an order, 14.4 a wire; one in 25 insertions jams once."""
    names = tuple(wire.name for wire in order.wires)
    yield RunBegun(order.name, "cabinet", cell, names)
    yield Planned(names, "the run begins")
    chart = _CHART.read_text(encoding="utf-8")
    at_s = 100.0
    for number, wire in enumerate(order.wires):
        xml = chart.replace('"W1"', f'"{wire.name}"').replace("Wire W1", f"Wire {wire.name}")
        xml = xml.replace('"Q1"', f'"{wire.a.component}"').replace("Content 0", f"Content {number}")
        if number % _JAM_EVERY == 0:
            yield from _attempt(wire, number, 1, Part.WHOLE, xml, at_s, _STATES[:4], jams=True)
            at_s += 40.0
            yield Decided(
                wire.name,
                "insertion_jammed",
                301,
                "InsertCable",
                "/Connect a/InsertCable",
                "the end jammed at 4.2 mm",
                Do.RETRY_WITH,
                (("force_limit", 10.0),),
                "its first answer is retry_with",
                "policy",
                at_s,
            )
            yield Settled(wire.name, (), 4)
            states, part, attempt = _STATES[2:], Part.AGAIN, 2
        else:
            states, part, attempt = _STATES, Part.WHOLE, 1
        yield from _attempt(wire, number, attempt, part, xml, at_s, states)
        at_s += 65.0


def _attempt(
    wire: Wire,
    number: int,
    attempt: int,
    part: Part,
    xml: str,
    at_s: float,
    states: Sequence[tuple[str, str]],
    *,
    jams: bool = False,
) -> Iterator[Event]:
    yield TaskBegun(wire.name, attempt, part, f"Place Wire {wire.name}", xml, at_s)
    for state in states:
        at_s += 5.4
        failed = jams and state is states[-1]
        yield OperationEnded(wire.name, _operation(wire, number, *state, at_s, failed=failed))
    path = tuple(f"{state} > {_ABILITIES[ability][0]}" for state, ability in states)
    pictures = tuple(
        f"{wire.name}-{attempt}-{part.value}-{camera}-{at_s:.3f}.jpg"
        for camera in ("overhead", "wrist", "scene")
    )
    yield TaskEnded(wire.name, "failed" if jams else "finished", at_s, not jams, path, pictures)


def _operation(
    wire: Wire, number: int, path: str, ability: str, at_s: float, *, failed: bool
) -> Operation:
    outcome, parameters, measurements, text = _ABILITIES[ability]
    end = "b" if "b" in path.split("/")[1].split() else "a"
    terminal = wire.b if end == "b" else wire.a
    digest = hashlib.sha256(f"{number} {path}".encode()).hexdigest()
    own = {
        "wire": wire.name,
        "end": end,
        "component": terminal.component,
        "terminal": terminal.terminal,
        "x": int(digest[:6], 16) / 2e7,
        "y": int(digest[6:12], 16) / 2e7,
        "z": int(digest[12:15], 16),
    }
    return Operation(
        path,
        ability,
        "failed" if failed else outcome,
        301 if failed else 0,
        "the end jammed at 4.2 mm" if failed else text.format(**own),
        round(at_s, 6),
        4.0 + own["x"],
        f"17:{digest[16:24]}-{number}",
        tuple((key, value.format(**own)) for key, value in parameters),
        tuple((key, value.format(**own)) for key, value in measurements),
    )
