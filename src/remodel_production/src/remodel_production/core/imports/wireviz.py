"""Import a WireViz harness: connectors, cables, and sets of connections, in YAML.

A connection set is a list of items that are by turns of the connectors and of the cables. An item
stands for one connection or for several parallel ones:

    X1: [1-3, GND]      pins of a connector, cores of a cable (by number, label, colour; s: shield)
    X1                  a connector's only pin, in all of them
    T.X1, T.            an instance of template T with a name; a new one in each connection
    [F1, F2, T.]        one for each connection
    -->, ==>            pins, or connectors, that mate: no wire

Each lane makes wires of the cables' cores between neighbouring pins. A core whose ends two sets
name one each is one wire.

The syntax is WireViz' own (docs/syntax.md of version 0.4).
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from difflib import get_close_matches

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.imports.assembly import Connection, Device, assemble
from remodel_production.core.imports.design_format import JoinedFile
from remodel_production.core.imports.documents import Value, decode, parse_yaml, section_of
from remodel_production.core.imports.values import (
    Account,
    Assumptions,
    Imported,
    LeftOut,
    length_m,
    names_splice,
)
from remodel_production.core.imports.wireviz_parts import (
    SHIELD,
    CablePart,
    ConnectorPart,
    cable_part,
    connector_part,
    omitted_parts,
)
from remodel_production.core.production import Cable, Order, Role, TerminalRef
from remodel_production.errors import DesignError

_ARROW = re.compile(r"<?(-+|=+)>?")
_DEFAULT_SEPARATOR = "."
_MOST_LANES = 2000


@dataclass(frozen=True)
class _Port:
    """A pin of a connector, or a core of a cable."""

    part: str
    key: str
    is_cable: bool
    line: int


@dataclass
class _Core:
    """A core's ends as far as sets have named them."""

    left: TerminalRef | None
    right: TerminalRef | None
    line: int


# The key of a section at the top of a file, and what it begins with once another replaces it.
_SECTION = re.compile(r"^([A-Za-z_]\w*)(?=\s*:)", re.MULTILINE)
_REPLACED = "replaced_"


def import_wireviz(data: bytes, name: str, source: str, catalogue: Catalogue) -> Imported:
    """Read a harness; arguments are those of `DesignFormat.read`.

    Raises:
        DesignError: if the file is no WireViz harness, or refers to what is not there.
    """
    text, assumed_encoding = decode(data)
    root = parse_yaml(text).mapping("the file")
    if "connections" not in root:
        found = ", ".join(list(root)[:10]) or "nothing"
        raise DesignError(
            f"line 1: found {found}; a WireViz harness has `connectors`, `cables` and `connections`"
        )
    reader = _Reader(root, catalogue)
    if assumed_encoding:
        reader.assumptions.add(f"the file is no UTF-8: read as {assumed_encoding}")
    return reader.read(name, source)


def join_files(before: Sequence[tuple[str, bytes]], data: bytes) -> JoinedFile:
    """Return a file after others, as one text: anchors of the first are known in the next ones.

    A section that a later file has too is replaced by that one, as WireViz reads them.

    Args:
        before: name and content of the other files, at least one, in their order.
        data: content of the file.

    Raises:
        DesignError: if one of them is no text.
    """
    texts = [decode(each)[0] for each in (*(content for _, content in before), data)]
    texts = [text if text.endswith("\n") else f"{text}\n" for text in texts]
    sections = [_SECTION.findall(text) for text in texts]
    parts, last = [], 0
    for i, (name, _) in enumerate(before):
        replaced = [key for key in sections[i] if any(key in later for later in sections[i + 1 :])]
        for key in replaced:
            texts[i] = re.sub(
                rf"^{key}(?=\s*:)", f"{_REPLACED}{i}_{key}", texts[i], flags=re.MULTILINE
            )
        first, last = last + 1, last + texts[i].count("\n")
        lost = f", whose {' and '.join(replaced)} those of a later file replace" if replaced else ""
        parts.append(f"lines {first} to {last} are those of {name}{lost}")
    whose = f" ({'; '.join(parts)}; its own begin at line {last + 1})"
    return JoinedFile("".join(texts).encode(), whose)


