"""Constraints on differences."""

import random

from remodel_production.core.panel.difference_constraints import AtLeast, least_solution


def test_each_value_is_the_least_that_meets_all():
    constraints = [AtLeast("b", "a", 2.0), AtLeast("c", "b", 3.0), AtLeast("c", "a", 4.0)]
    assert least_solution({"a": 1.0, "b": 0.0, "c": 0.0}, constraints) == {
        "a": 1.0,
        "b": 3.0,
        "c": 6.0,
    }


def test_contradicting_constraints_have_no_solution():
    constraints = [AtLeast("b", "a", 2.0), AtLeast("a", "b", -1.0)]
    assert least_solution({"a": 0.0, "b": 0.0}, constraints) is None


def test_random_systems_are_met_and_nothing_can_be_less():
    for seed in range(200):
        chance = random.Random(seed)
        names = "abcdef"[: chance.randint(2, 6)]
        lowest = {name: chance.uniform(-1, 1) for name in names}
        constraints = [AtLeast(*chance.sample(names, 2), chance.uniform(-3, 1.0)) for _ in range(8)]
        values = least_solution(lowest, constraints)
        if values is None:
            continue
        for name in names:
            bounds = [values[c.lower] + c.gap for c in constraints if c.upper == name]
            assert abs(values[name] - max([lowest[name], *bounds])) < 1e-6
