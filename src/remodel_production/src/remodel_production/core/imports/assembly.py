"""Make components and wires of what an importer has read; placements, access to terminals.

A point at which several connections meet becomes as many terminals: B2.1, B2.2, ...
A name of a wire that occurs again gets a number: 24, 24#2, ...

The YAML of a placement says where devices are:

    devices: {S1: door, "M*": outside}     # by their names in the order: plate, door or outside
    symbols: {"*/my_button.elmt": door}    # of QElectroTech, by paths: also reference or drawing

A pattern may hold * for any letters; the first one that fits counts. The file counts more than the
catalogue and the list.

Of all formats, lists alone have columns for the force with which an end may be pushed in; none says
how much room is around a terminal, or from where an end goes in. Each value
filled in is reported as an assumption, and so is each terminal with more wires than it takes.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from fnmatch import fnmatchcase
from typing import TypeVar

from remodel_production.core.catalogue import Catalogue, Place, TerminalRule, full_terminals
from remodel_production.core.imports.documents import Value, parse_yaml, section_of
from remodel_production.core.imports.values import Imported
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
    """Return the name, with a number above `last` if it is taken."""
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


_Word = TypeVar("_Word", bound=Enum)


def with_placement(catalogue: Catalogue, text: str) -> Catalogue:
    """Return a catalogue in which a user's placement counts first.

    Raises:
        DesignError: naming the line, what was found, and what is allowed.
    """
    root = parse_yaml(text).mapping("the placement", known=("devices", "symbols"))
    symbols = tuple((name.lower(), place) for name, place in _entries(root, "symbols", Place))
    return replace(
        catalogue,
        placement=(*symbols, *catalogue.placement),
        mounts=tuple(_entries(root, "devices", Mount)),
    )


def with_mounts(imported: Imported, catalogue: Catalogue) -> Imported:
    """Return the order with its components where the user says that they are."""
    order = imported.order
    components = tuple(
        replace(component, mount=catalogue.mount(component.name) or component.mount)
        for component in order.components
    )
    unknown = (
        f"the placement names {pattern}, and no device is called so"
        for pattern, _ in catalogue.mounts
        if not any(fnmatchcase(component.name, pattern) for component in order.components)
    )
    return replace(imported, order=replace(order, components=components)).assuming(unknown)


def _entries(
    root: dict[str, Value], section: str, words: type[_Word]
) -> Iterator[tuple[str, _Word]]:
    for pattern, value in section_of(root, section).items():
        known = {word.value: word for word in words}
        if value.text not in known:
            raise DesignError(
                f"{value.where}: {section}: {pattern}: {value.shown} found; allowed: "
                f"{', '.join(known)}"
            )
        yield pattern, known[value.text]


# Into the component from the side on which the terminal opens, in the component's frame.
_APPROACHES = {Side.TOP: (0.0, -1.0, 0.0), Side.BOTTOM: (0.0, 1.0, 0.0)}


def with_access(imported: Imported, catalogue: Catalogue) -> Imported:
    """Return the order with approaches, clearances and force limits of all terminals.

    A rule of the catalogue that fits the component decides, the first one of several.
    """
    order = imported.order
    lacking: Counter[str] = Counter()
    components = []
    for component in order.components:
        rule = catalogue.terminal_rule(component)
        lacking.update(_assumed(component, rule))
        terminals = tuple(_filled(terminal, rule) for terminal in component.terminals)
        components.append(replace(component, terminals=terminals))
    assumptions = (
        *(f"{what} (of {count} terminals)" for what, count in lacking.items()),
        *(
            f"{full.reason}; by hand: {', '.join(full.beyond)}"
            for full in full_terminals(order.in_cabinet(), catalogue)
        ),
    )
    filled = replace(order, components=tuple(components))
    return replace(imported, order=filled).assuming(assumptions)


def _filled(terminal: Terminal, rule: TerminalRule) -> Terminal:
    limit, clearance = terminal.insertion_force_limit_n, terminal.clearance_m
    return replace(
        terminal,
        approach=terminal.approach or _APPROACHES[terminal.side],
        clearance_m=rule.clearance_m if clearance is None else clearance,
        insertion_force_limit_n=rule.force_limit_n if limit is None else limit,
    )


def _assumed(component: Component, rule: TerminalRule) -> Counter[str]:
    """Return a line for each assumed value, and for how many terminals."""
    kind = f"{component.role.value}s"
    force = f"insertion force limit not given, {rule.force_limit_n:g} N taken for {kind}"
    clearance = f"clearance not given, {1e3 * rule.clearance_m:g} mm taken for {kind}"
    approach = "approach not given, that from the side on which they open taken"
    lines: Counter[str] = Counter()
    for terminal in component.terminals:
        lines[force] += terminal.insertion_force_limit_n is None
        lines[clearance] += terminal.clearance_m is None
        lines[approach] += terminal.approach is None
    return +lines
