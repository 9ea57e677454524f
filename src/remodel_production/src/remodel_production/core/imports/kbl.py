"""Import a KBL harness (VDA 4964, versions 2.3 to 2.5).

A connection of a KBL names a wire or a core of a special wire, and the contact points of connectors
at which it ends; a contact point contacts a cavity with a terminal. The routing of a connection
names segments of the topology, which become an ordered route from the connection's first end to its
second one; fixings on them are clips. All references are followed by id.

The structure is that of the recommendation's model (ecad-wiki.prostep.org, specifications/kbl).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from lxml import etree

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.imports.assembly import Connection, Device, assemble, unique_name
from remodel_production.core.imports.design_format import ALL, Asked, ModuleChoice
from remodel_production.core.imports.documents import line_of, local_name
from remodel_production.core.imports.kbl_parts import (
    KblTree,
    Topology,
    children,
    ends_of,
    is_splice,
    kbl_modules,
    lengths_by_type,
    name_of,
    ordered_route,
    placed_pose,
    shown,
    text_of,
    twisted_groups,
    unique_names,
    unused_parts,
)
from remodel_production.core.imports.values import Account, Assumptions, Imported, LeftOut, number
from remodel_production.core.production import (
    TWISTED,
    Cable,
    Order,
    Pose,
    Role,
    Segment,
    TerminalRef,
    sealed_kind,
)
from remodel_production.errors import DesignError
from remodel_run.whole_task import counted

_VERSIONS = ("2.3", "2.4", "2.5")
_WIRES = ("general_wire_occurrence", "wire_occurrence", "special_wire_occurrence")
_CONNECTORS = ("connector_occurrence", "component_box_occurrence")
# Of several lengths of a wire, the one to cut it to comes first.
_LENGTH_TYPES = ("production", "cutting", "physical", "dmu")
_BASE_COLOURS = ("grundfarbe", "base color", "base colour", "base", "basiccolor")


def import_kbl(
    data: bytes, name: str, source: str, catalogue: Catalogue, asked: Asked = ALL
) -> Imported:
    """Read a harness.

    Arguments are those of `DesignFormat.read_modules`.

    Raises:
        DesignError: if it is no KBL container, refers to what is not there, or has no connection.
    """
    tree = KblTree(data)
    return _Reader(tree, catalogue, kbl_modules(tree, asked)).read(name, source)


class _Reader:
    """Reads one container."""

    def __init__(self, tree: KblTree, catalogue: Catalogue, modules: ModuleChoice) -> None:
        self._tree = tree
        self._modules = modules
        self._assumptions = Assumptions(catalogue)
        self._left_out: list[LeftOut] = []
        self._ignored: list[LeftOut] = []
        self._note_version()
        self._topology = Topology(tree, self._assumptions)
        self._nodes = self._topology.nodes_of()
        self._names: dict[etree._Element, str] = {}
        self._kinds: dict[str, dict[str, str]] = {}
        self._terminal_names: dict[etree._Element, dict[etree._Element, str]] = {}
        self._joined = self._wires_joined = 0
        self._twisted = twisted_groups(tree)

    def read(self, name: str, source: str) -> Imported:
        self._name_connectors()
        routings = self._routings()
        found = self._tree.all("Connection")
        self._note_unconnected(found)
        self._ignored += unused_parts(self._tree)
        connections = [c for element in found for c in self._connections(element, routings)]
        if not connections:
            raise DesignError(
                f"none of its {len(found)} connections joins two contact points, so there is "
                "nothing to wire" + (f"; the first: {self._left_out[0]}" if self._left_out else "")
            )
        assembly = assemble(self._devices(), connections)
        account = Account(
            "connections",
            len(found),
            (*self._assumptions.lines, *assembly.assumptions),
            tuple(self._left_out),
            ignored=tuple(self._ignored),
            joined=self._joined,
            wires_joined=self._wires_joined,
        )
        order = Order(
            name,
            self._title(),
            source,
            assembly.components,
            wires=assembly.wires,
            notes=account.notes,
            cables=tuple(self._cables(connections)),
            nodes=self._topology.nodes,
            segments=self._topology.segments,
            clips=self._topology.clips,
        )
        return Imported(order, account)

    def _note_version(self) -> None:
        version = self._tree.root.get("version_id", "")
        if not version.startswith(_VERSIONS):
            self._assumptions.add(f"line 1: KBL version {version or 'not given'}, read as 2.5")
        for note in self._modules.notes:
            self._assumptions.add(note)

    def _title(self) -> str:
        for harness in self._tree.all("Harness"):
            words = (text_of(harness, "Part_number"), text_of(harness, "Description"))
            return " ".join(filter(None, words))
        return ""

    def _name_connectors(self) -> None:
        """Name the connectors and boxes, and whatever else owns contact points."""
        owners = [contact.getparent() for contact in self._tree.all("Contact_points")]
        named = dict.fromkeys([*self._tree.all(*_CONNECTORS), *owners])
        self._names = unique_names(
            owner for owner in named if owner is not None and owner is not self._tree.root
        )
        for owner, name in self._names.items():
            if name != (base := name_of(owner)):
                self._assumptions.add(f"{line_of(owner)}: name {base} occurs before; named {name}")

    def _routings(self) -> dict[etree._Element, etree._Element]:
        """Return the routings by what they route: a connection, or its wire."""
        routings: dict[etree._Element, etree._Element] = {}
        for routing in self._tree.all("Routing"):
            for routed in self._tree.referred(routing, "Routed_wire"):
                if routed in routings:
                    raise DesignError(
                        f"{line_of(routing)}: {shown(routed)} has a routing before, at "
                        f"{line_of(routings[routed])}: keep one"
                    )
                routings[routed] = routing
        return routings

    def _note_unconnected(self, connections: list[etree._Element]) -> None:
        """Note the wires and cores that no connection names."""
        used = {w for c in connections for w in self._tree.referred(c, "Wire")}
        for occurrence in self._tree.all(*_WIRES, "core_occurrence"):
            cores = set(children(occurrence, "Core_occurrence"))
            if occurrence not in used and not cores:
                what = f"wire {_wire_name(occurrence)}"
                self._ignored.append(
                    LeftOut(f"{line_of(occurrence)}, {what}", "it connects nothing")
                )

    def _connections(
        self, element: etree._Element, routings: dict[etree._Element, etree._Element]
    ) -> Iterator[Connection]:
        """Yield the wires of a connection, one but for connections with more than two ends."""
        source = f"{line_of(element)}, connection {text_of(element, 'Id') or element.get('id')}"
        ends = self._ends(element)
        wires = self._tree.referred(element, "Wire")
        if len(ends) < 2:
            self._left_out.append(
                LeftOut(source, f"{counted(len(ends), 'end')} at a contact point; two are needed")
            )
            return
        if why := self._modules.why_not(*wires, *(wire.getparent() for wire in wires)):
            self._left_out.append(LeftOut(source, why))
            return
        if len(wires) != 1:
            self._left_out.append(LeftOut(source, f"it has {len(wires)} wires; one is needed"))
            return
        refs = [self._ref(contact) for contact in ends]
        if any(a == b for a, b in pairwise(refs)):
            self._left_out.append(LeftOut(source, "two of its ends are at the same terminal"))
            return
        routing = routings.get(element)
        routing = routings.get(wires[0]) if routing is None else routing
        segments = [] if routing is None else self._topology.segments_of(routing)
        route = self._route(segments, ends, source) if len(ends) == 2 else ()
        if len(ends) > 2:
            self._joined += 1
            self._wires_joined += len(ends) - 1
            self._assumptions.add(
                f"{source}: it has {len(ends)} ends; they are joined in their order"
            )
        length = self._length(wires[0], route, source)
        for a, b in pairwise(refs):
            yield self._connection(
                wires[0], a, b, source, length=length if len(refs) == 2 else None, route=route
            )

    def _ends(self, element: etree._Element) -> list[etree._Element]:
        """Return the contact points in the order of their positions on the wire."""
        found: list[tuple[float, int, etree._Element]] = []
        for count, extremity in enumerate(children(element, "Extremities")):
            text = text_of(extremity, "Position_on_wire")
            position = number(text) if text else float(count)
            if position is None:
                raise DesignError(
                    f"{line_of(extremity)}: Position_on_wire {text!r}; a number from 0 to 1 is "
                    "needed"
                )
            for contact in self._tree.referred(extremity, "Contact_point"):
                if contact.getparent() not in self._names:
                    raise DesignError(
                        f"{line_of(extremity)}: Contact_point refers to {shown(contact)}, which is "
                        "no contact point of a connector"
                    )
                found.append((position, count, contact))
        return [contact for *_, contact in sorted(found, key=lambda end: end[:2])]

    def _ref(self, contact: etree._Element) -> TerminalRef:
        """Return the terminal of a contact point: its cavity's number, else its id."""
        connector = contact.getparent()
        cavity = next(iter(self._tree.referred(contact, "Contacted_cavity")), contact)
        ref = TerminalRef(self._names[connector], self._terminal_name(cavity, connector))
        parts = [self._tree.part(p) for p in self._tree.referred(contact, "Associated_parts")]
        terminals = [p for p in parts if p is not None and local_name(p) == "General_terminal"]
        seals = [p for p in parts if p is not None and local_name(p) == "Cavity_seal"]
        if terminals or seals:
            kinds = self._kinds.setdefault(ref.component, {})
            kind = text_of(terminals[0], "Part_number") if terminals else ""
            seal = text_of(seals[0], "Part_number") if seals else None
            kinds.setdefault(ref.terminal, kind if seal is None else sealed_kind(kind, seal))
        return ref

    def _terminal_name(self, cavity: etree._Element, connector: etree._Element) -> str:
        """Return a cavity's number, made unique among the slots of its connector.

        Args:
            cavity: the cavity, or a contact point that says none.
            connector: that owns it.
        """
        names = self._terminal_names.setdefault(connector, {})
        if cavity not in names:
            part = self._tree.part(cavity)
            base = text_of(cavity if part is None else part, "Cavity_number")
            base = base or text_of(cavity, "Id") or cavity.get("id", "")
            names[cavity] = unique_name(base, set(names.values()))
        return names[cavity]

    def _route(
        self, segments: list[Segment], ends: list[etree._Element], source: str
    ) -> tuple[Segment, ...]:
        if not segments:
            return ()
        a, b = (self._nodes_of(contact) for contact in ends)
        route = ordered_route(segments, a, b)
        if isinstance(route, str):
            self._ignored.append(LeftOut(f"{source}, its route", route))
            return ()
        found = set(ends_of(route))
        if any(nodes and not found & set(nodes) for nodes in (a, b)):
            where = " and ".join(" or ".join(nodes) or "no node" for nodes in (a, b))
            self._assumptions.add(
                f"{source}: its route leads from {' to '.join(ends_of(route))}, and its connectors "
                f"sit at {where}; the route is taken"
            )
        return route

    def _nodes_of(self, contact: etree._Element) -> list[str]:
        """Return the nodes of a contact point: of its cavity, of its parts, of its connector."""
        items = [
            *self._tree.referred(contact, "Contacted_cavity"),
            *self._tree.referred(contact, "Associated_parts"),
            contact.getparent(),
        ]
        return [node for item in items for node in self._nodes.get(item, ())]

    def _node_of(self, connector: etree._Element) -> str:
        """Return the first node of a connector, or of one of its contact points; empty for none."""
        for node in self._nodes.get(connector, ()):
            return node
        contacts = children(connector, "Contact_points")
        return next((node for contact in contacts for node in self._nodes_of(contact)), "")

    def _connection(
        self,
        occurrence: etree._Element,
        a: TerminalRef,
        b: TerminalRef,
        source: str,
        length: float | None,
        route: tuple[Segment, ...],
    ) -> Connection:
        part = self._tree.part(occurrence)
        colour = section = ""
        if part is not None:
            area = self._tree.quantity(part, "Cross_section_area", power=2)
            section = "" if area is None else f"{area * 1e6:.6g}"
            colour = _colour(part)
        cable = self._cable_of(occurrence)
        group = self._twisted.get(occurrence, "")
        return Connection(
            a,
            b,
            self._assumptions.colour(colour, source),
            self._assumptions.section(section, source),
            source=source,
            name=_wire_name(occurrence)
            if cable is None
            else f"{_cable_name(cable)}.{_wire_name(occurrence)}",
            length_m=length,
            cable=group if cable is None else _cable_name(cable),
            core=_wire_name(occurrence) if cable is not None or group else "",
            route=tuple(segment.name for segment in route),
        )

    def _length(
        self, occurrence: etree._Element, route: tuple[Segment, ...], source: str
    ) -> float | None:
        keys = ("Length_information", "Length_type", "Length_value")
        cable = self._cable_of(occurrence)
        lengths = lengths_by_type(self._tree, occurrence, *keys)
        if cable is not None and not lengths:
            lengths = lengths_by_type(self._tree, cable, *keys)
        for kind in (*_LENGTH_TYPES, *lengths):
            if kind in lengths:
                return lengths[kind]
        if route:
            self._assumptions.add(f"{source}: length not given, that of its route taken")
            return round(sum(segment.length_m for segment in route), 9)
        return None

    def _cable_of(self, occurrence: etree._Element) -> etree._Element | None:
        """Return the special wire that a core belongs to; None for a single wire."""
        owner = occurrence.getparent()
        if local_name(occurrence).lower() != "core_occurrence" or owner is None:
            return None
        return owner if local_name(owner).lower() in _WIRES else None

    def _cables(self, connections: list[Connection]) -> Iterator[Cable]:
        used = {connection.cable for connection in connections}
        for group in dict.fromkeys(self._twisted.values()):
            if group in used:
                yield Cable(group, TWISTED, None, shielded=False, source=f"wire group {group}")
        for occurrence in self._tree.all(*_WIRES):
            name = _cable_name(occurrence)
            has_cores = next(children(occurrence, "Core_occurrence"), None) is not None
            if name in used and has_cores:
                used.discard(name)
                part = self._tree.part(occurrence)
                kind = "" if part is None else text_of(part, "Part_number")
                designator = "" if part is None else text_of(part, "Cable_designator")
                shielded = "shield" in designator.lower()
                length = self._length(occurrence, (), "")
                yield Cable(name, kind, length, shielded, source=line_of(occurrence))

    def _devices(self) -> Iterator[Device]:
        for owner, name in self._names.items():
            part = self._tree.part(owner)
            usage = text_of(owner, "Usage")
            described = "" if part is None else text_of(part, "Description")
            yield Device(
                name,
                " ".join(filter(None, (text_of(owner, "Description") or described, usage))),
                role=Role.JOINT if is_splice(owner, part) else Role.CONNECTOR,
                part_number="" if part is None else text_of(part, "Part_number"),
                pose=self._pose(owner),
                node=self._node_of(owner),
                kinds=self._kinds.get(name, {}),
                stays_bare=True,
            )

    def _pose(self, connector: etree._Element) -> Pose | None:
        """Return where a connector is: as it, or a part of its contact points, is placed."""
        contacts = list(children(connector, "Contact_points"))
        parts = [p for c in contacts for p in self._tree.referred(c, "Associated_parts")]
        for occurrence in (connector, *parts):
            pose = placed_pose(self._tree, occurrence)
            if pose is not None:
                return pose
        nodes = {node.name: node.position for node in self._topology.nodes}
        position = nodes.get(self._node_of(connector))
        return None if position is None else Pose(position)


def _colour(part: etree._Element) -> str:
    """Return a wire's colours, its base colour first."""
    found = [*children(part, "Cover_colour"), *children(part, "Core_colour")]
    found.sort(key=lambda colour: text_of(colour, "Colour_type").lower() not in _BASE_COLOURS)
    return "/".join(filter(None, (text_of(colour, "Colour_value") for colour in found)))


def _wire_name(occurrence: etree._Element) -> str:
    return text_of(occurrence, "Wire_number") or occurrence.get("id") or line_of(occurrence)


def _cable_name(occurrence: etree._Element) -> str:
    return text_of(occurrence, "Special_wire_id") or occurrence.get("id") or line_of(occurrence)
