"""What a user prefers and requires of a plan, besides what the design says.

The grammar, in YAML (docs/planning.md has an example):

    format: remodel-preferences-1
    weights: {NAME: TICKS, ...}         # of Weights; those not named stay
    prefer:                             # soft: a plan may break it, and pays
      - {name: TEXT, pick: WIRES, before: WIRES, weight: TICKS}
      - {name: TEXT, pick: WIRES, with_arm: ARM}        # weight: weights.arm, for each wire
    require:                            # hard: no plan breaks it
      - {name: TEXT, route: WIRES, before: WIRES}
      - {name: TEXT, arm: ARM, x_mm: [LEAST, GREATEST]}
      - {name: TEXT, avoid_segment: SEGMENT}
    WIRES: a wire's name, a list of names, or {colour|tool|component|heavy|zone: VALUE, ...},
           the wires that have all these values

A preference holds between all wires of the one choice and all of the other, without the pairs of a
wire with itself.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from remodel_planner.core.planning.fields import Fields
from remodel_planner.core.planning.problem import End, Problem, Under, Wire, Wish
from remodel_planner.errors import InstanceError

FORMAT = "remodel-preferences-1"

_WEIGHTS = ("colour", "zone", "start", "tool", "heavy", "arm")
_Tests = dict[str, Callable[[Problem, Wire, object], bool]]
_TESTS: _Tests = {
    "colour": lambda _, wire, value: wire.colour == value,
    "tool": lambda _, wire, value: wire.tool == value,
    "heavy": lambda _, wire, value: wire.heavy is value,
    "zone": lambda _, wire, value: value is not True and wire.zone == value,
    "component": lambda problem, wire, value: any(
        problem.end_terminal(wire, end).component == value for end in End
    ),
}


@dataclass(frozen=True)
class Preferred:
    """A problem with a user's preferences in it.

    Attributes:
        arm_reasons: the names of the preferences for an arm, by wire.
    """

    problem: Problem
    arm_reasons: dict[str, str]


def apply_preferences(problem: Problem, data: object) -> Preferred:
    """Return the problem with the preferences of a parsed document.

    Raises:
        InstanceError: naming the first entry that is malformed, speaks of what is not there, or
            cannot be kept by any plan.
    """
    fields = Fields(data, "")
    fields.only("format", "weights", "prefer", "require")
    fields.choice("format", (FORMAT,))
    if fields.has("weights"):
        problem = _with_weights(problem, fields.inner("weights"))
    arm_reasons: dict[str, str] = {}
    for item in fields.objects("prefer") if fields.has("prefer") else []:
        problem = _prefer(problem, item, arm_reasons)
    for item in fields.objects("require") if fields.has("require") else []:
        problem = _require(problem, item)
    return Preferred(problem, arm_reasons)


def _with_weights(problem: Problem, fields: Fields) -> Problem:
    fields.only(*_WEIGHTS)
    weights = {name: fields.number(name) for name in fields.keys()}  # noqa: SIM118 - not a dict
    return replace(problem, weights=replace(problem.weights, **weights))


def _prefer(problem: Problem, item: Fields, arm_reasons: dict[str, str]) -> Problem:
    name = item.text("name")
    if item.has("with_arm"):
        item.only("name", "pick", "with_arm")
        arm = item.choice("with_arm", tuple(arm.name for arm in problem.arms))
        chosen = {wire.name for wire in _choose(problem, item, "pick")}
        arm_reasons.update(dict.fromkeys(sorted(chosen), name))
        wires = (replace(w, preferred_arm=arm) if w.name in chosen else w for w in problem.wires)
        return replace(problem, wires=tuple(wires))
    item.only("name", "pick", "before", "weight")
    weight = item.number("weight", least=1)
    pairs = _pairs(problem, item, "pick")
    wishes = tuple(Wish(before, after, weight, name) for before, after in pairs)
    return replace(problem, wishes=problem.wishes + wishes)


def _require(problem: Problem, item: Fields) -> Problem:
    name = item.text("name")
    if item.has("route"):
        item.only("name", "route", "before")
        unders = tuple(Under(*pair, name) for pair in _pairs(problem, item, "route"))
        return replace(problem, unders=problem.unders + unders)
    if item.has("avoid_segment"):
        item.only("name", "avoid_segment")
        return _without_segment(problem, item.text("avoid_segment"), name)
    item.only("name", "arm", "x_mm")
    arm_name = item.choice("arm", tuple(arm.name for arm in problem.arms))
    least, greatest = item.pair("x_mm")
    arms = (
        replace(arm, reach_mm=(max(least, arm.reach_mm[0]), min(greatest, arm.reach_mm[1])))
        if arm.name == arm_name
        else arm
        for arm in problem.arms
    )
    return replace(problem, arms=tuple(arms))


def _without_segment(problem: Problem, segment: str, name: str) -> Problem:
    through = [wire.name for wire in problem.wires if segment in wire.segments]
    if through:
        shown = ", ".join(through[:5]) + (", ..." if len(through) > 5 else "")
        raise InstanceError(
            f"requirement `{name}`: {len(through)} wires are routed through segment {segment} "
            f"({shown}): route them elsewhere, or drop the requirement"
        )
    return problem


def _pairs(problem: Problem, item: Fields, key: str) -> Iterator[tuple[str, str]]:
    later = _choose(problem, item, "before")
    for first in _choose(problem, item, key):
        for second in later:
            if first is not second:
                yield first.name, second.name


def _choose(problem: Problem, item: Fields, key: str) -> list[Wire]:
    """Return the wires that a choice names or describes, at least one."""
    value = item.value(key)
    if isinstance(value, str):
        value = [value]
    if isinstance(value, list):
        return [_named(problem, item, key, name) for name in value]
    choice = item.inner(key)
    choice.only(*_TESTS)
    wires = [
        wire
        for wire in problem.wires
        if all(
            _TESTS[test](problem, wire, choice.value(test))
            for test in choice.keys()  # noqa: SIM118 - not a dict
        )
    ]
    if not wires:
        raise item.fail(key, "a choice that at least one wire meets")
    return wires


def _named(problem: Problem, item: Fields, key: str, name: object) -> Wire:
    if not isinstance(name, str) or name not in problem.wire:
        raise InstanceError(f"{item.place(key)}: no wire {name}; the order has {_some(problem)}")
    return problem.wire[name]


def _some(problem: Problem) -> str:
    names = [wire.name for wire in problem.wires]
    return ", ".join(names[:3]) + (f", ... {names[-1]}" if len(names) > 3 else "")
