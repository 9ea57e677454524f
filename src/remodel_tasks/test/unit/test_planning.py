"""Every plan is valid by the checker, and the kernel agrees with the plain reference."""

import itertools
import json
import math
import random

import numpy as np
import pytest
from decoder import decode
from failures import after_jam, after_move, remaining_order
from hypothesis import given
from hypothesis import strategies as st
from random_panel import random_panel

from remodel_production.errors import InfeasibleError
from remodel_tasks.core.plan.checker import check
from remodel_tasks.core.problem.defects import opening_of, require_sound
from remodel_tasks.core.problem.instance import plan_data, plan_from, problem_data, problem_from
from remodel_tasks.core.problem.problem import ActionKind, Mode, Plan
from remodel_tasks.core.search import tables_of
from remodel_tasks.edge.anytime_planner import AnytimePlanner, Limits
from remodel_tasks.edge.search_kernel import Kernel

sizes = st.integers(2, 24)
seeds = st.integers(0, 999)
arm_counts = st.sampled_from([1, 2])


@pytest.fixture(scope="module")
def kernel():
    return Kernel()


def random_ranking(wires, rng):
    """Return a ranking of some groups of the wires; some wires may have no rank."""
    groups = [[] for _ in range(rng.randrange(1, 8))]
    for wire in wires:
        rng.choice([[], *groups]).append(wire["id"])
    return {"groups": groups, "weight": rng.randrange(1, 60)}


def panel(wires, seed, arms):
    """Return a random problem; with odd seeds, each wire has durations of its own, and ranks."""
    data = random_panel(wires, seed, arms)
    if seed % 2:
        rng = random.Random(seed)
        for wire in data["wires"]:
            inserts = [rng.randrange(90), rng.randrange(90)]
            wire["handling"] = {"pick": rng.randrange(50), "insert": inserts, "fix": 7}
        data["soft_order"] = [random_ranking(data["wires"], rng) for _ in range(rng.randrange(3))]
        data["weights"]["cable"] = rng.randrange(50)
        for wire in data["wires"]:
            wire["cable"] = rng.choice(["", "", "C1", "C2", "C3"])
    problem = problem_from(data)
    require_sound(problem)
    return problem


def assert_good(planned):
    verdict = check(planned.tables.problem, planned.plan)
    assert verdict.violations == ()
    assert (verdict.makespan, verdict.cost) == (planned.makespan, planned.cost)


def random_list(tables, rng):
    """Draw an order that satisfies the order constraints, with the opening first, and modes."""
    before = {i: set() for i in range(len(tables.wires))}
    for first, second in tables.arrays["under"].tolist():
        before[second].add(first)
    for first, _, second, _ in tables.arrays["pin"].tolist():
        before[second].add(first)
    order = tables.arrays["opening"].tolist()
    while len(order) < len(before):
        order.append(rng.choice([i for i in before if i not in order and before[i] <= set(order)]))
    modes = [rng.choice(tables.modes[name]).number for name in tables.wires]
    return np.array(order, np.int32), np.array(modes, np.int32)


def test_the_wires_before_a_held_one_open_plans_in_the_same_order_in_every_process():
    data = random_panel(6, 0, 2)
    for arm in data["arms"]:
        arm["reach"] = [-9999, 9999]
    data["init"]["arms"][data["arms"][0]["id"]]["holding"] = "w0"
    data["init"]["wires"]["w0"] = {"stage": "held"}
    data["precedence"] = [
        {"type": "under", "before": f"w{number}", "after": "w0"} for number in range(1, 5)
    ]
    assert opening_of(problem_from(data)).wires == ("w1", "w2", "w3", "w4", "w0")


