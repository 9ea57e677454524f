r"""Where connectors stand: at the end of a bundle, or facing each other so that wires fit.

┌──┐ 1                 Seen from its wires, each row has its first connector on the left, and
│X1│ 2 ──\   /── ┌──┐  so has each connector its first cavity. So wires between equal cavities
└──┘ 3 ──  \ /   │X2│  of two rows that face each other meet halfway.

A wire that is let down into forks is a little longer than the line between its openings
(`SPARE_M`). So the lengths are distances between the connectors, and placing these is
multidimensional scaling: the places are sought whose distances differ least from the wires'
lengths, in the sense of least squares. It is solved by majorization (SMACOF: J. de Leeuw,
"Applications of convex analysis to multidimensional scaling", 1977; I. Borg, P. Groenen, "Modern
Multidimensional Scaling", 2nd edition, 2005, chapter 8), one connector after the other: each goes
to the mean of the places to which its wires' lengths, along their present directions, lead from
their other ends. No step increases the sum of squares, as long as no wire leads aside too far
(`aside` of the catalogue). Wires between the same connectors are one bundle with one distance.

Connectors keep their places across the trunk at first, and move along it. That solves every harness
whose bundles close no ring. Where the lengths around a ring do not fit so, connectors move across,
too. A ring in which one bundle is longer than all others together has no solution (the triangle
inequality): the others are placed, and its wires do not fit (`too_long`).
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from remodel_production.core.catalogue import FormboardRules
from remodel_production.core.production import Component, TerminalRef, Wire
from remodel_states.core.cell import SPARE_M

Point = tuple[float, float]


@dataclass(frozen=True)
class Row:
    """A row of connectors [m]: along it, what is at the left as seen from the wires is negative.

    Attributes:
        widths: of the connectors, by name.
        middles: of the connectors, by name.
        cavities: where each cavity is.
    """

    widths: Mapping[str, float]
    middles: Mapping[str, float]
    cavities: Mapping[TerminalRef, float]


def row_of(components: Sequence[Component], pitch: float, gap: float) -> Row:
    """Return connectors beside each other, with a pitch of their cavities and gaps between [m]."""
    widths = {c.name: max(1, len(c.terminals)) * pitch for c in components}
    left = -(sum(widths.values()) + gap * (len(components) - 1)) / 2
    middles: dict[str, float] = {}
    cavities: dict[TerminalRef, float] = {}
    for component in components:
        middle = left + widths[component.name] / 2
        middles[component.name] = middle
        for index, terminal in enumerate(component.terminals):
            aside = (index - (len(component.terminals) - 1) / 2) * pitch
            cavities[TerminalRef(component.name, terminal.name)] = middle + aside
        left += widths[component.name] + gap
    return Row(widths, middles, cavities)


@dataclass(frozen=True)
class Stand:
    """The end of a bundle, at which a row of connectors stands.

    Attributes:
        end: [m] of the bundle, in the plane of the openings.
        heading: in which the bundle leaves [rad].
    """

    end: Point
    heading: float

    @property
    def turn(self) -> float:
        """The angle by which a connector is turned that opens to the bottom of the board [rad]."""
        return math.remainder(self.heading + math.pi / 2, 2 * math.pi)

    def place(self, along: float, behind: float) -> Point:
        """Return what is so far along the row, and so far behind the openings [m]."""
        out_x, out_y = math.cos(self.heading), math.sin(self.heading)
        x, y = self.end
        # Seen from the bundle, the row goes on to the right.
        return (
            x - behind * out_x + along * out_y,
            y - behind * out_y - along * out_x,
        )


# Rounds of the majorization, and the least step that another round is worth [m].
_ROUNDS = 2000
_LEAST_STEP_M = 1e-7
_MOST_SHIFTS = 40


@dataclass(frozen=True)
class FacingConnector:
    """A connector: the middle of its face along the trunk and across, to the left [m].

    Attributes:
        is_left: whether it opens to the right.
        width: across the trunk [m].
        depth: behind its face [m].
    """

    name: str
    is_left: bool
    x: float
    y: float
    width: float
    depth: float

    @property
    def back(self) -> float:
        """Where along the trunk it begins [m]."""
        return self.x - self.depth if self.is_left else self.x

    @property
    def front(self) -> float:
        """Where along the trunk it ends [m]."""
        return self.x if self.is_left else self.x + self.depth


@dataclass(frozen=True)
class Facing:
    """Connectors in two rows that face each other.

    Attributes:
        stands: of the connectors, by name.
        cavities: of each opening, how far it is across the trunk from its connector's middle [m].
    """

    stands: Mapping[str, FacingConnector]
    cavities: Mapping[TerminalRef, float]

    def ends(self, wire: Wire) -> tuple[FacingConnector, FacingConnector]:
        """Return the connectors of a wire, the left one first."""
        a, b = self.stands[wire.a.component], self.stands[wire.b.component]
        return (a, b) if a.is_left else (b, a)

    def along(self, wire: Wire) -> float:
        """Return how far a wire leads along the trunk [m]."""
        left, right = self.ends(wire)
        return right.x - left.x

    def across(self, wire: Wire) -> float:
        """Return how far a wire leads across the trunk [m]."""
        return self._y(_right(wire, self.stands)) - self._y(_left(wire, self.stands))

    def distance(self, wire: Wire) -> float:
        """Return the distance between the openings of a wire [m]."""
        return math.hypot(self.along(wire), self.across(wire))

    def aside(self, wire: Wire, x: float) -> float:
        """Return where a wire that runs straight passes a place of the trunk [m]."""
        left, _ = self.ends(wire)
        share = (x - left.x) / max(self.along(wire), 1e-9)
        return self._y(_left(wire, self.stands)) + share * self.across(wire)

    def unfit(self, wires: Sequence[Wire]) -> int:
        """Return how many wires are too long or too short for the distance of their openings."""
        least, most = SPARE_M
        return sum(
            not least - 1e-6 <= wire.length_m - self.distance(wire) <= most + 1e-6
            for wire in wires
            if wire.length_m is not None
        )

    def moved(self, places: Mapping[str, tuple[float, float]]) -> Facing:
        """Return the connectors at other places [m]."""
        return replace(
            self,
            stands={
                name: replace(stand, x=round(places[name][0], 6), y=round(places[name][1], 6))
                for name, stand in self.stands.items()
            },
        )

    def _y(self, ref: TerminalRef) -> float:
        return self.stands[ref.component].y + self.cavities[ref]


def too_long(wires: Sequence[Wire]) -> dict[tuple[str, str], tuple[str, ...]]:
    """Return the bundles that are longer than the others of a ring together.

    Returns:
        By the connectors of each of them, those that the others lead past, from end to end.
    """
    least, most = SPARE_M
    lengths: dict[tuple[str, str], float] = {}
    for wire in wires:
        if wire.length_m is not None:
            a, b = sorted((wire.a.component, wire.b.component))
            lengths[a, b] = min(wire.length_m, lengths.get((a, b), math.inf))
    found: dict[tuple[str, str], tuple[str, ...]] = {}
    for (a, b), length in sorted(lengths.items(), key=lambda each: -each[1]):
        others = {k: v - least for k, v in lengths.items() if k != (a, b) and k not in found}
        reach, path = _shortest(others, a).get(b, (math.inf, ()))
        if length - most > reach:
            found[a, b] = path
    return found


def _shortest(
    lengths: Mapping[tuple[str, str], float], start: str
) -> dict[str, tuple[float, tuple[str, ...]]]:
    """Return how far each connector is from one along bundles [m], and the connectors passed."""
    found: dict[str, tuple[float, tuple[str, ...]]] = {start: (0.0, (start,))}
    queue = [start]
    for name in queue:
        far, path = found[name]
        for (a, b), length in lengths.items():
            other = {a: b, b: a}.get(name)
            if other is not None and far + length < found.get(other, (math.inf, ()))[0]:
                found[other] = (far + length, (*path, other))
                queue.append(other)
    return found


def _left(wire: Wire, stands: Mapping[str, FacingConnector]) -> TerminalRef:
    return wire.a if stands[wire.a.component].is_left else wire.b


def _right(wire: Wire, stands: Mapping[str, FacingConnector]) -> TerminalRef:
    return wire.b if stands[wire.a.component].is_left else wire.a


def placed(
    components: Sequence[Component],
    is_left: Mapping[str, bool],
    wires: Sequence[Wire],
    depths: Mapping[str, float],
    rules: FormboardRules,
) -> Facing:
    """Return where connectors stand.

    Args:
        components: that are wired, with their wired terminals, in the order of their rows.
        is_left: by their names, whether they stand on the left.
        wires: from one side to the other.
        depths: of the connectors [m].
        rules: of formboards.
    """
    stands: dict[str, FacingConnector] = {}
    cavities: dict[TerminalRef, float] = {}
    for side in (True, False):
        row = row_of(
            [c for c in components if is_left[c.name] is side],
            rules.cavity_pitch,
            rules.connector_gap,
        )
        # Seen from its wires, a row's left is negative; seen from above the rows are turned.
        sign = -1.0 if side else 1.0
        for name, middle in row.middles.items():
            stands[name] = FacingConnector(
                name, side, 0.0, round(sign * middle, 6), row.widths[name], depths[name]
            )
        for ref, place in row.cavities.items():
            cavities[ref] = sign * (place - row.middles[ref.component])
    long = too_long(wires)
    wires = [
        replace(wire, length_m=None)
        if tuple(sorted((wire.a.component, wire.b.component))) in long
        else wire
        for wire in wires
    ]
    facing = _with_room(_along(Facing(stands, cavities), wires, rules), wires, rules)
    if facing.unfit(wires):
        across = _scaled(facing, wires, rules)
        blocked = next(_blocked(across, wires, rules), None) or _overlaps(across, rules)
        if not blocked and across.unfit(wires) < facing.unfit(wires):
            return across
    return facing


def _along(facing: Facing, wires: Sequence[Wire], rules: FormboardRules) -> Facing:
    """Return the connectors where the wires' lengths ask for along the trunk."""
    bundles = _bundles(facing, wires, rules)
    known = [length for length in bundles.values() if length is not None]
    usual = max(min(known, default=rules.trunk), rules.fork_spacing)
    beside: dict[str, list[tuple[str, float | None]]] = defaultdict(list)
    for (left, right), length in bundles.items():
        beside[left].append((right, length))
        beside[right].append((left, None if length is None else -length))
    xs: dict[str, float] = {}
    for root in facing.stands:
        if root in xs:
            continue
        xs[root] = 0.0 if facing.stands[root].is_left else usual
        queue = [root]
        while queue:
            # Bundles of a known length first.
            options = [(name, other, step) for name in queue for other, step in beside[name]]
            options = [each for each in options if each[1] not in xs]
            if not options:
                break
            name, other, step = min(options, key=lambda each: each[2] is None)
            default = usual if facing.stands[name].is_left else -usual
            xs[other] = xs[name] + (default if step is None else step)
            queue.append(other)
    for _ in range(_ROUNDS):
        most = 0.0
        for name, others in beside.items():
            wanted = [xs[other] - step for other, step in others if step is not None]
            if wanted:
                moved = sum(wanted) / len(wanted)
                most = max(most, abs(moved - xs[name]))
                xs[name] = moved
        if most < _LEAST_STEP_M:
            break
    first = min(xs.values())
    return facing.moved({n: (xs[n] - first, stand.y) for n, stand in facing.stands.items()})


