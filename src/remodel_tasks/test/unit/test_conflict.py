"""The smallest sets of requirements that no plan keeps."""

import random

import pytest

from remodel_tasks.core.problem.conflict import (
    keeping,
    requirements_in,
    smallest_conflict,
)


def documents(count):
    entries = [{"name": f"r{i}", "route": f"w{i}"} for i in range(count)]
    return [("first.yaml", {"require": entries[:3]}), ("second.yaml", {"require": entries[3:]})]


def test_requirements_keep_their_names_and_sources():
    found = requirements_in([*documents(5), ("third.yaml", {"prefer": []}), ("bad.yaml", 3)])
    assert [each.name for each in found] == ["r0", "r1", "r2", "r3", "r4"]
    assert str(found[4]) == "`r4` (second.yaml, require[1]): route: w4"


def test_documents_keep_the_requirements_that_are_asked_for():
    made = documents(5)
    found = requirements_in(made)
    kept = keeping(made, [found[1], found[4]])
    assert [each.name for each in requirements_in(kept)] == ["r1", "r4"]
    assert len(requirements_in(made)) == 5


@pytest.mark.parametrize("seed", range(40))
def test_a_conflict_has_no_plan_and_every_part_of_it_has_one(seed):
    dice = random.Random(seed)
    found = requirements_in(documents(dice.randint(1, 12)))
    conflicts = [
        {each.name for each in dice.sample(found, dice.randint(1, min(4, len(found))))}
        for _ in range(dice.randint(0, 3))
    ]

    def has_plan(kept):
        names = {each.name for each in kept}
        return not any(conflict <= names for conflict in conflicts)

    conflict = smallest_conflict(found, has_plan)
    assert bool(conflict) == (not has_plan(found))
    if conflict:
        assert not has_plan(conflict)
    assert all(has_plan([each for each in conflict if each != one]) for one in conflict)


def test_a_design_without_a_plan_is_no_conflict_of_requirements():
    assert smallest_conflict(requirements_in(documents(4)), lambda _: False) == []
