"""How much the search for an order does, and at which temperatures.

A round anneals from the best order so far, or from a new one in which cables, taken by chance, have
their ends one right after the other as far as possible. The number of cables stored decides the
cost, and annealing alone rarely finds out of which cables to store; gathering does, and annealing
does the rest. Work is counted in moves, so that the same seed and limit give the same order on
every machine that is not too slow for them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True)
class Recipe:
    """Temperatures, and what each part of the cost weighs while annealing.

    With their true weights, k to k^3, the parts would freeze one after the other; with these, a
    plan may pay with one for another. The best order is chosen by the true cost.

    Attributes:
        weights: of violated constraints, stored cables, open cables, the longest time, violated
            soft constraints.
    """

    start_temperature: float
    end_temperature: float
    weights: tuple[float, float, float, float, float]


# Found on the public instances of 64 to 198 ends; each is the best for some of them.
_RECIPES = (
    Recipe(4.0, 0.05, (50.0, 8.0, 3.0, 0.5, 0.2)),
    Recipe(10.0, 0.03, (100.0, 30.0, 5.0, 0.5, 0.1)),
    Recipe(10.0, 0.05, (50.0, 8.0, 3.0, 0.5, 0.2)),
    Recipe(10.0, 0.03, (50.0, 30.0, 10.0, 1.0, 0.1)),
)


@dataclass(frozen=True)
class Round:
    """One annealing run.

    Attributes:
        gathers: new orders to gather before, of which the best is annealed; 0: anneal the best.
        most_nodes: of the search that completes a gathered order.
    """

    recipe: Recipe
    moves: int
    gathers: int
    most_nodes: int


_MOVES_PER_END = 4_000
# Beyond this a search has found what it will find.
_MOST_MOVES_PER_PAIR = 5_000
# What gathering takes, as moves for each end; the least that was measured is 200, the most 1400.
_GATHER_PER_END = 1_000
_FIRST_GATHERS = 12
# The first gathers get no more than this part of the work.
_FIRST_SHARE = 0.3
# Every third round starts from a new order.
_RESTART = 3
_FEW_NODES, _MANY_NODES = 100, 1_000


def moves_per_second(ends: int) -> float:
    """Return the moves that a search is given for a second.

    55 to 75 % of what one core of an AMD EPYC of 2024 makes.
    """
    return 2.2e7 / math.sqrt(ends)


def rounds(ends: int, limit_s: float) -> Iterator[Round]:
    """Yield the rounds of a search of that length."""
    left = min(limit_s * moves_per_second(ends), _MOST_MOVES_PER_PAIR * ends * ends)
    gather = _GATHER_PER_END * ends
    first_gathers = min(_FIRST_GATHERS, int(left * _FIRST_SHARE / gather))
    moves = max(1, min(_MOVES_PER_END * ends, int(left / 4)))
    turn = 0
    while left > 0:
        gathers = first_gathers if turn == 0 else int(turn % _RESTART == 0)
        nodes = _MANY_NODES if turn % (2 * _RESTART) == 0 else _FEW_NODES
        yield Round(_RECIPES[turn % len(_RECIPES)], moves, gathers, nodes)
        left -= moves + gathers * gather
        turn += 1