def residual(planned, seed):
    """Return a problem left over after a random failure of a plan; the problem where none is."""
    rng = random.Random(seed)
    plan, problem = planned.plan, planned.tables.problem
    inserts, picks = (
        [i for i, action in enumerate(plan.actions) if action.kind is kind]
        for kind in (ActionKind.INSERT, ActionKind.PICK)
    )
    if not picks or rng.random() < 0.5:
        return after_jam(problem, plan, rng.choice(inserts)) if inserts else problem
    index = rng.choice(picks)
    shift = (rng.randrange(-20, 20), rng.randrange(-40, 40))
    left = after_move(problem, plan, index, rng.choice(problem.components), shift_mm=shift)
    try:
        require_sound(left)
    except InfeasibleError:  # moved out of reach of all arms
        return problem
    return left


@given(sizes, seeds, arm_counts)
def test_kernel_and_reference_do_the_same_with_any_list(kernel, wires, seed, arms):
    rng = random.Random(seed)
    tables = tables_of(panel(wires, seed, arms))
    for _ in range(3):
        order, modes = random_list(tables, rng)
        planned = AnytimePlanner(kernel, tables).patched(order, modes)
        if arms == 1:  # With one arm, patching chooses the first ends.
            modes = planned.modes
        assert planned.order.tolist() == order.tolist()
        names = [tables.problem.wire[tables.wires[i]] for i in order]
        named_modes = {
            name: Mode.numbered(mode)
            for name, mode in zip(tables.wires, modes.tolist(), strict=True)
        }
        reference = decode(tables.problem, names, named_modes)
        assert list(planned.plan.actions) == reference
        assert_good(planned)
        tables = tables_of(residual(planned, rng.random()))


@given(sizes, seeds, arm_counts)
def test_first_and_improved_plans_are_valid_and_never_worse(kernel, wires, seed, arms):
    planner = AnytimePlanner(kernel, tables_of(panel(wires, seed, arms)), seed)
    first = planner.first()
    assert_good(first)
    better = planner.improved(Limits(0.01), first).planned
    assert_good(better)
    assert better.cost <= first.cost


@pytest.mark.parametrize("arms", [1, 2])
def test_costs_that_32_bits_do_not_hold_are_exact(kernel, arms):
    """As of an order of thousands of wires, all pairs of which have a preferred order."""
    data = random_panel(300, 1, arms)
    names = [wire["id"] for wire in data["wires"]]
    data["soft_order"] = [{"groups": [[name] for name in names], "weight": 100_000}]
    tables = tables_of(problem_from(data))
    order, modes = random_list(tables, random.Random(1))
    worst = AnytimePlanner(kernel, tables).patched(order, modes)
    assert worst.cost > 2**31
    assert_good(worst)
    planned = AnytimePlanner(kernel, tables).improved(Limits(math.inf, moves=1000), worst).planned
    assert_good(planned)
    assert planned.cost < worst.cost


@given(st.integers(2, 60), seeds)
def test_costs_counted_move_by_move_are_those_of_the_whole_plan(kernel, wires, seed):
    problem = kernel.load(tables_of(panel(wires, seed, 2)))
    search = problem.search(seed)
    search.construct()
    cost = search.anneal(3000, 40.0, 5.0)
    search.return_to_best()
    assert search.anneal(3000, 20.0, 1.0) <= cost
    cost, order, modes = search.best()
    decoded = problem.decode(order, modes)
    assert cost == decoded.makespan + decoded.penalty - problem.tables.constant


@given(sizes, seeds, arm_counts, st.integers(0, 2**30))
def test_patched_plans_are_valid_and_keep_the_order(kernel, wires, seed, arms, failure):
    planned = AnytimePlanner(kernel, tables_of(panel(wires, seed, arms))).first()
    left = residual(planned, failure)
    require_sound(left)
    tables = tables_of(left)
    patched = AnytimePlanner(kernel, tables).patched(*remaining_order(planned, tables))
    assert_good(patched)
    old = [
        name for name in (planned.tables.wires[i] for i in planned.order) if name in tables.wires
    ]
    assert [tables.wires[i] for i in patched.order] == old