def _bundles(
    facing: Facing, wires: Sequence[Wire], rules: FormboardRules
) -> dict[tuple[str, str], float | None]:
    """Return how far the wires between two connectors lead along the trunk, the shortest [m].

    None where no length is known.
    """
    found: dict[tuple[str, str], float | None] = {}
    for wire in wires:
        left, right = facing.ends(wire)
        key = (left.name, right.name)
        if wire.length_m is None:
            found.setdefault(key, None)
            continue
        straight = wire.length_m - rules.wire_slack
        length = math.sqrt(max(0.0, straight**2 - facing.across(wire) ** 2))
        known = found.get(key)
        found[key] = max(rules.fork_spacing, length if known is None else min(length, known))
    return found


def _with_room(facing: Facing, wires: Sequence[Wire], rules: FormboardRules) -> Facing:
    """Return the connectors with room in their rows for the wires that pass them."""
    for _ in range(_MOST_SHIFTS):
        found = next(_blocked(facing, wires, rules), None)
        if found is None:
            break
        near, far, shift = found
        away = math.copysign(shift, far.y - near.y)
        places = {
            name: (
                stand.x,
                stand.y + away
                if stand.is_left is near.is_left and (stand.y - near.y) * away > 0
                else stand.y,
            )
            for name, stand in facing.stands.items()
        }
        facing = _along(facing.moved(places), wires, rules)
    return facing


