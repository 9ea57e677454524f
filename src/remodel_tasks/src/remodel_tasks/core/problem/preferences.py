"""What a user prefers and requires of a plan, besides what the design says.

The grammar, in YAML (docs/planning.md has an example):

    format: remodel-preferences-1
    zones: {ZONE: [LEAST, GREATEST], ...}       # parts of the panel, in x [mm]
    weights: {NAME: TICKS, ...}                 # of Weights; those not named stay
    prefer:                                     # soft: a plan may violate it, and pays
      - {name: TEXT, pick: WIRES, before: WIRES, weight: TICKS}
      - {name: TEXT, pick: WIRES, in_order_of: NAME, from: least|greatest, weight: TICKS}
      - {name: TEXT, pick: WIRES, with_arm: ARM}             # weight: weights.arm, for each wire
    require:                                    # hard: no plan violates it
      - {name: TEXT, route: WIRES, before: WIRES}
      - {name: TEXT, route: WIRES, in_order_of: NAME, from: least|greatest}
      - {name: TEXT, arm: ARM, x_mm: [LEAST, GREATEST], while: SITUATION}
      - {name: TEXT, arm: ARM, out_of: ZONE, while: SITUATION}
      - {name: TEXT, avoid_segment: SEGMENT}
      - {name: TEXT, insert: WIRES, force_n: NEWTON}
    WIRES: all, a wire's name, a list of names, or {NAME: TEST, ...}: the wires that pass all tests
    NAME:  colour, tool, component, heavy, zone, or a characteristic that the order's wires have
    TEST:  a value, a list of values, or {at_least: NUMBER, at_most: NUMBER}

A preference holds between all wires of the one choice and all of the other, without the pairs of a
wire with itself; one of an order, between all wires whose values differ: a soft one becomes a
Ranking, whose pairs are not listed, a hard one binds each value's wires to those of the next value.
What has a `while` counts in that situation only; without it, always. A choice that no wire meets is
refused, unless the entry says `if_any: true`.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from remodel_production.errors import InfeasibleError, InstanceError, blamed
from remodel_tasks.core.condition import Test, Value, is_number
from remodel_tasks.core.problem.defects import require_sound
from remodel_tasks.core.problem.fields import Fields
from remodel_tasks.core.problem.problem import (
    End,
    PlannedArm,
    PlannedWire,
    Problem,
    Ranking,
    SoftConstraint,
    Under,
)

ALL = "all"
_COMPONENT = "component"
_PROPERTIES = ("colour", "tool", "heavy", "zone")


def choose(problem: Problem, item: Fields, key: str) -> list[PlannedWire]:
    """Return the wires that a choice names or describes, at least one.

    Raises:
        InstanceError: if it speaks of what is not there, or of no wire.
    """
    value = item.value(key)
    if value == ALL and ALL not in problem.wire:
        return list(problem.wires)
    if isinstance(value, str):
        value = [value]
    if isinstance(value, list):
        return [_named(problem, item, key, name) for name in value]
    choice = item.inner(key)
    choice.only(_COMPONENT, *features_of(problem))
    tests = [_test(choice, name) for name in choice.keys()]  # noqa: SIM118 - not a dict
    wires = [wire for wire in problem.wires if all(_passes(problem, wire, test) for test in tests)]
    if not wires and not (item.has("if_any") and item.flag("if_any")):
        raise item.fail(key, "a choice that at least one wire meets")
    return wires


def features_of(problem: Problem) -> list[str]:
    """Return the names of the values by which wires can be chosen and put in order."""
    stated = {name: None for wire in problem.wires for name, _ in wire.characteristics}
    return list(dict.fromkeys((*_PROPERTIES, *stated)))


def feature(wire: PlannedWire, name: str) -> Value | None:
    """Return a wire's value of that name; None if it has none."""
    if name in _PROPERTIES:
        value: Value = getattr(wire, name)
        return value
    return dict(wire.characteristics).get(name)


def _named(problem: Problem, item: Fields, key: str, name: object) -> PlannedWire:
    if not isinstance(name, str) or name not in problem.wire:
        raise InstanceError(f"{item.place(key)}: no wire {name}; the order has {_some(problem)}")
    return problem.wire[name]


