"""Read a problem from the benchmark's JSON form, `planbench-1` (docs/planning.md)."""

from __future__ import annotations

from remodel_planner.core.planning.fields import GREATEST, GREATEST_TIME, Fields
from remodel_planner.core.planning.problem import (
    Arm,
    Characteristic,
    Detour,
    Durations,
    End,
    Handling,
    Handover,
    Pin,
    Problem,
    Stage,
    Terminal,
    Under,
    Weights,
    Wire,
    Wish,
)

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
            *(weights.number(key) for key in ("colour", "zone", "start", "tool", "heavy", "arm"))
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
            Under(item.text("before"), item.text("after"))
            for item, kind in precedence
            if kind == "under"
        ),
        pins=tuple(_pin(item) for item, kind in precedence if kind == "pin"),
        wishes=tuple(
            Wish(item.text("before"), item.text("after"), item.number("weight"))
            for item in fields.objects("soft_before")
        ),
        start_ticks=init.number("t0", greatest=GREATEST_TIME),
        located=frozenset(init.texts("located")),
        history=tuple(_picks(init)),
    )


def _wire_states(states: Fields) -> dict[str, Fields]:
    return {name: states.inner(name) for name in states.keys()}  # noqa: SIM118 - not a dict


def arm_from(item: Fields, state: Fields) -> Arm:
    """Return the arm of an entry, and of one that tells what it is doing."""
    return Arm(
        item.text("id"),
        item.pair("station"),
        item.pair("reach"),
        state.pair("pos"),
        state.text("tool"),
        state.text("holding") if state.has("holding") else None,
    )


def terminal_from(item: Fields) -> Terminal:
    """Return the terminal of an entry."""
    position = (item.number("x", least=-GREATEST), item.number("y", least=-GREATEST))
    return Terminal(item.text("id"), item.text("comp"), position)


def _wire(item: Fields, states: dict[str, Fields]) -> Wire:
    name = item.text("id")
    stage, first, jammed = Stage.STORED, None, None
    if name in states:
        state = states[name]
        stage = _STAGES[state.choice("stage", tuple(_STAGES))]
        first = _end(state, "first") if state.has("first") else None
        jammed = _end(state, "jam") if state.has("jam") else None
    return Wire(
        name,
        (item.text("a"), item.text("b")),
        item.text("colour"),
        item.text("tool"),
        item.flag("heavy"),
        item.number("zone"),
        item.pair("slot"),
        item.texts("segments"),
        item.number("route"),
        item.number("insert"),
        _handover(item.inner("handover")) if item.has("handover") else None,
        item.text("prefer_arm") if item.has("prefer_arm") else None,
        stage,
        first,
        jammed,
        _handling(item.inner("handling")) if item.has("handling") else None,
        tuple(map(_detour, item.objects("detours"))) if item.has("detours") else (),
        item.number("insert_force_n") if item.has("insert_force_n") else None,
        characteristics_of(item),
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


def _end(item: Fields, key: str) -> End:
    return End("ab".index(item.choice(key, ("a", "b"))))


def _pin(item: Fields) -> Pin:
    return Pin(
        item.text("before"), _end(item, "before_end"), item.text("after"), _end(item, "after_end")
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
