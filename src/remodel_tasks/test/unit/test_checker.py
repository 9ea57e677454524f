"""The checker finds each single fault that is put into a valid plan."""

import random
from dataclasses import replace

import pytest
from random_panel import random_panel

from remodel_tasks.core.plan.checker import check
from remodel_tasks.core.problem.instance import problem_from
from remodel_tasks.core.problem.problem import Action, ActionKind, End, Plan
from remodel_tasks.core.search import tables_of
from remodel_tasks.edge.anytime_planner import AnytimePlanner
from remodel_tasks.edge.search_kernel import Kernel


@pytest.fixture(scope="module", params=[1, 2])
def planned(request):
    tables = tables_of(problem_from(random_panel(30, 1, request.param)))
    return AnytimePlanner(Kernel(), tables).first()


def verdict(planned, actions):
    problem = planned.tables.problem
    return check(problem, Plan(problem.name, tuple(actions)))


def first(planned, kind):
    return next(i for i, a in enumerate(planned.plan.actions) if a.kind is kind)


def test_the_plan_itself_is_valid(planned):
    assert verdict(planned, planned.plan.actions).valid


def test_no_action_can_be_left_out(planned):
    actions = planned.plan.actions
    for i in random.Random(1).sample(range(len(actions)), 40):
        assert not verdict(planned, actions[:i] + actions[i + 1 :]).valid


def test_no_action_can_start_earlier_than_it_does(planned):
    """The simulation starts everything as early as it can, so that a tick less breaks something."""
    actions = planned.plan.actions
    for i in random.Random(1).sample(range(len(actions)), 40):
        if actions[i].start_ticks > 0:
            earlier = replace(actions[i], start_ticks=actions[i].start_ticks - 1)
            assert not verdict(planned, [*actions[:i], earlier, *actions[i + 1 :]]).valid


@pytest.mark.parametrize(
    ("kind", "change", "message"),
    [
        (ActionKind.PICK, {"arm": "Z"}, "no arm Z"),
        (ActionKind.PICK, {"wire": "w999"}, "no wire w999"),
        (ActionKind.CHANGE_TOOL, {"target": "G9"}, "no tool G9"),
        (ActionKind.LOCATE, {"target": "t"}, "no terminal t"),
        (ActionKind.INSERT, {"wire": "w999"}, "no wire w999"),
    ],
)
def test_unknown_names_are_reported(planned, kind, change, message):
    i = first(planned, kind)
    actions = list(planned.plan.actions)
    actions[i] = replace(actions[i], **change)
    assert f"action {i}: {message}" in verdict(planned, actions).violations


def test_a_plan_for_another_problem_is_reported(planned):
    other = Plan("other", planned.plan.actions)
    assert check(planned.tables.problem, other).violations[0].startswith("the plan is for other")


def test_extracting_what_is_not_jammed_is_reported(planned):
    i = first(planned, ActionKind.INSERT)
    insert = planned.plan.actions[i]
    extract = Action(ActionKind.EXTRACT, insert.arm, insert.start_ticks, insert.wire, end=End.A)
    actions = [*planned.plan.actions[:i], extract, *planned.plan.actions[i:]]
    assert any("is not jammed" in text for text in verdict(planned, actions).violations)


def test_two_arms_in_one_duct_are_reported():
    """Without the exclusion of ducts, the second arm would start its routing earlier."""
    problem = problem_from(random_panel(60, 1, 2))
    shared = tuple(replace(wire, segments=("one",)) for wire in problem.wires)
    plan = AnytimePlanner(Kernel(), tables_of(problem)).first().plan
    violations = check(replace(problem, wires=shared), plan).violations
    assert any("needs duct one, which arm" in text for text in violations)