def _some(problem: Problem) -> str:
    names = [wire.name for wire in problem.wires]
    return ", ".join(names[:3]) + (f", ... {names[-1]}" if len(names) > 3 else "")


def _test(choice: Fields, name: str) -> Test:
    asked = choice.value(name)
    if isinstance(asked, dict):
        bounds = choice.inner(name)
        bounds.only("at_least", "at_most")
        for bound in bounds.keys():  # noqa: SIM118 - not a dict
            if not is_number(bounds.value(bound)):
                raise bounds.fail(bound, "a number")
    elif not all(
        isinstance(v, str | int | float) for v in (asked if isinstance(asked, list) else [asked])
    ):
        raise choice.fail(name, "a value, a list of values, or at_least and at_most")
    return Test.stated(name, asked)


def _passes(problem: Problem, wire: PlannedWire, test: Test) -> bool:
    if test.name == _COMPONENT:
        names = [problem.end_terminal(wire, end).component for end in End]
        return any(test.passes({_COMPONENT: name}) for name in names)
    value = feature(wire, test.name)
    return value is not None and test.passes({test.name: value})


FORMAT = "remodel-preferences-1"

_REQUIREMENTS = (
    "`route` with `before`, or with `in_order_of` and `from`; `arm` with `x_mm` or `out_of`; "
    "`avoid_segment`; `insert` with `force_n`; each may have `while`, and one that chooses wires "
    "`if_any` (`pick` stands under `prefer`)"
)
_CHOICES = ("pick", "before", "route", "insert")
_WEIGHTS = ("colour", "zone", "start", "tool", "heavy", "arm", "cable")
_SHOWN = 5


@dataclass(frozen=True)
class Preferred:
    """A problem with a user's preferences in it.

    Attributes:
        arm_reasons: the names of the preferences for an arm, by wire.
        detours: names of the requirements for which wires are done by another method or route, by
            wire.
        situations: in which some requirement counts.
    """

    problem: Problem
    arm_reasons: dict[str, str] = field(default_factory=dict)
    detours: dict[str, str] = field(default_factory=dict)
    situations: frozenset[str] = frozenset()


def apply_preferences(
    preferred: Preferred, data: object, situations: frozenset[str] = frozenset()
) -> Preferred:
    """Return the problem with the preferences of a parsed document, in the present situations.

    Raises:
        InstanceError: naming the first entry that is malformed, refers to what is not there, or
            cannot be kept by any plan.
    """
    fields = document_fields(data)
    if fields.has("weights"):
        weights = _weights(preferred.problem, fields.inner("weights"))
        preferred = replace(preferred, problem=weights)
    for item in fields.objects("prefer") if fields.has("prefer") else []:
        preferred = _prefer(preferred, item)
    zones = fields.inner("zones") if fields.has("zones") else Fields({}, "zones")
    for item in requirements(fields):
        if item.has("while"):
            situation = item.text("while")
            preferred = replace(preferred, situations=preferred.situations | {situation})
            if situation not in situations:
                continue
        preferred = _require(preferred, item, zones)
    return preferred


def apply_documents(
    preferred: Preferred, documents: Sequence[tuple[str, object]], situations: frozenset[str]
) -> Preferred:
    """Return the problem with the preferences of parsed documents, after each of them sound.

    Raises:
        InstanceError: naming the document, and what `apply_preferences` or `require_sound` says.
    """
    for name, document in documents:
        with blamed(name):
            preferred = apply_preferences(preferred, document, situations)
            require_sound(preferred.problem)
    return preferred


def document_fields(data: object) -> Fields:
    """Return the fields of a preferences document; InstanceError if it is none."""
    fields = Fields(data, "")
    fields.only("format", "zones", "weights", "prefer", "require")
    fields.choice("format", (FORMAT,))
    return fields


def requirements(fields: Fields) -> list[Fields]:
    """Return the entries of a document that no plan may violate."""
    return fields.objects("require") if fields.has("require") else []


def about_wires(data: object, present: Collection[str]) -> object:
    """Return what a valid document says about some of an order's wires.

    A choice that names other wires loses them, an entry whose choice is empty then is left out, and
    a description needs no longer be met by a wire.
    """
    if not isinstance(data, Mapping):
        return data
    lists = {
        key: [left for entry in data[key] if (left := _about(entry, present)) is not None]
        for key in ("prefer", "require")
        if key in data
    }
    return {**data, **lists}


