"""Problems and plans in the JSON forms of the benchmark `planbench-1` (docs/planning.md)."""

from __future__ import annotations

import math
from typing import Any

from remodel_tasks.core.problem.fields import GREATEST, GREATEST_TIME, Fields
from remodel_tasks.core.problem.problem import (
    Action,
    ActionKind,
    Characteristic,
    Detour,
    Durations,
    End,
    Handling,
    Handover,
    Pin,
    Plan,
    PlannedArm,
    PlannedTerminal,
    PlannedWire,
    Problem,
    Ranking,
    SoftConstraint,
    Stage,
    Under,
    Weights,
)

Json = dict[str, Any]

FORMAT = "planbench-1"

_STAGES = {
    "stored": Stage.STORED,
    "held": Stage.HELD,
    "in1": Stage.FIRST_IN,
    "half": Stage.HALF,
    "given": Stage.GIVEN,
    "routed": Stage.ROUTED,
    "in2": Stage.SECOND_IN,
    "fixed": Stage.FIXED,
}


def problem_from(data: object) -> Problem:
    """Build the problem that a parsed instance describes.

    Whether it can be planned is not asked here: see `defects`.

    Raises:
        InstanceError: naming the first field that is missing or malformed.
    """
    fields = Fields(data, "")
    fields.choice("format", (FORMAT,))
    init = fields.inner("init")
    states = _wire_states(init.inner("wires"))
    durations, weights = fields.inner("durations"), fields.inner("weights")
    precedence = [
        (item, item.choice("type", ("under", "pin"))) for item in fields.objects("precedence")
    ]
    return Problem(
        name=fields.text("name"),
        speed_mm=fields.number("speed", least=1),
        durations=Durations(
            *(
                durations.number(key)
                for key in ("pick", "locate", "fix", "tool", "extract", "handover")
            )
        ),
        weights=Weights(
            **{
                key: weights.number(key)
                for key in ("colour", "zone", "start", "tool", "heavy", "arm", "cable")
                if key != "cable" or weights.has(key)
            }
        ),
        tools=fields.texts("tools"),
        arms=tuple(
            arm_from(item, init.inner("arms").inner(item.text("id")))
            for item in fields.objects("arms")
        ),
        components=tuple(item.text("id") for item in fields.objects("components")),
        terminals=tuple(terminal_from(item) for item in fields.objects("terminals")),
        wires=tuple(_wire(item, states) for item in fields.objects("wires")),
        unders=tuple(
            Under(item.text("before"), item.text("after"), source=item.where)
            for item, kind in precedence
            if kind == "under"
        ),
        pins=tuple(_pin(item) for item, kind in precedence if kind == "pin"),
        soft_constraints=tuple(
            SoftConstraint(item.text("before"), item.text("after"), item.number("weight"))
            for item in fields.objects("soft_before")
        ),
        rankings=tuple(
            Ranking(_groups(item), item.number("weight"))
            for item in (fields.objects("soft_order") if fields.has("soft_order") else ())
        ),
        start_ticks=init.number("t0", greatest=GREATEST_TIME),
        located=frozenset(init.texts("located")),
        history=tuple(_picks(init)),
    )


def _groups(item: Fields) -> tuple[tuple[str, ...], ...]:
    groups = item.value("groups")
    if not isinstance(groups, list):
        raise item.fail("groups", "a list of lists of wires")
    inner = Fields({str(i): group for i, group in enumerate(groups)}, item.place("groups"))
    return tuple(inner.texts(str(i)) for i in range(len(groups)))


def _wire_states(states: Fields) -> dict[str, Fields]:
    return {name: states.inner(name) for name in states.keys()}  # noqa: SIM118 - not a dict


def arm_from(item: Fields, state: Fields) -> PlannedArm:
    """Return the arm of an entry, and of the one with its state."""
    return PlannedArm(
        item.text("id"),
        item.pair("station"),
        item.pair("reach"),
        state.pair("pos"),
        tool=state.text("tool"),
        holding=state.text("holding") if state.has("holding") else None,
    )


def terminal_from(item: Fields) -> PlannedTerminal:
    """Return the terminal of an entry."""
    position = (item.number("x", least=-GREATEST), item.number("y", least=-GREATEST))
    return PlannedTerminal(item.text("id"), item.text("comp"), position)


