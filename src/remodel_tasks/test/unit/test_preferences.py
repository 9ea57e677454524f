"""What a user prefers and requires reaches the plan, or is refused with the place."""

from dataclasses import replace

import pytest
import yaml
from hypothesis import assume, given
from hypothesis import strategies as st
from random_panel import random_panel

from remodel_production.errors import InstanceError
from remodel_tasks.core.plan.checker import check
from remodel_tasks.core.plan.explanation import explain, listing_of, violated_constraints
from remodel_tasks.core.problem.defects import require_sound
from remodel_tasks.core.problem.instance import problem_from
from remodel_tasks.core.problem.preferences import Preferred, about_wires, apply_preferences
from remodel_tasks.core.problem.problem import ActionKind, Detour, Mode, SoftConstraint, wire_order
from remodel_tasks.core.search import tables_of
from remodel_tasks.edge.anytime_planner import AnytimePlanner
from remodel_tasks.edge.search_kernel import Kernel

HEAD = {"format": "remodel-preferences-1"}


@pytest.fixture(scope="module")
def problem():
    return problem_from(random_panel(30, 1, 2))


def preferred(problem, text):
    return apply_preferences(Preferred(problem), {**HEAD, **yaml.safe_load(text)})


def planned(problem):
    require_sound(problem)
    return AnytimePlanner(Kernel(), tables_of(problem)).first()


def test_preferences_hold_between_all_wires_of_two_choices(problem):
    text = "prefer: [{name: blue, pick: {colour: blue, heavy: false}, before: [w0, w1], weight: 7}]"
    added = preferred(problem, text).problem.soft_constraints[len(problem.soft_constraints) :]
    blue = [w.name for w in problem.wires if w.colour == "blue" and not w.heavy]
    assert added == tuple(
        SoftConstraint(b, o, 7, "blue") for b in blue for o in ("w0", "w1") if b != o
    )


def test_weights_replace_only_those_named(problem):
    weights = preferred(problem, "weights: {tool: 99}").problem.weights
    assert weights == replace(problem.weights, tool=99)


def test_a_preferred_arm_is_set_and_its_reason_kept(problem):
    text = "prefer: [{name: by the left, pick: {component: c3}, with_arm: L}]"
    result = preferred(problem, text)
    chosen = [w for w in problem.wires if any(n.startswith("c3") for n in w.terminals)]
    assert set(result.arm_reasons) == {wire.name for wire in chosen}
    assert all(result.problem.wire[wire.name].preferred_arm == "L" for wire in chosen)


def test_a_required_reach_counts_within_that_of_the_arm(problem):
    text = "require: [{name: keep right, arm: R, x_mm: [100, 620]}]"
    assert preferred(problem, text).problem.arms[1].reach_mm == (240, 620)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "favourites: []",
            "favourites: no such field; there are format, zones, weights, prefer, require",
        ),
        ("weights: {speed: 3}", "weights.speed: no such field"),
        ("prefer: [{name: x, pick: w99, before: w1, weight: 1}]", r"prefer\[0\].pick: no wire w99"),
        ("prefer: [{name: x, pick: [3], before: w1, weight: 1}]", r"prefer\[0\].pick: no wire 3"),
        ("prefer: [{name: x, pick: w1, before: w2}]", r"prefer\[0\].weight: expected a value"),
        ("prefer: [{name: x, pick: w1, before: w2, weight: 0}]", r"weight: expected an integer"),
        ("prefer: [{name: x, pick: w1, with_arm: Z}]", r"with_arm: expected one of L, R"),
        ("prefer: [{name: x, pick: {colour: pink}, before: w1, weight: 1}]", "at least one wire"),
        ("prefer: [{name: x, pick: {size: 1}, before: w1, weight: 1}]", "size: no such field"),
        ("require: [{name: x, route: w1, over: w2}]", r"require\[0\].over: no such field"),
        (
            "require: [{name: odd, route: w1, before: w1}]",
            r"require\[0\]: requirement `odd`: `route` and `before` choose",
        ),
        (
            "require: [{name: x, pick: w1, before: w2}]",
            r"require\[0\]: requires nothing that is known, found name, pick, before; beside "
            r"`name`, give one of: `route` with `before`.*`arm` with.*`avoid_segment`; `insert`",
        ),
        ("require: [{name: x, arm: R, x_mm: 3}]", r"x_mm: expected two integers"),
        ("require: [{name: x, arm: R, out_of: C}]", r"out_of: expected one of "),
        (
            "prefer: [{name: x, pick: all, in_order_of: size, from: least, weight: 1}]",
            "in_order_of: expected one of colour, tool, heavy, zone, found 'size'",
        ),
        ("prefer: [{name: x, pick: {zone: {over: 1}}, before: w1, weight: 1}]", "over: no such"),
        ("prefer: [{name: x, pick: {zone: {at_least: a}}, before: w1, weight: 1}]", "a number"),
        ("prefer: [{name: x, pick: {zone: [[1]]}, before: w1, weight: 1}]", "a value, a list of"),
        (
            "require: [{name: no rail, avoid_segment: 'h1:1'}]",
            "`no rail`: .* are routed through segment",
        ),
    ],
)
def test_entries_that_cannot_be_kept_are_refused(problem, text, message):
    with pytest.raises(InstanceError, match=message):
        preferred(problem, text)


