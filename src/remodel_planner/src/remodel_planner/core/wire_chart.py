"""Turn a wire into the state chart of its task.

    Find wire ─► Connect a ─► Pick b ─► Route b ─► Connect b ─► finished
                 (Place Connector)      (along its channel)  (Place Connector)

Each step that looks or grasps is tried a few times; Place Connector has its own recovery. What is
given up ends in Lay down, so that the hand is empty when the task has failed.
"""

from __future__ import annotations

import math

from flexbe_synthesizer.core.model import (
    Behavior,
    Chart,
    Connection,
    Input,
    Outcome,
    Output,
    Param,
    State,
    Transition,
)
from remodel_planner.core.panel_layout import CutWire, PanelLayout

CONNECT = "Place Connector"

# The outcome of a task that did what it should.
FINISHED = "finished"

LAY_DOWN = "Lay down"

# [m] height of the tool centre over the plate while end b is carried: clear of wires lying there,
# and low enough for the wire to stay in its channel.
CARRY_HEIGHT_M = 0.040

# [m] by which the tool goes past b's terminal, so that the wire comes back to it in a bend.
BEYOND_M = 0.030

# [m] height of the tool centre over the plate where a wire that is given up is let go: it may fall
# across whatever lies there.
LAY_DOWN_HEIGHT_M = 0.028

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
    carried = _over_channel(cut, layout, CARRY_HEIGHT_M)
    nodes = (
        _retried("Find wire", "DetectCableState", "detected", "Connect a", _LOOK_ATTEMPTS),
        _connect("Connect a", "Pick b"),
        _retried(
            "Pick b",
            "PickCableState",
            "picked",
            "Route b",
            _PICK_ATTEMPTS,
            "cable_end",
            otherwise=LAY_DOWN,
        ),
        State(
            id="Route b",
            type="RouteWireState",
            params=(Param("path", (carried,)),),
            inputs=(Input("cable_id", "string"),),
            outputs=_ERRORS,
            transitions=_transitions(routed="Connect b", failed="Pick b", command_error=LAY_DOWN),
        ),
        _connect("Connect b", FINISHED),
        State(
            id=LAY_DOWN,
            type="PlaceCableState",
            params=(Param("target", _over_channel(cut, layout, LAY_DOWN_HEIGHT_M)),),
            inputs=(Input("cable_id", "string"),),
            transitions=_transitions(placed="failed", failed="failed", command_error="failed"),
        ),
    )
    return Chart(
        name=name,
        initial="Find wire",
        outcomes=(Outcome(FINISHED), Outcome("failed")),
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
    node_id: str,
    kind: str,
    done: str,
    target: str,
    attempts: int,
    *more_inputs: str,
    otherwise: str = "failed",
) -> State:
    """Return a state that is tried again when it fails."""
    return State(
        id=node_id,
        type=kind,
        inputs=tuple(Input(key, "string") for key in ("cable_id", *more_inputs)),
        outputs=_ERRORS,
        attempts=attempts,
        transitions=_transitions(
            **{done: target}, failed=node_id, command_error=otherwise, exhausted="failed"
        ),
    )


def _connect(node_id: str, target: str) -> Behavior:
    keys = ("cable_id", "cable_end", "component_id", "terminal_id")
    return Behavior(
        id=node_id,
        type=CONNECT,
        inputs=tuple(Input(key, "string") for key in keys),
        outputs=_ERRORS,
        transitions=_transitions(finished=target, failed=LAY_DOWN),
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


def _over_channel(cut: CutWire, layout: PanelLayout, height: float) -> tuple[float, ...]:
    """Return the tool pose [x, y, z, yaw] in the panel frame, past b's terminal in the channel."""
    channel = next(channel for channel in layout.channels if channel.name == cut.channel)
    onwards = 1 if cut.second_y >= cut.first_y else -1
    y = cut.second_y + onwards * BEYOND_M
    return (round(channel.x, 4), round(y, 4), height, round(onwards * math.pi / 2, 4))