def _wire(item: Fields, states: dict[str, Fields]) -> PlannedWire:
    name = item.text("id")
    stage, first, jammed = Stage.STORED, None, None
    if name in states:
        state = states[name]
        stage = _STAGES[state.choice("stage", tuple(_STAGES))]
        first = end_from(state, "first") if state.has("first") else None
        jammed = end_from(state, "jam") if state.has("jam") else None
    return PlannedWire(
        name,
        (item.text("a"), item.text("b")),
        item.text("colour"),
        item.text("tool"),
        heavy=item.flag("heavy"),
        zone=item.number("zone"),
        slot_mm=item.pair("slot"),
        segments=item.texts("segments"),
        route_ticks=item.number("route"),
        insert_ticks=item.number("insert"),
        handover=_handover(item.inner("handover")) if item.has("handover") else None,
        preferred_arm=item.text("prefer_arm") if item.has("prefer_arm") else None,
        stage=stage,
        first=first,
        jammed=jammed,
        handling=_handling(item.inner("handling")) if item.has("handling") else None,
        detours=tuple(map(_detour, item.objects("detours"))) if item.has("detours") else (),
        insert_force_n=item.number("insert_force_n") if item.has("insert_force_n") else None,
        characteristics=characteristics_of(item),
        cable=item.text("cable") if item.has("cable") else "",
    )


def characteristics_of(item: Fields) -> tuple[tuple[str, Characteristic], ...]:
    """Return the field `characteristics`, if there is one: texts, finite numbers, booleans."""
    if not item.has("characteristics"):
        return ()
    inner = item.inner("characteristics")
    return tuple((name, inner.plain(name)) for name in inner.keys())  # noqa: SIM118 - not a dict


def _handling(item: Fields) -> Handling:
    return Handling(item.number("pick"), item.pair("insert", least=0), item.number("fix"))


def _detour(item: Fields) -> Detour:
    meeting = _handover(item.inner("handover")) if item.has("handover") else None
    return Detour(item.texts("segments"), item.number("route"), meeting)


def _handover(item: Fields) -> Handover:
    return Handover(item.pair("pos"), (item.number("route_a"), item.number("route_b")))


def end_from(item: Fields, key: str) -> End:
    """Return a field that is the letter of an end."""
    return End("ab".index(item.choice(key, ("a", "b"))))


def _pin(item: Fields) -> Pin:
    return Pin(
        item.text("before"),
        end_from(item, "before_end"),
        item.text("after"),
        end_from(item, "after_end"),
        source=item.where,
    )


def _picks(init: Fields) -> list[tuple[str, str]]:
    picks = init.value("history")
    if not isinstance(picks, list):
        raise init.fail("history", "a list of [wire, arm]")
    for pick in picks:
        if not (
            isinstance(pick, list) and len(pick) == 2 and all(isinstance(x, str) for x in pick)
        ):
            raise init.fail("history", "a list of [wire, arm]")
    return [(pick[0], pick[1]) for pick in picks]


def problem_data(problem: Problem) -> Json:
    """Return the document of a problem; it does not hold the reasons of constraints."""
    times, weights = problem.durations, problem.weights
    return {
        "format": FORMAT,
        "name": problem.name,
        "speed": problem.speed_mm,
        "durations": {
            **{key: getattr(times, key) for key in ("pick", "locate", "fix", "extract")},
            "tool": times.change_tool,
            "handover": times.hand_over,
        },
        "weights": dict(vars(weights)),
        "tools": list(problem.tools),
        "arms": [
            {"id": arm.name, "station": list(arm.station_mm), "reach": list(arm.reach_mm)}
            for arm in problem.arms
        ],
        "components": [{"id": name} for name in problem.components],
        "terminals": [
            {"id": t.name, "comp": t.component, "x": t.position_mm[0], "y": t.position_mm[1]}
            for t in problem.terminals
        ],
        "wires": [_wire_data(wire) for wire in problem.wires],
        "precedence": [
            *({"type": "under", "before": u.before, "after": u.after} for u in problem.unders),
            *map(_pin_data, problem.pins),
        ],
        "soft_before": [
            {"before": soft.before, "after": soft.after, "weight": soft.weight}
            for soft in problem.soft_constraints
        ],
        "soft_order": [
            {"groups": [list(group) for group in ranking.groups], "weight": ranking.weight}
            for ranking in problem.rankings
        ],
        "init": _init_data(problem),
    }