def test_what_a_document_says_about_some_wires_counts_for_them_alone():
    document = yaml.safe_load("""
        format: remodel-preferences-1
        weights: {colour: 4}
        prefer:
          - {name: gone, pick: w9, before: w1, weight: 1}
          - {name: left, pick: [w1, w9], before: all, weight: 2}
          - {name: blue, pick: {colour: blue}, before: w2, weight: 3}
        require:
          - {name: reach, arm: L, x_mm: [0, 9]}
          - {name: away, insert: [w9], force_n: 3}
    """)
    assert about_wires(document, {"w1", "w2"}) == {
        "format": "remodel-preferences-1",
        "weights": {"colour": 4},
        "prefer": [
            {"name": "left", "pick": ["w1"], "before": "all", "weight": 2, "if_any": True},
            {
                "name": "blue",
                "pick": {"colour": "blue"},
                "before": ["w2"],
                "weight": 3,
                "if_any": True,
            },
        ],
        "require": [{"name": "reach", "arm": "L", "x_mm": [0, 9]}],
    }


def test_wires_are_put_in_the_order_of_a_value(problem):
    text = """
        prefer:
          - {name: right first, pick: [w0, w1, w2], in_order_of: zone, from: greatest, weight: 2}
        require: [{name: thick first, route: all, in_order_of: heavy, from: greatest}]
    """
    bound = preferred(problem, text).problem
    zone = {name: problem.wire[name].zone for name in ("w0", "w1", "w2")}
    (ranking,) = bound.rankings
    assert (ranking.weight, ranking.reason) == (2, "right first")
    added = {(w.before, w.after) for w in ranking.constraints()}
    assert added == {(a, b) for a in zone for b in zone if zone[a] > zone[b]}
    thick = {w.name for w in problem.wires if w.heavy}
    under = {(u.before, u.after) for u in bound.unders if u.reason == "thick first"}
    assert under == {(a, b) for a in thick for b in problem.wire if b not in thick}


def test_a_ranking_costs_what_a_soft_constraint_for_each_of_its_pairs_costs(problem):
    text = """
        prefer:
          - {name: left first, pick: all, in_order_of: zone, from: least, weight: 7}
          - {name: by name of colour, pick: all, in_order_of: colour, from: greatest, weight: 3}
    """
    ranked = preferred(problem, text).problem
    pairs = tuple(each for ranking in ranked.rankings for each in ranking.constraints())
    assert len(pairs) == sum(ranking.pairs for ranking in ranked.rankings)
    listed = replace(ranked, rankings=(), soft_constraints=(*ranked.soft_constraints, *pairs))
    for found in (planned(problem), planned(ranked)):
        costs = [check(p, found.plan).cost for p in (ranked, listed)]
        assert costs[0] == costs[1]
        violated = [violated_constraints(p, found.plan) for p in (ranked, listed)]
        assert {(b.soft, b.places) for b in violated[0]} == {
            (b.soft, b.places) for b in violated[1]
        }
    assert check(ranked, planned(ranked).plan).cost < check(ranked, planned(problem).plan).cost


def test_wires_are_chosen_by_characteristics_and_bounds(problem):
    thin = {"section_mm2": 0.5, "shielded": True}
    stated = replace(
        problem,
        wires=tuple(
            replace(w, characteristics=tuple(thin.items())) if w.zone == 1 else w
            for w in problem.wires
        ),
    )
    text = """
        prefer:
          - {name: thin, pick: {section_mm2: {at_most: 1}}, before: w0, weight: 1}
          - {name: shielded, pick: {shielded: true, zone: {at_least: 1}}, before: w0, weight: 1}
          - {name: none, pick: {colour: [pink, gold]}, before: w0, weight: 1, if_any: true}
    """
    added = preferred(stated, text).problem.soft_constraints[len(problem.soft_constraints) :]
    chosen = [w.name for w in problem.wires if w.zone == 1 and w.name != "w0"]
    assert [(w.before, w.reason) for w in added] == [(n, "thin") for n in chosen] + [
        (n, "shielded") for n in chosen
    ]


def test_requirements_of_a_situation_count_in_it_only(problem):
    text = """
        zones: {B: [400, 620]}
        require: [{name: stay away, arm: R, out_of: B, while: operator in B}]
    """
    document = {**HEAD, **yaml.safe_load(text)}
    calm = apply_preferences(Preferred(problem), document)
    assert calm.situations == {"operator in B"}
    assert calm.problem == problem
    tense = apply_preferences(Preferred(problem), document, calm.situations)
    assert tense.problem.arms[1].reach_mm == (problem.arms[1].reach_mm[0], 399)