def _about(entry: Mapping[str, object], present: Collection[str]) -> dict[str, object] | None:
    """Return what is left of an entry; None for nothing."""
    left = dict(entry)
    for key in set(_CHOICES) & set(entry):
        chosen = entry[key]
        names = [chosen] if isinstance(chosen, str) and chosen != ALL else chosen
        if isinstance(names, list):
            left[key] = [name for name in names if name in present]
            if not left[key]:
                return None
        left["if_any"] = True
    return left


def _weights(problem: Problem, fields: Fields) -> Problem:
    fields.only(*_WEIGHTS)
    weights = {name: fields.number(name) for name in fields.keys()}  # noqa: SIM118 - not a dict
    return replace(problem, weights=replace(problem.weights, **weights))


def _prefer(preferred: Preferred, item: Fields) -> Preferred:
    name, problem = item.text("name"), preferred.problem
    if item.has("with_arm"):
        item.only("name", "if_any", "pick", "with_arm")
        arm = item.choice("with_arm", tuple(arm.name for arm in problem.arms))
        chosen = {wire.name for wire in choose(problem, item, "pick")}
        wires = (replace(w, preferred_arm=arm) if w.name in chosen else w for w in problem.wires)
        reasons = {**preferred.arm_reasons, **dict.fromkeys(sorted(chosen), name)}
        return replace(preferred, problem=replace(problem, wires=tuple(wires)), arm_reasons=reasons)
    if item.has("in_order_of"):
        item.only("name", "if_any", "pick", "in_order_of", "from", "weight")
        groups = tuple(tuple(w.name for w in group) for group in _groups(problem, item, "pick"))
        ranking = Ranking(groups, item.number("weight", least=1), name)
        rankings = (*problem.rankings, ranking) if len(groups) > 1 else problem.rankings
        return replace(preferred, problem=replace(problem, rankings=rankings))
    item.only("name", "if_any", "pick", "before", "weight")
    pairs = _between(choose(problem, item, "pick"), choose(problem, item, "before"))
    weight = item.number("weight", least=1)
    added = tuple(SoftConstraint(before, after, weight, name) for before, after in pairs)
    constraints = problem.soft_constraints + added
    return replace(preferred, problem=replace(problem, soft_constraints=constraints))


def _require(preferred: Preferred, item: Fields, zones: Fields) -> Preferred:
    name, problem = item.text("name"), preferred.problem
    if item.has("avoid_segment"):
        item.only("name", "avoid_segment", "while")
        return _avoid(preferred, item.text("avoid_segment"), name)
    if item.has("route"):
        problem = _in_order(problem, item, name)
    elif item.has("insert"):
        _limit_force(problem, item, name)
    elif item.has("arm"):
        problem = _limit_reach(problem, item, zones)
    else:
        raise InstanceError(
            f"{item.where}: requires nothing that is known, found {', '.join(item.keys())}; beside "
            f"`name`, give one of: {_REQUIREMENTS}"
        )
    return replace(preferred, problem=problem)


def _in_order(problem: Problem, item: Fields, name: str) -> Problem:
    if item.has("in_order_of"):
        item.only("name", "if_any", "route", "in_order_of", "from", "while")
        groups = _groups(problem, item, "route")
        pairs = [pair for two in itertools.pairwise(groups) for pair in _between(*two)]
    else:
        item.only("name", "if_any", "route", "before", "while")
        pairs = list(_between(choose(problem, item, "route"), choose(problem, item, "before")))
        if not pairs and not item.has("if_any"):
            raise InstanceError(
                f"{item.where}: requirement `{name}`: `route` and `before` choose one wire, the "
                "same: no wire comes before itself"
            )
    return replace(problem, unders=problem.unders + tuple(Under(*pair, name) for pair in pairs))


def _limit_force(problem: Problem, item: Fields, name: str) -> None:
    item.only("name", "if_any", "insert", "force_n", "while")
    limit = item.number("force_n", least=1)
    for wire in choose(problem, item, "insert"):
        if wire.insert_force_n is None:
            raise InfeasibleError(
                f"requirement `{name}`: the insertion force of wire {wire.name} is not "
                "known: give its insert_force_n, or drop the requirement"
            )
        if wire.insert_force_n > limit:
            raise InfeasibleError(
                f"requirement `{name}`: wire {wire.name} is pushed in with "
                f"{wire.insert_force_n:g} N, over {limit} N: offer a gentler method, or drop the "
                "requirement"
            )