def _wire_data(wire: PlannedWire) -> Json:
    row: Json = {
        "id": wire.name,
        "a": wire.terminals[End.A],
        "b": wire.terminals[End.B],
        "colour": wire.colour,
        "tool": wire.tool,
        "heavy": wire.heavy,
        "zone": wire.zone,
        "slot": list(wire.slot_mm),
        "segments": list(wire.segments),
        "route": wire.route_ticks,
        "insert": wire.insert_ticks,
        "handover": _handover_data(wire.handover),
        "prefer_arm": wire.preferred_arm,
        "insert_force_n": None if wire.insert_force_n is None else math.ceil(wire.insert_force_n),
        "characteristics": dict(wire.characteristics),
    }
    if wire.cable:
        row["cable"] = wire.cable
    if wire.handling is not None:
        row["handling"] = {
            "pick": wire.handling.pick_ticks,
            "insert": list(wire.handling.insert_ticks),
            "fix": wire.handling.fix_ticks,
        }
    if wire.detours:
        row["detours"] = [
            {
                "segments": list(detour.segments),
                "route": detour.route_ticks,
                "handover": _handover_data(detour.handover),
            }
            for detour in wire.detours
        ]
    return row


def _handover_data(handover: Handover | None) -> Json | None:
    if handover is None:
        return None
    route_a, route_b = handover.route_ticks
    return {"pos": list(handover.position_mm), "route_a": route_a, "route_b": route_b}


def _pin_data(pin: Pin) -> Json:
    return {
        "type": "pin",
        "before": pin.before,
        "before_end": pin.before_end.letter,
        "after": pin.after,
        "after_end": pin.after_end.letter,
    }


def _init_data(problem: Problem) -> Json:
    words = {stage: word for word, stage in _STAGES.items()}
    return {
        "t0": problem.start_ticks,
        "located": sorted(problem.located),
        "history": [list(pick) for pick in problem.history],
        "arms": {
            arm.name: {"pos": list(arm.position_mm), "tool": arm.tool, "holding": arm.holding}
            for arm in problem.arms
        },
        "wires": {
            wire.name: {
                "stage": words[wire.stage],
                "first": None if wire.first is None else wire.first.letter,
                "jam": None if wire.jammed is None else wire.jammed.letter,
            }
            for wire in problem.wires
            if wire.stage is not Stage.STORED or wire.first is not None
        },
    }


_TARGET_KEYS = {
    ActionKind.CHANGE_TOOL: "tool",
    ActionKind.LOCATE: "term",
    ActionKind.HAND_OVER: "to_arm",
}
_WITH_WIRE = frozenset(ActionKind) - {ActionKind.CHANGE_TOOL, ActionKind.LOCATE}
_WITH_END = frozenset({ActionKind.INSERT, ActionKind.EXTRACT})
_HANDOVER_POINT = "h"


def plan_data(plan: Plan) -> dict[str, object]:
    """Return the plan as a JSON document."""
    return {"instance": plan.problem, "actions": [_action_data(action) for action in plan.actions]}


def plan_from(data: object) -> Plan:
    """Build the plan that a parsed document describes.

    Raises:
        InstanceError: naming the first field that is missing or malformed.
    """
    fields = Fields(data, "")
    actions = sorted(map(_action, fields.objects("actions")), key=lambda a: a.start_ticks)
    return Plan(fields.text("instance"), tuple(actions))


def _action_data(action: Action) -> dict[str, object]:
    kind = action.kind
    data: dict[str, object] = {"a": kind.value, "arm": action.arm}
    if kind in _WITH_WIRE:
        data["wire"] = action.wire
    if kind in _TARGET_KEYS:
        data[_TARGET_KEYS[kind]] = action.target
    if kind in _WITH_END and action.end is not None:
        data["end"] = action.end.letter
    if kind is ActionKind.ROUTE:
        data["to"] = _HANDOVER_POINT if action.end is None else action.end.letter
    data["t"] = action.start_ticks
    return data


def _action(fields: Fields) -> Action:
    kind = ActionKind(fields.choice("a", tuple(kind.value for kind in ActionKind)))
    end = None
    if kind in _WITH_END:
        end = end_from(fields, "end")
    elif kind is ActionKind.ROUTE:
        to = fields.choice("to", ("a", "b", _HANDOVER_POINT))
        end = None if to == _HANDOVER_POINT else End("ab".index(to))
    return Action(
        kind,
        fields.text("arm"),
        fields.number("t", greatest=GREATEST_TIME),
        fields.text("wire") if kind in _WITH_WIRE else None,
        end=end,
        target=fields.text(_TARGET_KEYS[kind]) if kind in _TARGET_KEYS else None,
    )
