"""Orders of cable trees satisfy the constraints, cost what the plain count says, and are best."""

import itertools
import random
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from remodel_cable_tree.cable_tree_planner import (
    Feasibility,
    KernelCableTree,
    contradiction,
    sequence,
)
from remodel_cable_tree.problem import (
    CableTree,
    constraints_of,
    cost_of,
    parse_cable_tree,
    rounds,
    violations,
    with_constraints,
)
from remodel_production.errors import InstanceError

# Small searches have done all their work long before; the clock must not decide a test.
LONG_S = 60.0
DATA = Path(__file__).parent / "data"


def random_tree(ends, seed, *, hidden_order=True):
    """Draw a cable tree; with a hidden order that satisfies its constraints, or without."""
    rng = random.Random(seed)
    cables = rng.randrange(ends // 2 + 1)
    order = list(range(1, ends + 1))
    rng.shuffle(order)
    place = {end: i for i, end in enumerate(order)}

    def pair():
        x, y = rng.sample(order, 2)
        return (x, y) if not hidden_order or place[x] < place[y] else (y, x)

    def any_pair():
        return tuple(rng.sample(order, 2))

    direct = [
        end
        for end in range(1, 2 * cables + 1)
        if rng.random() < 0.3
        and not (hidden_order and (place[(end - 1 + cables) % (2 * cables) + 1]) - place[end] > 1)
    ]
    count = rng.randrange(ends)
    return CableTree(
        ends,
        cables,
        tuple(pair() for _ in range(count)),
        tuple((*pair(), *any_pair()) for _ in range(count)),
        soft=tuple(any_pair() for _ in range(ends // 2)),
        direct=tuple(direct),
    )


def orders(tree):
    """Return all orders that satisfy the constraints."""
    every = itertools.permutations(range(1, tree.ends + 1))
    return [order for order in every if not any(violations(tree, order))]


@given(st.integers(2, 6), st.integers(0, 10**6), st.booleans())
def test_small_trees_get_the_best_order_or_a_proof(ends, seed, hidden_order):
    tree = random_tree(ends, seed, hidden_order=hidden_order)
    found = sequence(tree, LONG_S, 1)
    possible = orders(tree)
    if not possible:
        assert found.feasibility is Feasibility.NONE
        return
    assert found.feasibility is Feasibility.FOUND
    least = min(cost_of(tree, order).total for order in possible)
    assert cost_of(tree, found.order).total == least


@given(st.integers(8, 60), st.integers(0, 10**6))
def test_kernel_counts_costs_as_the_reference(ends, seed):
    tree = random_tree(ends, seed)
    kernel = KernelCableTree(tree)
    feasibility, order = kernel.find(100_000)
    assert feasibility is Feasibility.FOUND
    assert not list(violations(tree, order))
    kernel.adopt(order, seed)
    assert kernel.best() == (cost_of(tree, order).total, order)
    before = kernel.best()[0]
    for part in itertools.islice(rounds(ends, 0.2), 3):
        cost = kernel.anneal(part.recipe, 2000, (0.0, 1.0))
        best_cost, best = kernel.best()
        assert cost == best_cost == cost_of(tree, best).total <= before
        assert not list(violations(tree, best))
    gathered = kernel.gather(1000, seed)
    assert gathered is None or not list(violations(tree, gathered))


def test_search_is_the_same_for_the_same_seed():
    tree = random_tree(12, 5)
    first, second = (sequence(tree, LONG_S, 3) for _ in range(2))
    assert first == second


def test_example_gets_its_best_order():
    tree = parse_cable_tree((DATA / "harness.dzn").read_text())
    found = sequence(tree, LONG_S, 1)
    least = min(cost_of(tree, order).total for order in orders(tree))
    assert cost_of(tree, found.order).total == least


def test_example_without_order_is_proved_so():
    tree = parse_cable_tree((DATA / "harness_without_order.dzn").read_text())
    assert sequence(tree, LONG_S, 1).feasibility is Feasibility.NONE


def test_tree_without_ends_has_the_empty_order():
    found = sequence(CableTree(0, 0, (), (), soft=(), direct=()), 0.1, 1)
    assert (found.feasibility, found.order) == (Feasibility.FOUND, ())


def test_search_stops_on_request():
    tree = random_tree(60, 2)
    found = sequence(tree, 3600.0, 1, stopped=lambda: True)
    assert not list(violations(tree, found.order))


def test_costs_are_counted_as_the_paper_says():
    tree = CableTree(6, 3, (), (), soft=((2, 1),), direct=())
    # Cable 1 is stored over 2 and 3, whose ends follow each other.
    cost = cost_of(tree, (1, 2, 5, 3, 6, 4))
    assert (cost.stored, cost.open, cost.longest, cost.soft) == (1, 1, 4, 1)
    assert cost.total == 6**3 + 6**2 + 4 * 6 + 1


def test_violations_are_reported():
    tree = CableTree(4, 2, ((1, 2),), ((1, 2, 4, 3),), soft=(), direct=(1,))
    assert len(list(violations(tree, (2, 3, 4, 1)))) == 2
    assert len(list(violations(tree, (1, 2, 3, 4)))) == 1
    assert list(violations(tree, (1, 1, 2, 3))) == ["not an order of the ends 1 to 4"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("k = 9;", "k = ;", "line 2, column 5: expected an integer, found `;`"),
        ("k = 9;", "k = 9", "line 3, column 1: expected `;`, found `b`"),
        ("b = 4;", "", "nothing is assigned to b"),
        ("b = 4;", "c = 4;", "line 3, column 1: expected one of k, b, "),
        ("b = 4;", "b = 4; b = 4;", "b is assigned twice"),
        ("b = 4;", "b = 5;", r"expected 0 <= 2 b <= k"),
        ("2, 3|", "2, 3, 4|", "line 6, column 2: expected a row of 2 numbers"),
        ("2, 3|", "2, 30|", "AtomicConstraints, row 2: no end 30; ends are 1 to 9"),
        ("[5, 1];", "[5, 1", "expected `,`, found the end"),
        ("[5, 1];", "[5, ?];", r"expected an integer of at most 9 digits"),
    ],
)
def test_malformed_files_are_refused_with_the_place(old, new, message):
    text = (DATA / "harness.dzn").read_text()
    assert old in text
    with pytest.raises(InstanceError, match=message):
        parse_cable_tree(text.replace(old, new))


@pytest.mark.parametrize("seed", range(30))
def test_a_contradiction_has_no_order_and_every_part_of_it_has_one(seed):
    tree = random_tree(6, seed, hidden_order=False)
    found = contradiction(tree, LONG_S)
    assert bool(found) == (not any(orders(tree)))
    assert not found or not any(orders(with_constraints(tree, found)))
    for one in found:
        assert any(orders(with_constraints(tree, [each for each in found if each != one])))


def test_constraints_name_their_table_and_row():
    tree = CableTree(4, 2, ((1, 2),), ((1, 3, 2, 4),), (), (3,))
    assert list(map(str, constraints_of(tree))) == [
        "AtomicConstraints, row 1: end 1 before end 2",
        "DisjunctiveConstraints, row 1: end 1 before end 3, or end 2 before end 4",
        "DirectSuccessors, row 1: the other end of its cable follows end 3 at once if it comes "
        "later",
    ]
    assert with_constraints(tree, constraints_of(tree)) == tree
