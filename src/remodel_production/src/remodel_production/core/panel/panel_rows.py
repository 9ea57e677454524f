"""Assign an order's components to rows, and order each row, its components and its clamps.

Between two rows lies a channel, into which the bottom terminals of the upper row and the top
terminals of the lower row open. A wire can be placed if both its ends open into the same channel:

    bottom of u to top of v        v stands one row below u
    top to top, bottom to bottom   u and v stand in the same row

which fixes the row of every component relative to those it is wired to.

Within a row, components follow the mean rank of those they are wired to in the row above, and the
clamps of one point follow their wires' other ends (the barycentre heuristic of layered drawings;
Sugiyama et al., IEEE Trans. SMC 11(2), 1981), so that wires run side by side and few cross.
"""

from __future__ import annotations

from collections import defaultdict, deque
from dataclasses import replace
from statistics import fmean

from remodel_production.core.production import Component, Order, Side, Terminal, TerminalRef, Wire
from remodel_production.errors import LayoutError

Row = tuple[Component, ...]


def ordered_rows(order: Order, most: int) -> tuple[Row, ...]:
    """Return the rows, upmost first, each from left to right with its clamps from left to right.

    Raises:
        LayoutError: if wires contradict each other on the rows, or there are more than `most`.
    """
    partners: dict[TerminalRef, TerminalRef] = {}
    for wire in order.wires:
        partners[wire.a], partners[wire.b] = wire.b, wire.a
    rows: list[Row] = []
    for index, members in enumerate(_rows(order, most)):
        above = {component.name: rank for rank, component in enumerate(rows[-1] if rows else ())}
        rows.append(_ordered_row(members, above, partners, left=is_left(index)))
    position = _positions(rows)
    return tuple(
        tuple(_with_ordered_clamps(component, partners, position) for component in row)
        for row in rows
    )


def is_left(row: int) -> bool:
    """Return whether a row stands to the left of its neighbours, or else to the right.

    So every wire between two rows runs along their channel: a short wire between two
    terminals face to face is a stiff loop, which springs back from the hand.
    """
    return row % 2 == 0


def _rows(order: Order, most: int) -> list[Row]:
    """Return the components of each row in the order's order."""
    sides = {
        TerminalRef(component.name, terminal.name): terminal.side
        for component in order.components
        for terminal in component.terminals
    }
    steps: dict[str, list[tuple[str, int, Wire]]] = defaultdict(list)
    for wire in order.wires:
        step = (sides[wire.a] is Side.BOTTOM) - (sides[wire.b] is Side.BOTTOM)
        steps[wire.a.component].append((wire.b.component, step, wire))
        steps[wire.b.component].append((wire.a.component, -step, wire))
    row: dict[str, int] = {}
    for component in order.components:
        if component.name not in row:
            group = _group_rows(component.name, steps)
            top = min(group.values())
            row.update({name: value - top for name, value in group.items()})
    count = max(row.values()) + 1
    if count > most:
        raise LayoutError(
            f"order {order.name}: its wires need {count} rows of components one below the other; "
            f"the panel has {most}: choose fewer wires"
        )
    return [tuple(c for c in order.components if row[c.name] == index) for index in range(count)]


def _group_rows(start: str, steps: dict[str, list[tuple[str, int, Wire]]]) -> dict[str, int]:
    """Return the rows, relative to the first, of all components wired to each other."""
    row = {start: 0}
    queue = deque([start])
    while queue:
        name = queue.popleft()
        for other, step, wire in steps[name]:
            expected = row[name] + step
            if other not in row:
                row[other] = expected
                queue.append(other)
            elif row[other] != expected:
                raise LayoutError(
                    f"wire {wire.name} ({wire.a} to {wire.b}, {wire.source}): the other wires put "
                    f"{other} {row[other] - row[name]} row(s) below {name}, where its two ends do "
                    "not open into one channel; this cell cannot route it around a row"
                )
    return row


def _ordered_row(
    members: Row,
    above: dict[str, int],
    partners: dict[TerminalRef, TerminalRef],
    *,
    left: bool,
) -> Row:
    """Return a row from left to right.

    Components wired only within their row stand on its inner side, where they don't push those that
    are wired to other rows away from their side.
    """
    names = {component.name for component in members}

    def key(component: Component) -> tuple[bool, float]:
        others = [partners[_ref(component, terminal)].component for terminal in component.terminals]
        inner = all(other in names for other in others)
        ranks = [above[other] for other in others if other in above]
        return inner is left, fmean(ranks) if ranks else 0.0

    return tuple(sorted(members, key=key))


def _positions(rows: list[Row]) -> dict[TerminalRef, tuple[int, int]]:
    """Return for each terminal its component's and its own rank, from left to right."""
    return {
        _ref(component, terminal): (rank, index)
        for row in rows
        for rank, component in enumerate(row)
        for index, terminal in enumerate(component.terminals)
    }


def _with_ordered_clamps(
    component: Component,
    partners: dict[TerminalRef, TerminalRef],
    position: dict[TerminalRef, tuple[int, int]],
) -> Component:
    """Return the component with the clamps of each point in the order of their wires' other ends.

    Points keep their places, as on the device.
    """
    points = list(dict.fromkeys(_point(terminal) for terminal in component.terminals))

    def key(terminal: Terminal) -> tuple[int, tuple[int, int]]:
        partner = partners[_ref(component, terminal)]
        return points.index(_point(terminal)), position[partner]

    return replace(component, terminals=tuple(sorted(component.terminals, key=key)))


def _point(terminal: Terminal) -> str:
    return terminal.point or terminal.name


def _ref(component: Component, terminal: Terminal) -> TerminalRef:
    return TerminalRef(component.name, terminal.name)
