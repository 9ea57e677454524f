"""What an order of insertions violates and costs.

This checks what the kernel finds, and is its plain reference.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from remodel_cable_tree.core.problem import CableTree


@dataclass(frozen=True)
class OrderCost:
    """What an order costs; the parts in the order of their importance.

    Attributes:
        stored: cables whose ends are not inserted one right after the other.
        open: the most cables that hang open at the insertion of another cable's end.
        longest: time between the ends of a cable, at its longest, less one.
        soft: violated soft constraints.
        total: stored k^3 + open k^2 + longest k + soft.
    """

    stored: int
    open: int
    longest: int
    soft: int
    total: int


def cost_of(tree: CableTree, order: Sequence[int]) -> OrderCost:
    """Return the cost of an order of the ends 1 to k."""
    place = {end: i for i, end in enumerate(order)}
    spans = [
        tuple(sorted((place[cable], place[cable + tree.cables])))
        for cable in range(1, tree.cables + 1)
    ]
    stored = sum(last - first > 1 for first, last in spans)
    times = [time for span in spans for time in span]
    hanging = max((sum(first < t < last for first, last in spans) for t in times), default=0)
    longest = max((last - first - 1 for first, last in spans), default=0)
    soft = sum(place[x] > place[y] for x, y in tree.soft)
    k = tree.ends
    total = ((stored * k + hanging) * k + longest) * k + soft
    return OrderCost(stored, hanging, longest, soft, total=total)


def violations(tree: CableTree, order: Sequence[int]) -> Iterator[str]:
    """Yield the constraints that an order violates, a line each."""
    if sorted(order) != list(range(1, tree.ends + 1)):
        yield f"not an order of the ends 1 to {tree.ends}"
        return
    place = {end: i for i, end in enumerate(order)}
    for x, y in tree.atomic:
        if place[x] >= place[y]:
            yield f"end {x} does not come before end {y}"
    for a, b, c, d in tree.disjunctive:
        if place[a] >= place[b] and place[c] >= place[d]:
            yield f"neither does end {a} come before end {b}, nor end {c} before end {d}"
    for x in tree.direct:
        other = tree.other_end(x)
        if other is not None and place[x] < place[other] != place[x] + 1:
            yield f"end {x} comes first, but end {other} does not follow at once"
