"""Make components and wires of the devices and connections that an importer has read.

A point at which several connections meet becomes as many terminals: B2.1, B2.2, ...
A name of a wire that occurs again gets a number: 24, 24#2, ...
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from remodel_production.core.production import (
    Component,
    Mount,
    Pose,
    Role,
    Side,
    Terminal,
    TerminalRef,
    Wire,
)
from remodel_production.errors import DesignError

# A cabinet has thousands of wires, a vehicle's whole harness some ten thousand.
_MOST_CONNECTIONS = 50_000
_LAST_NUMBER = re.compile(r"(\d+)\D*$")


@dataclass(frozen=True)
class Device:
    """A component as read; the terminals follow from the connections.

    Attributes:
        sides: of its points, as far as the design says them.
        kinds: of its points' terminals, as far as the design says them.
        force_limits_n: [N] of insertions at its points, as far as the design says them.
        stays_bare: whether it is a component also if no wire goes to it.
    """

    name: str
    kind: str = ""
    mount: Mount = Mount.PLATE
    role: Role = Role.DEVICE
    part_number: str = ""
    pose: Pose | None = None
    node: str = ""
    sides: Mapping[str, Side] = field(default_factory=dict)
    kinds: Mapping[str, str] = field(default_factory=dict)
    force_limits_n: Mapping[str, float] = field(default_factory=dict)
    stays_bare: bool = False


@dataclass(frozen=True)
class Connection:
    """A wire as read; its ends are points, which other connections may share.

    Attributes:
        name: in the design; empty if it has none.
    """

    a: TerminalRef
    b: TerminalRef
    colour: str
    section_mm2: float
    source: str
    name: str = ""
    length_m: float | None = None
    cable: str = ""
    core: str = ""
    route: tuple[str, ...] = ()


@dataclass(frozen=True)
class Assembly:
    """What devices and connections make, and what was assumed for it."""

    components: tuple[Component, ...]
    wires: tuple[Wire, ...]
    assumptions: tuple[str, ...]


def assemble(devices: Iterable[Device], connections: Sequence[Connection]) -> Assembly:
    """Return the components, in the order of the devices, and the wires.

    Raises:
        DesignError: if there are more connections than any cabinet or vehicle has.
    """
    if len(connections) > _MOST_CONNECTIONS:
        raise DesignError(
            f"{len(connections)} connections found; at most {_MOST_CONNECTIONS} are read: split "
            "the design"
        )
    clamps = _Clamps(end for connection in connections for end in (connection.a, connection.b))
    names, renamed = _wire_names(connections)
    wires = tuple(
        Wire(
            name,
            clamps.take(connection.a),
            clamps.take(connection.b),
            connection.colour,
            section_mm2=connection.section_mm2,
            source=connection.source,
            length_m=connection.length_m,
            cable=connection.cable,
            core=connection.core,
            route=connection.route,
            number=connection.name,
        )
        for name, connection in zip(names, connections, strict=True)
    )
    components: list[Component] = []
    assumed_sides = 0
    for device in devices:
        taken = clamps.of.get(device.name, [])
        assumed_sides += len({point for point, _ in taken} - set(device.sides))
        if taken or device.stays_bare:
            components.append(_component(device, taken))
    assumptions = [*renamed, *clamps.shared()]
    if assumed_sides:
        assumptions.append(
            f"the sides of {assumed_sides} terminals are not given: those with odd numbers open to "
            "the top, the others to the bottom"
        )
    return Assembly(tuple(components), wires, tuple(assumptions))


def unique_name(base: str, taken: Container[str], last: int = 1) -> str:
    """Return the name, with a number if it is taken.

    Args:
        base: the name.
        taken: names.
        last: number that is known to be taken, and all before it.
    """
    name, number = base, last
    while name in taken:
        number += 1
        name = f"{base}#{number}"
    return name


class _Clamps:
    """Gives each connection at a point a terminal of its own."""

    def __init__(self, ends: Iterable[TerminalRef]) -> None:
        self._uses = Counter(ends)
        self._given: Counter[TerminalRef] = Counter()
        self._names: dict[str, set[str]] = defaultdict(set)
        for end in self._uses:
            self._names[end.component].add(end.terminal)
        # By component: point and terminal.
        self.of: dict[str, list[tuple[str, str]]] = defaultdict(list)

    def take(self, end: TerminalRef) -> TerminalRef:
        """Return the terminal for the next connection at a point."""
        name = end.terminal
        if self._uses[end] > 1:
            while name in self._names[end.component]:
                self._given[end] += 1
                name = f"{end.terminal}.{self._given[end]}"
            self._names[end.component].add(name)
        self.of[end.component].append((end.terminal, name))
        return TerminalRef(end.component, name)

    def shared(self) -> Iterable[str]:
        """Return a line for each of the points that got several terminals."""
        for end, count in self._uses.items():
            if count > 1:
                yield f"{end} is given {count} clamps, one for each of its wires"


def _component(device: Device, taken: list[tuple[str, str]]) -> Component:
    terminals = (
        Terminal(
            name,
            device.sides.get(point) or _usual_side(point),
            point if point != name else "",
            device.kinds.get(point, ""),
            insertion_force_limit_n=device.force_limits_n.get(point),
        )
        for point, name in taken
    )
    return Component(
        device.name,
        device.kind,
        tuple(sorted(terminals, key=lambda terminal: _natural_key(terminal.name))),
        device.mount,
        role=device.role,
        part_number=device.part_number,
        pose=device.pose,
        node=device.node,
    )


def _natural_key(name: str) -> tuple[tuple[bool, int, str], ...]:
    """Return a key that puts T2 before T10."""
    return tuple(
        (part.isdecimal(), int(part) if part.isdecimal() else 0, part)
        for part in re.split(r"(\d+)", name)
        if part
    )


def _usual_side(point: str) -> Side:
    """Return the side on which a terminal usually opens (1, 3, 5, A1 supply; 2, 4, 6, A2 load)."""
    match = _LAST_NUMBER.search(point)
    return Side.BOTTOM if match and int(match[1]) % 2 == 0 else Side.TOP


def _wire_names(connections: Sequence[Connection]) -> tuple[list[str], list[str]]:
    """Return the names of the wires, and a line for each name that occurs again."""
    first = {c.name: c for c in reversed(connections) if c.name}
    taken = set(first)
    counts: Counter[str] = Counter()
    names, renamed = [], []
    for number, connection in enumerate(connections, start=1):
        base = connection.name or f"W{number}"
        is_first = first.get(base) is connection
        name = base if is_first else unique_name(base, taken, max(1, counts[base]))
        counts[base] += 1
        if name != base and connection.name:
            where = first[base].source
            renamed.append(
                f"{connection.source}: name {base} occurs before, at {where}; named {name}"
            )
        taken.add(name)
        names.append(name)
    return names, renamed
