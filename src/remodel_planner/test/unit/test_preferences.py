"""What a user prefers and requires reaches the plan, or is refused with the place."""

from dataclasses import replace

import pytest
import yaml
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from remodel_planner.core.planning.checker import check
from remodel_planner.core.planning.defects import require_sound
from remodel_planner.core.planning.explanation import broken_wishes, explain
from remodel_planner.core.planning.instance import problem_from
from remodel_planner.core.planning.listing import listing_of
from remodel_planner.core.planning.modes import Mode
from remodel_planner.core.planning.order import wire_order
from remodel_planner.core.planning.preferences import Preferred, apply_preferences
from remodel_planner.core.planning.problem import ActionKind, Wish
from remodel_planner.core.planning.tables import tables_of
from remodel_planner.edge.anytime_planner import AnytimePlanner
from remodel_planner.edge.search_kernel import Kernel
from remodel_planner.errors import InstanceError
from remodel_planner.testing.random_panel import random_panel

HEAD = {"format": "remodel-preferences-1"}


@pytest.fixture(scope="module")
def problem():
    return problem_from(random_panel(30, 1, 2))


def preferred(problem, text):
    return apply_preferences(Preferred(problem), {**HEAD, **yaml.safe_load(text)})


def planned(problem):
    require_sound(problem)
    return AnytimePlanner(Kernel(), tables_of(problem)).first()


def test_wishes_hold_between_all_wires_of_two_choices(problem):
    text = "prefer: [{name: blue, pick: {colour: blue, heavy: false}, before: [w0, w1], weight: 7}]"
    added = preferred(problem, text).problem.wishes[len(problem.wishes) :]
    blue = [w.name for w in problem.wires if w.colour == "blue" and not w.heavy]
    assert added == tuple(Wish(b, o, 7, "blue") for b in blue for o in ("w0", "w1") if b != o)


def test_weights_replace_only_those_named(problem):
    weights = preferred(problem, "weights: {tool: 99}").problem.weights
    assert weights == replace(problem.weights, tool=99)


def test_a_preferred_arm_is_set_and_its_reason_kept(problem):
    text = "prefer: [{name: by the left, pick: {component: c3}, with_arm: L}]"
    result = preferred(problem, text)
    chosen = [w for w in problem.wires if any(n.startswith("c3") for n in w.terminals)]
    assert set(result.arm_reasons) == {wire.name for wire in chosen}
    assert all(result.problem.wire[wire.name].preferred_arm == "L" for wire in chosen)


def test_requirements_bind_the_plan(problem):
    text = """
        require:
          - {name: first, route: w9, before: {colour: white}}
          - {name: keep right, arm: R, x_mm: [100, 620]}
          - {name: power rail, avoid_segment: h9:9}
    """
    bound = preferred(problem, text).problem
    assert bound.arms[1].reach_mm == (240, 620)
    plan = planned(bound).plan
    assert check(bound, plan).valid
    routed = {a.wire: a.start_ticks for a in plan.actions if a.kind is ActionKind.ROUTE}
    white = [w.name for w in problem.wires if w.colour == "white"]
    assert white
    assert all(routed["w9"] < routed[name] for name in white)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("wishes: []", "wishes: no such field; there are format, zones, weights, prefer, require"),
        ("weights: {speed: 3}", "weights.speed: no such field"),
        ("prefer: [{name: x, pick: w99, before: w1, weight: 1}]", r"prefer\[0\].pick: no wire w99"),
        ("prefer: [{name: x, pick: [3], before: w1, weight: 1}]", r"prefer\[0\].pick: no wire 3"),
        ("prefer: [{name: x, pick: w1, before: w2}]", r"prefer\[0\].weight: expected a value"),
        ("prefer: [{name: x, pick: w1, before: w2, weight: 0}]", r"weight: expected an integer"),
        ("prefer: [{name: x, pick: w1, with_arm: Z}]", r"with_arm: expected one of L, R"),
        ("prefer: [{name: x, pick: {colour: pink}, before: w1, weight: 1}]", "at least one wire"),
        ("prefer: [{name: x, pick: {size: 1}, before: w1, weight: 1}]", "size: no such field"),
        ("require: [{name: x, route: w1, over: w2}]", r"require\[0\].over: no such field"),
        ("require: [{name: x, arm: R, x_mm: 3}]", r"x_mm: expected two integers"),
        (
            "require: [{name: no rail, avoid_segment: 'h1:1'}]",
            "`no rail`: .* are routed through segment",
        ),
    ],
)
def test_entries_that_cannot_be_kept_are_refused(problem, text, message):
    with pytest.raises(InstanceError, match=message):
        preferred(problem, text)


def test_a_requirement_against_the_design_is_a_cycle(problem):
    under = problem.unders[0]
    text = f"require: [{{name: x, route: {under.after}, before: {under.before}}}]"
    with pytest.raises(InstanceError, match="cyclic precedence"):
        require_sound(preferred(problem, text).problem)


class FakeMender:
    """Finds that the first change saves 1, the next one costs nothing, and so on."""

    def __init__(self):
        self.asked = -2

    def picked_before(self, first, second):
        self.asked += 1
        return self.asked

    def done_by(self, wire, arm):
        return None if wire.endswith("1") else 7


def test_broken_wishes_are_explained(problem):
    under, *_ = problem.unders
    text = f"""
        prefer:
          - {{name: against the design, pick: {under.after}, before: {under.before}, weight: 50}}
          - {{name: light first, pick: {{heavy: false}}, before: {{heavy: true}}, weight: 1}}
          - {{name: left, pick: {{zone: 3}}, with_arm: L}}
    """
    result = preferred(problem, text)
    plan = planned(result.problem).plan
    verdict = check(result.problem, plan)
    broken = broken_wishes(result.problem, plan)
    lines = "\n".join(explain(result, plan, verdict, FakeMender()))
    assert f"cost {verdict.cost} = makespan {verdict.makespan}" in lines
    assert sum(item.wish.weight for item in broken) == verdict.penalties["soft"]
    chain = f"{under.before} must come before {under.after}"
    assert f"`against the design`: {under.after} should be picked before {under.before}" in lines
    assert f"cannot be kept: {chain}" in lines
    assert "would save 1" in lines
    assert "would cost 0 more in all" in lines
    assert "`left`: " in lines


@settings(max_examples=25, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(st.integers(3, 20), st.integers(0, 999), st.data())
def test_the_list_of_a_plan_gives_the_plan_again_and_can_be_mended(wires, seed, data):
    problem = problem_from(random_panel(wires, seed, 2))
    first_plan = planned(problem)
    listing = listing_of(problem, first_plan.plan)
    modes = first_plan.modes.tolist()
    names = first_plan.tables.wires
    assert listing.modes == {n: Mode.numbered(m) for n, m in zip(names, modes, strict=True)}
    first, second = data.draw(st.permutations(listing.wires))[:2]
    order = list(wire_order(problem))
    needed = {first}
    for _ in order:
        needed |= {before for before, after in order if after in needed}
    assume(second not in needed)
    mended = listing.with_first_before(problem, first, second).wires
    assert sorted(mended) == sorted(listing.wires)
    assert mended.index(first) < mended.index(second)