def _blocked(
    facing: Facing, wires: Sequence[Wire], rules: FormboardRules
) -> Iterator[tuple[FacingConnector, FacingConnector, float]]:
    """Yield connectors that stand in the way of a wire, its own one beside, and how far [m].

    The last one is by how much the wire's own connector has to be farther from the other one.
    """
    for wire in wires:
        ends = facing.ends(wire)
        for near in facing.stands.values():
            far = ends[0] if near.is_left else ends[1]
            first, last = max(near.back, ends[0].x), min(near.front, ends[1].x)
            if near in ends or first >= last:
                continue
            room = near.width / 2 + rules.wires_beside
            side = math.copysign(1.0, far.y - near.y)
            for x in (first, last):
                lack = room - side * (facing.aside(wire, x) - near.y)
                if lack > 1e-6:
                    share = abs(x - ends[1 - (far is ends[1])].x) / max(facing.along(wire), 1e-9)
                    yield near, far, lack / max(share, 0.2)


def _overlaps(facing: Facing, rules: FormboardRules) -> bool:
    stands = list(facing.stands.values())
    return any(
        one.back < other.front + rules.connector_gap
        and other.back < one.front + rules.connector_gap
        and abs(one.y - other.y) < (one.width + other.width) / 2 + rules.connector_gap
        for i, one in enumerate(stands)
        for other in stands[:i]
    )