def _limit_reach(problem: Problem, item: Fields, zones: Fields) -> Problem:
    item.only("name", "arm", "x_mm", "out_of", "while")
    arm_name = item.choice("arm", tuple(arm.name for arm in problem.arms))
    arm = next(arm for arm in problem.arms if arm.name == arm_name)
    if item.has("out_of"):
        zone = item.choice("out_of", zones.keys())
        limited = _outside(problem, arm, zones.pair(zone))
    else:
        least, greatest = item.pair("x_mm")
        limited = (max(least, arm.reach_mm[0]), min(greatest, arm.reach_mm[1]))
    less = replace(arm, reach_mm=limited, limited_by=(*arm.limited_by, item.text("name")))
    return replace(problem, arms=tuple(less if a is arm else a for a in problem.arms))


def _outside(problem: Problem, arm: PlannedArm, zone: tuple[int, int]) -> tuple[int, int]:
    """Return what a zone leaves of an arm's reach: the side of it that has more terminals."""
    least, greatest = arm.reach_mm
    left, right = (least, min(greatest, zone[0] - 1)), (max(least, zone[1] + 1), greatest)

    def terminals(part: tuple[int, int]) -> int:
        return sum(part[0] <= t.position_mm[0] <= part[1] for t in problem.terminals)

    return max(left, right, key=terminals)


def _avoid(preferred: Preferred, segment: str, name: str) -> Preferred:
    problem = preferred.problem
    wires = [_detoured(wire, segment) for wire in problem.wires]
    through = [w.name for w, other in zip(problem.wires, wires, strict=True) if other is None]
    if through:
        shown = ", ".join(through[:_SHOWN]) + (", ..." if len(through) > _SHOWN else "")
        raise InfeasibleError(
            f"requirement `{name}`: {len(through)} wires are routed through segment {segment} and "
            f"have no detour ({shown}): offer them one, or drop the requirement"
        )
    changed = tuple(wire for wire in wires if wire is not None)
    moved = [w.name for w in changed if w.segments != problem.wire[w.name].segments]
    return replace(
        preferred,
        problem=replace(problem, wires=changed),
        detours={**preferred.detours, **dict.fromkeys(moved, name)},
    )


def _detoured(wire: PlannedWire, segment: str) -> PlannedWire | None:
    """Return the wire on the first of its routes that avoids a segment; None if there is none."""
    free = tuple(detour for detour in wire.detours if segment not in detour.segments)
    if segment not in wire.segments:
        return replace(wire, detours=free)
    if not free:
        return None
    detour = free[0]
    return replace(
        wire,
        segments=detour.segments,
        route_ticks=detour.route_ticks,
        handover=detour.handover,
        detours=free[1:],
    )


def _groups(problem: Problem, item: Fields, key: str) -> list[list[PlannedWire]]:
    """Return the chosen wires, those of equal values together, in the order asked for."""
    name = item.choice("in_order_of", tuple(features_of(problem)))
    greatest_first = item.choice("from", ("least", "greatest")) == "greatest"
    values = [(feature(wire, name), wire) for wire in choose(problem, item, key)]
    lacking = [wire.name for value, wire in values if value is None]
    if lacking:
        raise InstanceError(f"{item.place('in_order_of')}: wire {lacking[0]} has no {name}")
    if len({isinstance(value, str) for value, _ in values}) > 1:
        raise InstanceError(f"{item.place('in_order_of')}: {name} is text and number in turns")
    ordered = sorted(values, key=lambda pair: pair[0], reverse=greatest_first)  # type: ignore[arg-type, return-value]
    return [
        [wire for _, wire in group] for _, group in itertools.groupby(ordered, lambda pair: pair[0])
    ]


def _between(earlier: list[PlannedWire], later: list[PlannedWire]) -> Iterator[tuple[str, str]]:
    for first in earlier:
        for second in later:
            if first is not second:
                yield first.name, second.name