@pytest.mark.parametrize("arms", [1, 2])
def test_same_seed_gives_the_same_plan(kernel, arms):
    tables = tables_of(panel(20, 4, arms))
    plans = {
        tuple(AnytimePlanner(kernel, tables, 7).first().actions.ravel().tolist()) for _ in range(3)
    }
    assert len(plans) == 1


def test_planning_stops_at_the_target(kernel):
    planner = AnytimePlanner(kernel, tables_of(panel(20, 4, 1)))
    first = planner.first()
    assert not planner.improved(Limits(3600.0, target=first.cost), first).complete


def test_planning_stops_on_request(kernel):
    planner = AnytimePlanner(kernel, tables_of(panel(20, 4, 2)))
    result = planner.improved(Limits(3600.0, stopped=lambda: True))
    assert not result.complete
    assert_good(result.planned)


@pytest.mark.parametrize("arms", [1, 2])
def test_small_plans_are_the_best_of_all_orders(kernel, arms):
    """At four wires, four thousand random lists leave none out that matters."""
    tables = tables_of(panel(4, 3, arms))
    planner = AnytimePlanner(kernel, tables)
    rng = random.Random(1)
    least = min(planner.patched(*random_list(tables, rng)).cost for _ in range(4000))
    assert planner.improved(Limits(60.0)).planned.cost <= least


def test_plan_reads_back_as_written(kernel):
    plan = AnytimePlanner(kernel, tables_of(panel(30, 1, 2))).first().plan
    assert plan_from(plan_data(plan)) == plan


def test_plan_of_nothing_is_empty(kernel):
    data = random_panel(3, 1, 1)
    data["wires"], data["precedence"], data["soft_before"] = [], [], []
    tables = tables_of(problem_from(data))
    planned = AnytimePlanner(kernel, tables).improved(Limits(0.01)).planned
    assert planned.plan == Plan(tables.problem.name, ())
    assert planned.cost == 0


@given(sizes, seeds, arm_counts)
def test_a_problem_comes_back_equal_from_its_document(wires, seed, arms):
    kernel = Kernel()
    problem = panel(wires, seed, arms)
    planned = AnytimePlanner(kernel, tables_of(problem)).first()
    for found in (problem, residual(planned, seed)):
        assert problem_from(json.loads(json.dumps(problem_data(found)))) == found


@pytest.mark.parametrize("arms", [1, 2])
def test_the_cores_of_a_cable_are_placed_one_after_another_by_one_arm(kernel, arms):
    data = random_panel(40, 5, arms)
    data["weights"]["cable"] = 600
    data["precedence"] = []
    place = {terminal["id"]: terminal["x"] for terminal in data["terminals"]}
    least, greatest = data["arms"][0]["reach"]
    by_first = [
        wire
        for wire in data["wires"]
        if all(
            least <= x <= greatest for x in (place[wire["a"]], place[wire["b"]], wire["slot"][0])
        )
    ]
    cables = {wire["id"]: f"C{number % 6}" for number, wire in enumerate(by_first[:18])}
    for wire in by_first[:18]:
        wire["cable"] = cables[wire["id"]]
    problem = problem_from(data)
    planner = AnytimePlanner(kernel, tables_of(problem))
    assert check(problem, planner.first().plan).penalties["cable"] == 0
    planned = planner.improved(Limits(math.inf, moves=200_000)).planned
    assert_good(planned)
    picks = [a for a in planned.plan.actions if a.kind is ActionKind.PICK]
    picks.sort(key=lambda action: action.start_ticks)
    runs = []
    for arm in {pick.arm for pick in picks}:
        own = [cables.get(pick.wire, "") for pick in picks if pick.arm == arm]
        runs += [cable for cable, _ in itertools.groupby(own) if cable]
    assert sorted(runs) == sorted(set(cables.values()))
    assert check(problem, planned.plan).penalties["cable"] == 0