def test_a_forbidden_segment_is_avoided_by_a_detour(problem):
    wire = next(w for w in problem.wires if w.segments)
    segment = wire.segments[0]
    wires = tuple(
        replace(w, detours=(Detour((segment,), 1), Detour(("elsewhere",), 77, w.handover)))
        for w in problem.wires
    )
    result = preferred(
        replace(problem, wires=wires), f"require: [{{name: rail, avoid_segment: {segment!r}}}]"
    )
    for before, after in zip(wires, result.problem.wires, strict=True):
        if segment in before.segments:
            assert (after.segments, after.route_ticks) == (("elsewhere",), 77)
            assert result.detours[after.name] == "rail"
        else:
            assert after.segments == before.segments
            assert after.name not in result.detours
        assert all(segment not in way.segments for way in after.detours)
    assert check(result.problem, planned(result.problem).plan).valid


def test_a_force_limit_refuses_what_pushes_harder(problem):
    text = "require: [{name: gently, insert: w3, force_n: 20}]"
    with pytest.raises(InstanceError, match="`gently`: the insertion force of wire w3"):
        preferred(problem, text)
    for force_n, accepted in ((20, True), (21, False)):
        wires = tuple(replace(w, insert_force_n=force_n) for w in problem.wires)
        stated = replace(problem, wires=wires)
        if accepted:
            assert preferred(stated, text).problem == stated
        else:
            with pytest.raises(InstanceError, match="w3 is pushed in with 21 N, over 20 N"):
                preferred(stated, text)


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


def test_violated_constraints_are_explained(problem):
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
    violated = violated_constraints(result.problem, plan)
    lines = "\n".join(explain(result, plan, verdict, FakeMender()))
    assert f"cost {verdict.cost} = makespan {verdict.makespan}" in lines
    assert sum(item.soft.weight for item in violated) == verdict.penalties["soft"]
    chain = f"{under.before} must come before {under.after}"
    assert f"`against the design`: {under.after} should be picked before {under.before}" in lines
    assert f"cannot be kept: {chain}" in lines
    assert "would save 1" in lines
    assert "costs the same in all" in lines
    assert "would cost 1 more in all" in lines
    picks = [a.wire for a in plan.actions if a.kind is ActionKind.PICK]
    assert f"order: {' '.join(picks)}\nof 29 neighbours in it, order constraints hold " in lines
    assert "`left`: " in lines


NAMES = [f"w{i}" for i in range(6)]
CHOICES = st.one_of(
    st.just("all"),
    st.sampled_from(NAMES),
    st.lists(st.sampled_from(NAMES), min_size=1, max_size=3, unique=True),
    st.fixed_dictionaries({"zone": st.integers(0, 3)}),
    st.fixed_dictionaries({"colour": st.sampled_from(["blue", "black", "red"])}),
    st.fixed_dictionaries({"heavy": st.booleans()}),
)
VALUES = {
    "in_order_of": st.sampled_from(["zone", "colour", "heavy"]),
    "from": st.sampled_from(["least", "greatest"]),
}
WEIGHT = {"name": st.just("p"), "if_any": st.just(True), "weight": st.integers(1, 30)}
PREFERENCES = st.lists(
    st.one_of(
        st.fixed_dictionaries({**WEIGHT, "pick": CHOICES, "before": CHOICES}),
        st.fixed_dictionaries({**WEIGHT, **VALUES, "pick": CHOICES}),
    ),
    max_size=4,
)
REQUIREMENTS = st.lists(
    st.one_of(
        st.fixed_dictionaries(
            {"name": st.just("r"), "if_any": st.just(True), "route": CHOICES, "before": CHOICES}
        ),
        st.fixed_dictionaries(
            {
                "name": st.just("z"),
                "arm": st.sampled_from(["L", "R"]),
                "x_mm": st.tuples(st.integers(-50, 200), st.integers(300, 900)).map(list),
            }
        ),
    ),
    max_size=2,
)


@given(st.integers(6, 20), st.integers(0, 999), PREFERENCES, REQUIREMENTS)
def test_plans_keep_all_requirements_or_the_document_is_refused(wires, seed, prefer, require):
    problem = problem_from(random_panel(wires, seed, 2))
    document = {**HEAD, "prefer": prefer, "require": require}
    try:
        bound = apply_preferences(Preferred(problem), document).problem
        require_sound(bound)
    except InstanceError as error:
        assert "cyclic precedence" in str(error) or "unreachable" in str(error)
        return
    plan = planned(bound).plan
    assert check(bound, plan).violations == ()
    routed = {
        a.wire: a.start_ticks
        for a in plan.actions
        if a.kind is ActionKind.ROUTE and a.end is not None
    }
    for under in bound.unders:
        assert routed[under.before] < routed[under.after]
    for item in require:
        if "x_mm" in item:
            for action in plan.actions:
                if action.arm == item["arm"] and action.kind is ActionKind.PICK:
                    at = bound.wire[action.wire].slot_mm[0]
                    assert item["x_mm"][0] <= at <= item["x_mm"][1]


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
