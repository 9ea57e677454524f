"""How much the search does, and at which temperatures.

A search is a chain of rounds. Each round anneals from the best plan so far; each is longer than the
one before, up to a length beyond which another round brings more than a longer one. The work is
counted in moves: as many as were asked for, or as follow from the limit of time; a machine too slow
for those is stopped by its clock.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import sqrt


@dataclass(frozen=True)
class Slice:
    """Some moves between two temperatures [ticks], short enough to stop after it at any time."""

    moves: int
    start_temperature: float
    end_temperature: float
    opens_round: bool


# By the number of arms, measured on random panels of 30 to 1000 wires. With two arms a wire moved
# changes a block's whole timing, and costs differ by more.
_TEMPERATURES = {
    1: ((12.0, 0.3), (25.0, 0.4), (50.0, 0.4)),
    2: ((40.0, 2.0), (15.0, 1.0), (25.0, 1.0)),
}
_SHORTEST_ROUND_PER_WIRE = {1: 1_000, 2: 100}
_LONGEST_ROUND_PER_PAIR = 200
# Beyond these a search has found what it will find.
_MOST_MOVES_PER_WIRE = {1: 500_000, 2: 50_000}
_GROWTH = 4
_SLICE_S = 0.02
# Of a search by moves, so that a signal can stop it.
_SLICES = 200
# Of a short search, so that the clock can stop it in time.
_LEAST_SLICES = 10


def first_slice(wires: int, arms: int) -> Slice:
    """Return the moves that improve the first plan before it is shown.

    They take some times as long as its construction, and bring it from 30 % to below 13 % above the
    best known cost with two arms, below 1.2 % with one (benchmarks/planner). With two arms, panels
    of some tens of wires vary most, and get more moves for each wire than larger ones.
    """
    if arms == 1:
        return Slice(100 * wires, 1.0, 0.5, True)
    return Slice(min(10 * wires + min(15 * wires, 360), 5000), 1.0, 0.5, True)


def moves_per_second(wires: int, arms: int) -> float:
    """Return the moves that a search is given for a second.

    About 40 % of what one core of an AMD EPYC of 2024 makes with one arm, 75 % with two.
    """
    if arms == 1:
        return 9e6 / (1 + wires / 1500)
    return 1.3e6 / (1.0 + 0.4 * sqrt(wires))


def slices(wires: int, arms: int, limit_s: float) -> Iterator[Slice]:
    """Yield the slices of a search of that length [s], the next round's after the last one's."""
    allotted = int(limit_s * moves_per_second(wires, arms))
    slice_s = min(_SLICE_S, limit_s / _LEAST_SLICES)
    slice_moves = max(1, int(slice_s * moves_per_second(wires, arms)))
    yield from _rounds(wires, arms, min(allotted, _MOST_MOVES_PER_WIRE[arms] * wires), slice_moves)


def slices_of(wires: int, arms: int, moves: int) -> Iterator[Slice]:
    """Yield the slices of a search of so many moves, which are the same on any machine."""
    yield from _rounds(wires, arms, moves, max(1, moves // _SLICES))


def _rounds(wires: int, arms: int, left: int, slice_moves: int) -> Iterator[Slice]:
    if wires < 2:
        return
    longest = _LONGEST_ROUND_PER_PAIR * wires * wires
    length = min(max(_SHORTEST_ROUND_PER_WIRE[arms] * wires, left // _GROWTH**3), longest)
    turn = 0
    while left > 0:
        # A rest too short for a round of its own lengthens this one.
        length = left if left < length * (1 + 1 / _GROWTH) else length
        start, end = _TEMPERATURES[arms][turn % len(_TEMPERATURES[arms])]
        yield from _round(length, slice_moves, start, end)
        left -= length
        length = min(length * _GROWTH, longest)
        turn += 1


def _round(moves: int, slice_moves: int, start: float, end: float) -> Iterator[Slice]:
    count = max(1, moves // slice_moves)
    ratio = (end / start) ** (1 / count)
    done = 0
    for i in range(count):
        upto = moves * (i + 1) // count
        yield Slice(upto - done, start * ratio**i, start * ratio ** (i + 1), i == 0)
        done = upto
