"""Turn a wire into the state chart of its task.

    Find wire ─► Connect a ─► Pick b ─► Route b ─► Connect b ─► finished
                 (Place Connector)      (along its channel)  (Place Connector)

Each step that looks or grasps is tried a few times; Place Connector has its own recovery.
"""

from __future__ import annotations

import math

from flexbe_synthesizer.core.model import (
    Behavior,
    Chart,
    Connection,
    Input,
    Node,
    Outcome,
    Output,
    Param,
    State,
    Transition,
)
from remodel_planner.core.panel_layout import CutWire, PanelLayout

CONNECT = "Place Connector"

# [m] height of the tool centre over the plate while end b is carried: clear of wires lying there,
# and low enough for the wire to stay in its channel.
CARRY_HEIGHT_M = 0.040

# [m] by which the tool goes past b's terminal, so that the wire comes back to it in a bend.
BEYOND_M = 0.030

_LOOK_ATTEMPTS, _PICK_ATTEMPTS = 3, 3

_ERRORS = (Output("error_code", "int"), Output("error_message", "string"))


def behavior_name(wire: str) -> str:
    """Return the name of the behavior that places a wire."""
    return f"Place Wire {wire}"


def wire_chart(cut: CutWire, layout: PanelLayout) -> Chart:
    """Return the chart of the task that places a wire on the panel."""
    wire = cut.wire
    name = behavior_name(wire.name)
    inputs = (
        Input("cable_id", "string", wire.name),
        Input("a_end", "string", "a"),
        Input("a_component", "string", cut.first.component),
        Input("a_terminal", "string", cut.first.terminal),
        Input("b_end", "string", "b"),
        Input("b_component", "string", cut.second.component),
        Input("b_terminal", "string", cut.second.terminal),
    )
    nodes = (
        _retried("Find wire", "DetectCableState", "detected", "Connect a", _LOOK_ATTEMPTS),
        _connect("Connect a", "Pick b"),
        _retried("Pick b", "PickCableState", "picked", "Route b", _PICK_ATTEMPTS, "cable_end"),
        State(
            id="Route b",
            type="RouteWireState",
            params=(Param("path", _path(cut, layout)),),
            inputs=(Input("cable_id", "string"),),
            outputs=_ERRORS,
            transitions=_transitions(routed="Connect b", failed="Pick b", command_error="failed"),
        ),
        _connect("Connect b", "finished"),
    )
    return Chart(
        name=name,
        initial="Find wire",
        outcomes=(Outcome("finished"), Outcome("failed")),
        inputs=inputs,
        outputs=_ERRORS,
        nodes=nodes,
        connections=(
            *_bind(name, "Connect a", "a"),
            Connection(name, "b_end", "Pick b", "cable_end"),
            *_bind(name, "Connect b", "b"),
        ),
        description=(
            f"Places wire {wire.name}, {wire.colour} {wire.section_mm2:g} mm2, {cut.length:.2f} m, "
            f"from {cut.first} to {cut.second}."
        ),
    )


def _retried(
    node_id: str, kind: str, done: str, target: str, attempts: int, *more_inputs: str
) -> State:
    """Return a state that is tried again when it fails."""
    return State(
        id=node_id,
        type=kind,
        inputs=tuple(Input(key, "string") for key in ("cable_id", *more_inputs)),
        outputs=_ERRORS,
        attempts=attempts,
        transitions=_transitions(
            **{done: target}, failed=node_id, command_error="failed", exhausted="failed"
        ),
    )


def _connect(node_id: str, target: str) -> Node:
    keys = ("cable_id", "cable_end", "component_id", "terminal_id")
    return Behavior(
        id=node_id,
        type=CONNECT,
        inputs=tuple(Input(key, "string") for key in keys),
        outputs=_ERRORS,
        transitions=_transitions(finished=target, failed="failed"),
    )


def _bind(chart: str, node_id: str, end: str) -> tuple[Connection, ...]:
    """Return the flows that tell a Place Connector which end goes where."""
    keys = {"end": "cable_end", "component": "component_id", "terminal": "terminal_id"}
    return tuple(
        Connection(chart, f"{end}_{key}", node_id, behavior_key)
        for key, behavior_key in keys.items()
    )


def _transitions(**targets: str) -> tuple[Transition, ...]:
    return tuple(Transition(event, target) for event, target in targets.items())


def _path(cut: CutWire, layout: PanelLayout) -> tuple[tuple[float, ...], ...]:
    """Return tool poses [x, y, z, yaw] in the panel frame: along the channel, past b's terminal."""
    channel = next(channel for channel in layout.channels if channel.name == cut.channel)
    onwards = 1 if cut.second_y >= cut.first_y else -1
    y = cut.second_y + onwards * BEYOND_M
    return ((round(channel.x, 4), round(y, 4), CARRY_HEIGHT_M, round(onwards * math.pi / 2, 4)),)