def _scaled(facing: Facing, wires: Sequence[Wire], rules: FormboardRules) -> Facing:
    """Return the connectors where the wires' lengths ask for along and across the trunk."""
    spare = sum(SPARE_M) / 2
    known = [(w, w.length_m - spare) for w in wires if w.length_m is not None]
    places = {name: (stand.x, stand.y) for name, stand in facing.stands.items()}
    pulls: dict[str, list[tuple[TerminalRef, TerminalRef, float]]] = defaultdict(list)
    for wire, length in known:
        pulls[wire.a.component].append((wire.a, wire.b, length))
        pulls[wire.b.component].append((wire.b, wire.a, length))
    for _ in range(_ROUNDS):
        most = 0.0
        for name, wanted in pulls.items():
            x, y = places[name]
            to_x = to_y = 0.0
            for own, other, length in wanted:
                ox, oy = places[other.component]
                aside = facing.cavities[own] - facing.cavities[other]
                dx, dy = x - ox, y + aside - oy
                # No further aside than a hand inserts a wire.
                dy = max(-rules.aside * abs(dx), min(rules.aside * abs(dx), dy))
                away = max(math.hypot(dx, dy), 1e-9)
                to_x += ox + length * dx / away
                to_y += oy - aside + length * dy / away
            moved = (to_x / len(wanted), to_y / len(wanted))
            most = max(most, math.dist(moved, (x, y)))
            places[name] = moved
        if most < _LEAST_STEP_M:
            break
    first = min(x for x, _ in places.values())
    return facing.moved({name: (x - first, y) for name, (x, y) in places.items()})
