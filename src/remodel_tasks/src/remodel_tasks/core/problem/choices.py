"""The wires that an entry of a preferences document selects.

WIRES: all, a wire's name, a list of names, or {NAME: TEST, ...}: the wires that pass all tests
NAME:  colour, tool, component, heavy, zone, or a characteristic that the order's wires have
TEST:  a value, a list of values, or {at_least: NUMBER, at_most: NUMBER}
"""

from __future__ import annotations

from remodel_production.errors import InstanceError
from remodel_tasks.core.condition import Test, Value, is_number
from remodel_tasks.core.problem.fields import Fields
from remodel_tasks.core.problem.problem import End, PlannedWire, Problem

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