class _Reader:
    """Reads one harness."""

    def __init__(self, root: dict[str, Value], catalogue: Catalogue) -> None:
        self._root = root
        self.assumptions = Assumptions(catalogue)
        self._ignored: list[LeftOut] = []
        self._left_out: list[LeftOut] = []
        self._connectors = {
            name: connector_part(name, value)
            for name, value in section_of(root, "connectors").items()
        }
        self._cables = {
            name: cable_part(name, value) for name, value in section_of(root, "cables").items()
        }
        for name in self._connectors.keys() & self._cables.keys():
            raise DesignError(
                f"line {self._cables[name].line}: {name} is a connector and a cable: rename one"
            )
        separator = section_of(root, "options").get("template_separator")
        self._separator = separator.text if separator is not None else _DEFAULT_SEPARATOR
        # Instances by designator, with the template of each.
        self._templates: dict[str, str] = {}
        self._unnamed = 0
        self._cores: dict[tuple[str, str], list[_Core]] = {}

    def read(self, name: str, source: str) -> Imported:
        for connection_set in self._root["connections"].items("connections"):
            self._read_set(connection_set)
        connections = self._connections()
        if not connections:
            raise DesignError(
                "none of its connection sets joins two pins by a core, so there is nothing to wire"
                + (f"; the first: {self._left_out[0]}" if self._left_out else "")
            )
        cables = tuple(self._used_cables())
        assembly = assemble(self._devices(), connections)
        self._note_unused()
        title = section_of(self._root, "metadata").get("title")
        account = Account(
            "connections",
            len(connections) + len(self._left_out),
            (*self.assumptions.lines, *assembly.assumptions),
            tuple(self._left_out),
            ignored=tuple(self._ignored),
        )
        order = Order(
            name,
            title.text if title is not None and title.is_scalar else "",
            source,
            assembly.components,
            wires=assembly.wires,
            notes=account.notes,
            cables=cables,
        )
        return Imported(order, account)

    def _read_set(self, value: Value) -> None:
        items = value.items("a connection set")
        ports = [self._ports(item) for item in items]
        counts = {len(lanes): item for lanes, item in zip(ports, items, strict=True) if lanes}
        if len(counts) > 1:
            found = ", ".join(f"{n} in {item.where}" for n, item in sorted(counts.items()))
            raise DesignError(
                f"{value.where}: the items of this set stand for different numbers of connections "
                f"({found}): give each the same number of pins or cores"
            )
        count = next(iter(counts), 1)
        lanes = [
            lanes or self._whole(item, count, alone=len(items) == 1, mated=self._mated(items, i))
            for i, (lanes, item) in enumerate(zip(ports, items, strict=True))
        ]
        self._refuse_same_kind(items, lanes)
        for lane in range(count):
            self._read_lane([ports[lane] if ports else None for ports in lanes])
        self._note_arrows(items)

    def _mated(self, items: list[Value], index: int) -> bool:
        """Return whether an item mates a neighbour as a whole, so that its pins do not matter."""
        beside = items[max(0, index - 1) : index] + items[index + 1 : index + 2]
        return any(_is_arrow(item) for item in beside)

    def _ports(self, item: Value) -> list[_Port]:
        """Return the ports of an item that says how many there are, else none."""
        if isinstance(item.data, dict):
            return self._ports_of_mapping(item)
        if isinstance(item.data, list):
            ports: list[_Port] = []
            for entry in item.data:
                if _is_arrow(entry):
                    return []
                if isinstance(entry.data, dict):
                    ports += self._ports_of_mapping(entry)
                else:
                    ports.append(self._only_port(self._instance(entry), entry))
            return ports
        return []

    def _ports_of_mapping(self, item: Value) -> list[_Port]:
        entries = item.mapping("a connection")
        if len(entries) != 1:
            raise DesignError(
                f"{item.where}: expected one connector or cable with its pins, found "
                f"{', '.join(entries) or 'none'}"
            )
        ((designator, reference),) = entries.items()
        part = self._instance(Value(designator, item.line))
        pinout = self._part(part).pinout
        keys = pinout.expanded(reference)
        if not keys or len(keys) > _MOST_LANES:
            raise DesignError(f"{reference.where}: {pinout.what}: {len(keys)} {pinout.noun}s named")
        return [_Port(part, key, self._is_cable(part), item.line) for key in keys]

    def _whole(self, item: Value, count: int, *, alone: bool, mated: bool) -> list[_Port]:
        """Return the ports of an item that names no pins: a connector's only one, in each lane."""
        arrows = item.data if isinstance(item.data, list) else [item]
        if all(_is_arrow(arrow) for arrow in arrows):
            return []
        first = self._instance(item)
        names = [first]
        if item.text.endswith(self._separator) and not alone:
            names += [self._instance(item) for _ in range(count - 1)]
        part = self._part(first)
        if (alone or mated) and len(part.pinout.keys) > 1:
            return []
        return [self._only_port(names[i % len(names)], item) for i in range(count)]

    def _only_port(self, part: str, item: Value) -> _Port:
        pinout = self._part(part).pinout
        if len(pinout.keys) > 1:
            raise DesignError(
                f"{item.where}: {pinout.what} has {len(pinout.keys)} {pinout.noun}s: say which, as "
                f"in `{item.text}: [1-{len(pinout.keys)}]`"
            )
        return _Port(part, pinout.keys[0], self._is_cable(part), item.line)

    def _instance(self, item: Value) -> str:
        """Return the designator of an instance, which is made if it is new."""
        if not item.is_scalar:
            raise DesignError(f"{item.where}: expected a name, found {item.shown}")
        text = item.text.strip()
        if text in self._templates:
            return text
        template, separator, designator = text.partition(self._separator)
        if not separator or text in self._connectors or text in self._cables:
            template = designator = text
        if template not in self._connectors and template not in self._cables:
            known = [*self._connectors, *self._cables]
            close = get_close_matches(template, known, 1)
            raise DesignError(
                f"{item.where}: {template or text!r} is neither a connector nor a cable"
                + (f"; do you mean {close[0]}?" if close else f"; there are {', '.join(known)}")
            )
        if not designator:
            self._unnamed += 1
            designator = f"{template}~{self._unnamed}"
        before = self._templates.setdefault(designator, template)
        if before != template:
            raise DesignError(
                f"{item.where}: {designator} is made from template {template}, and elsewhere from "
                f"{before}: give it another name"
            )
        return designator

    def _is_cable(self, designator: str) -> bool:
        return self._templates[designator] in self._cables

    def _part(self, designator: str) -> ConnectorPart | CablePart:
        template = self._templates[designator]
        return self._connectors.get(template) or self._cables[template]

    def _refuse_same_kind(self, items: list[Value], lanes: list[list[_Port]]) -> None:
        for i in range(len(items) - 1):
            if lanes[i] and lanes[i + 1] and lanes[i][0].is_cable == lanes[i + 1][0].is_cable:
                kind = "cables" if lanes[i][0].is_cable else "connectors"
                raise DesignError(
                    f"{items[i + 1].where}: {lanes[i][0].part} and {lanes[i + 1][0].part} are both "
                    f"{kind}; connectors and cables (or arrows) take turns in a connection set"
                )

    def _read_lane(self, lane: list[_Port | None]) -> None:
        for i, port in enumerate(lane):
            if port is not None and port.is_cable:
                left = lane[i - 1] if i else None
                right = lane[i + 1] if i + 1 < len(lane) else None
                self._join(port, _ref(left), _ref(right))

    def _join(self, core: _Port, left: TerminalRef | None, right: TerminalRef | None) -> None:
        """Note the ends of a core; two sets may name one each."""
        named = self._cores.setdefault((core.part, core.key), [])
        if named and (left is None) != (right is None):
            last = named[-1]
            if last.left is None and left is not None:
                last.left = left
                return
            if last.right is None and right is not None:
                last.right = right
                return
        named.append(_Core(left, right, core.line))

    def _connections(self) -> list[Connection]:
        """Return the cores with two ends; note the others as left out."""
        connections = []
        for (designator, key), named in self._cores.items():
            cable = self._cables[self._templates[designator]]
            for count, core in enumerate(named):
                where = f"line {core.line}"
                what = f"core {key} of {designator}"
                if core.left is None or core.right is None:
                    self._left_out.append(LeftOut(where, f"one end of {what} is open"))
                elif core.left == core.right:
                    self._left_out.append(LeftOut(where, f"{what} has both ends at {core.left}"))
                elif count:
                    reason = f"{what} is connected before, in line {named[0].line}"
                    self._left_out.append(LeftOut(where, reason))
                else:
                    connections.append(
                        self._connection(
                            designator, key, cable, core.left, right=core.right, where=where
                        )
                    )
        return connections

    def _connection(
        self,
        designator: str,
        key: str,
        cable: CablePart,
        left: TerminalRef,
        right: TerminalRef,
        where: str,
    ) -> Connection:
        colour = cable.colour_of(key)
        return Connection(
            left,
            right,
            "" if key == SHIELD else self.assumptions.colour(colour, where),
            self.assumptions.section(cable.gauge_of(key), where),
            source=where,
            name=f"{designator}.{key}",
            length_m=cable.length_of(key),
            cable="" if cable.is_bundle else designator,
            core=key,
        )

    def _devices(self) -> Iterator[Device]:
        for designator, template in self._templates.items():
            if template in self._connectors:
                part = self._connectors[template]
                yield Device(
                    designator,
                    part.kind,
                    role=Role.JOINT if names_splice(designator, part.kind) else Role.CONNECTOR,
                    part_number=part.part_number,
                    kinds=dict(zip(part.pinout.keys, part.pinout.labels, strict=False)),
                    stays_bare=True,
                )

    def _used_cables(self) -> Iterator[Cable]:
        for designator, template in self._templates.items():
            part = self._cables.get(template)
            if part is None:
                continue
            source = f"line {part.line}"
            for length in dict.fromkeys(part.lengths):
                if length_m(length) is None:
                    self.assumptions.add(f"{source}: length {length!r} not understood")
            if not part.is_bundle:
                yield Cable(designator, part.kind, part.length_m, part.is_shielded, source=source)

    def _note_unused(self) -> None:
        used = set(self._templates.values())
        parts: dict[str, ConnectorPart | CablePart] = {**self._connectors, **self._cables}
        for name, part in parts.items():
            if name not in used:
                self._ignored.append(
                    LeftOut(f"line {part.line}", f"no connection set names {name}")
                )
        self._ignored += omitted_parts(self._root)
        for name, connector in self._connectors.items():
            if connector.loops:
                reason = f"{connector.loops} loops within connector {name} are no wires"
                self._ignored.append(LeftOut(f"line {connector.line}", reason))

    def _note_arrows(self, items: list[Value]) -> None:
        for i, item in enumerate(items):
            arrows = item.data if isinstance(item.data, list) else [item]
            if arrows and all(_is_arrow(arrow) for arrow in arrows):
                if not 0 < i < len(items) - 1:
                    raise DesignError(f"{item.where}: an arrow stands between two connectors")
                self._ignored.append(LeftOut(item.where, "connectors that mate need no wire"))


def _is_arrow(item: Value) -> bool:
    return isinstance(item.data, str) and _ARROW.fullmatch(item.data.strip()) is not None


def _ref(port: _Port | None) -> TerminalRef | None:
    return None if port is None or port.is_cable else TerminalRef(port.part, port.key)
