"""Import a VEC harness (VDA 4968, PSI 21; versions 1.1 to 2.2), on the model that KBL uses.

A component of the composition has roles: a connector housing has cavities, a wire has wire elements
with ends. A contact point mounts wire ends, by terminals, in cavities. Routings name the segments
of a wire element's path; placements say at which node or on which segment a component is. All
references are followed by id. What the product is, and its electrology, are not read.

The structure is that of the recommendation's model (ecad-wiki.prostep.org, specifications/vec).
"""

from __future__ import annotations

from collections.abc import Iterator

from lxml import etree

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.imports.assembly import Connection, Device, assemble, unique_name
from remodel_production.core.imports.design_format import ALL, Asked, ModuleChoice
from remodel_production.core.imports.documents import line_of
from remodel_production.core.imports.kbl_parts import (
    KblTree,
    children,
    lengths_by_type,
    nodes_of_segment,
    ordered_route,
    text_of,
    unique_names,
)
from remodel_production.core.imports.values import Account, Assumptions, Imported, LeftOut, number
from remodel_production.core.imports.vec_parts import node_positions, vec_modules
from remodel_production.core.production import (
    TWISTED,
    Cable,
    Clip,
    Node,
    Order,
    Role,
    Segment,
    TerminalRef,
    sealed_kind,
)
from remodel_production.errors import DesignError
from remodel_run.whole_task import counted

ROOT = "VecContent"
_TYPE = "{http://www.w3.org/2001/XMLSchema-instance}type"
_NAME = "Identification"
_COMPONENTS = ("Component", "PartUsage")
_COLOURS = ("BaseColor", "FirstIdentificationColor", "SecondIdentificationColor")
# What a grouping names its wire elements by: since version 1.2, and before.
_GROUPED = ("RelatedWireElementReference", "RelatedWireRole")
# Of several lengths, the one to cut a wire to comes first.
_LENGTH_TYPES = ("production", "cutting", "physical", "designed", "dmu")
_ASSUMED_SEGMENT_M = 0.1


# Components that no task mounts, by their roles.
_OMITTED = {
    "WireProtectionRole": ("wire protection", "no task wraps wires"),
    "CavityPlugRole": ("cavity plug", "no task closes empty cavities"),
    "CableDuctRole": ("cable duct", "no task mounts it"),
    "CavityAccessoryRole": ("cavity accessory", "no task mounts it"),
    "ConnectorHousingCapRole": ("cap", "no task mounts it"),
}


def import_vec(
    data: bytes, name: str, source: str, catalogue: Catalogue, asked: Asked = ALL
) -> Imported:
    """Read a harness.

    Arguments are those of `DesignFormat.read_modules`.

    Raises:
        DesignError: if it is no VEC, refers to what is not there, or joins no contact points.
    """
    tree = KblTree(data, ROOT)
    return _Reader(tree, catalogue, vec_modules(tree, asked)).read(name, source)


class _Reader:
    """Reads one container."""

    def __init__(self, tree: KblTree, catalogue: Catalogue, modules: ModuleChoice) -> None:
        self._tree = tree
        self._modules = modules
        self._assumptions = Assumptions(catalogue)
        self._places, note = node_positions(tree)
        for line in filter(None, (*modules.notes, note)):
            self._assumptions.add(line)
        self._left_out: list[LeftOut] = []
        self._names = unique_names(tree.all(*_COMPONENTS), _NAME)
        self._node_names = unique_names(tree.all("TopologyNode"), _NAME)
        self._segments = {
            element: self._segment(element, name)
            for element, name in unique_names(tree.all("TopologySegment"), _NAME).items()
        }
        self._at: dict[etree._Element, list[etree._Element]] = {}
        for placement in tree.all("Placement"):
            for role in tree.referred(placement, "PlacedElement"):
                component = self._component(role)
                if component is not None:
                    self._at.setdefault(component, []).extend(children(placement, "Location"))
        self._cavities = self._cavity_names()
        self._groups = self._wire_groups()
        self._kinds: dict[str, dict[str, str]] = {}
        self._joints: set[str] = set()

    def read(self, name: str, source: str) -> Imported:
        ends = self._ends()
        references = [
            reference
            for reference in self._tree.all("WireElementReference")
            if _has(reference, "WireEnd")
        ]
        routes = self._routes()
        connections = [
            c for r in references if (c := self._connection(r, ends, routes)) is not None
        ]
        if not connections:
            raise DesignError(
                f"none of its {len(references)} wire elements joins two contact points, so there "
                "is nothing to wire" + (f"; the first: {self._left_out[0]}" if references else "")
            )
        assembly = assemble(self._devices(connections), connections)
        account = Account(
            "wire elements",
            len(references),
            (*self._assumptions.lines, *assembly.assumptions),
            tuple(self._left_out),
            ignored=tuple(self._omitted()),
        )
        titles = (text_of(d, "DocumentNumber") for d in self._tree.all("DocumentVersion"))
        order = Order(
            name,
            list(titles)[-1] if self._tree.all("DocumentVersion") else "",
            source,
            assembly.components,
            wires=assembly.wires,
            notes=account.notes,
            cables=tuple(self._cables(connections)),
            nodes=tuple(
                Node(name, self._places.get(node)) for node, name in self._node_names.items()
            ),
            segments=tuple(self._segments.values()),
            clips=tuple(self._clips()),
        )
        return Imported(order, account)

    def _component(self, element: etree._Element) -> etree._Element | None:
        """Return the component that a role, or a part of one, belongs to."""
        return next((each for each in element.iterancestors() if each in self._names), None)

    def _part_number(self, element: etree._Element) -> str:
        """Return the part number of the component of a role; empty if it has none."""
        component = element if element in self._names else self._component(element)
        part = None if component is None else self._tree.part(component)
        return "" if part is None else text_of(part, "PartNumber")

    def _segment(self, element: etree._Element, name: str) -> Segment:
        keys = ("StartNode", "EndNode")
        ends = nodes_of_segment(self._tree, element, name, self._node_names, keys)
        length = self._length(element, "LengthInformation", "Classification", "Length")
        if length is None:
            self._assumptions.add(
                f"{line_of(element)}: length of segment {name} not given, {_ASSUMED_SEGMENT_M} m "
                "taken"
            )
        return Segment(name, *ends, length or _ASSUMED_SEGMENT_M)

    def _length(self, element: etree._Element, key: str, kind: str, value: str) -> float | None:
        """Return the length [m] of the most binding kind; None if there is none."""
        lengths = lengths_by_type(self._tree, element, key, kind, value)
        return next((lengths[k] for k in (*_LENGTH_TYPES, *lengths) if k in lengths), None)

    def _cavity_names(self) -> dict[etree._Element, str]:
        """Return the cavities' numbers, made unique in their components."""
        names: dict[etree._Element, str] = {}
        taken: dict[etree._Element | None, set[str]] = {}
        for reference in self._tree.all("CavityReference"):
            cavity = next(iter(self._tree.referred(reference, "ReferencedCavity")), None)
            stated = text_of(reference, "Identification")
            base = "" if cavity is None else text_of(cavity, "CavityNumber")
            used = taken.setdefault(self._component(reference), set())
            names[reference] = unique_name(base or stated or reference.get("id", ""), used)
            used.add(names[reference])
        return names

    def _wire_groups(self) -> dict[etree._Element, str]:
        """Return the names of the groups of wires, such as twisted pairs, by wire element.

        What a grouping contains, such as the pair of a shielded one, belongs to it.
        """
        groups: dict[etree._Element, str] = {}
        taken = {*self._names.values()}
        for grouping in self._tree.all("WireGrouping"):
            name = unique_name(text_of(grouping, "Identification") or line_of(grouping), taken)
            taken.add(name)
            for part in grouping.iter():
                for key in _GROUPED:
                    groups |= dict.fromkeys(self._tree.referred(part, key), name)
        return groups

    def _ends(self) -> dict[etree._Element, TerminalRef]:
        """Return the terminals that wire ends are mounted in."""
        ends: dict[etree._Element, TerminalRef] = {}
        for contact in self._tree.all("ContactPoint"):
            mountings = list(children(contact, "WireMounting"))
            mounted = [
                end for m in mountings for end in self._tree.referred(m, "ReferencedWireEnd")
            ]
            cavities = [
                cavity
                for mounting in children(contact, "CavityMounting")
                for cavity in self._tree.referred(mounting, "EquippedCavityRef")
            ]
            terminals = self._tree.referred(contact, "MountedTerminal")
            owner = next(iter((*cavities, *terminals)), None)
            component = None if owner is None else self._component(owner)
            if component is None:
                continue
            name = self._names[component]
            point = self._cavities[cavities[0]] if cavities else text_of(contact, "Identification")
            ref = TerminalRef(name, point or contact.get("id", "1"))
            if not cavities and len(mounted) > 1:
                self._joints.add(name)
            seals = [s for m in mountings for s in self._tree.referred(m, "MountedCavitySeal")]
            kind = self._part_number(terminals[0]) if terminals else ""
            if seals:
                kind = sealed_kind(kind, self._part_number(seals[0]))
            self._kinds.setdefault(name, {}).setdefault(ref.terminal, kind)
            ends.update(dict.fromkeys(mounted, ref))
        return ends

    def _routes(self) -> dict[etree._Element, list[Segment]]:
        """Return the segments of each wire element's route: the first of those in the variants."""
        routes: dict[etree._Element, list[Segment]] = {}
        for routing in self._tree.all("Routing"):
            if self._modules.why_not(routing):
                continue
            segments = [
                self._segments[segment]
                for path in children(routing, "Path")
                for segment in self._tree.referred(path, "Segment")
                if segment in self._segments
            ]
            for routed in self._tree.referred(routing, "RoutedElement"):
                if segments != routes.setdefault(routed, segments):
                    owner = self._component(routed)
                    name = self._names[owner] if owner is not None else routed.get("id")
                    self._assumptions.add(
                        f"{line_of(routing)}: another route of {name} is not taken; --variant "
                        "chooses, if it has a condition"
                    )
        return routes

    def _connection(
        self,
        reference: etree._Element,
        ends: dict[etree._Element, TerminalRef],
        routes: dict[etree._Element, list[Segment]],
    ) -> Connection | None:
        """Return the wire of a wire element, or None if it is left out."""
        component = self._component(reference)
        owner = "" if component is None else self._names[component]
        core = text_of(reference, "Identification") or reference.get("id", "")
        source = f"{line_of(reference)}, wire {owner} {core}"
        found = sorted(children(reference, "WireEnd"), key=_position)
        refs = [ends[end] for end in found if end in ends]
        if len(refs) != 2 or refs[0] == refs[1]:
            reason = (
                "both its ends are at the same terminal"
                if len(refs) == 2
                else f"{counted(len(refs), 'end')} at a contact point; two are needed"
            )
            self._left_out.append(LeftOut(source, reason))
            return None
        if why := self._modules.why_not(component, reference):
            self._left_out.append(LeftOut(source, why))
            return None
        beside = [] if component is None else self._connected(component)
        is_core = len(beside) > 1
        segments = routes.get(reference, [])
        nodes = [self._nodes_of(ref.component) for ref in refs]
        route = ordered_route(segments, *nodes) if segments else ()
        if isinstance(route, str):
            self._assumptions.add(f"{source}: its route is not taken, {route}")
            route = ()
        length = self._length(reference, "WireLength", "LengthType", "LengthValue")
        section, colour = self._material(reference)
        name = f"{owner}.{core}" if is_core else owner or core
        group = "" if is_core else self._groups.get(reference, "")
        return Connection(
            refs[0],
            refs[1],
            self._assumptions.colour(colour, source),
            self._assumptions.section(section, source),
            source=source,
            name=name,
            length_m=length,
            cable=owner if is_core else group,
            core=core if is_core else name if group else "",
            route=tuple(segment.name for segment in route),
        )

    def _connected(self, component: etree._Element) -> list[etree._Element]:
        """Return the wire elements of a component that have ends: the cores of a cable."""
        return [
            reference
            for role in children(component, "Role")
            for reference in children(role, "WireElementReference")
            if _has(reference, "WireEnd")
        ]

    def _material(self, reference: etree._Element) -> tuple[str, str]:
        """Return the section [mm^2] and the colours of a wire element as texts, or empty ones."""
        section = colour = ""
        for element in self._tree.referred(reference, "ReferencedWireElement"):
            for specification in self._tree.referred(element, "WireElementSpecification"):
                for conductor in self._tree.referred(specification, "ConductorSpecification"):
                    area = self._tree.quantity(conductor, "CrossSectionArea", power=2)
                    section = "" if area is None else f"{area * 1e6:.6g}"
                for insulation in self._tree.referred(specification, "InsulationSpecification"):
                    keys = [text_of(c, "Key") for k in _COLOURS for c in children(insulation, k)]
                    colour = "/".join(filter(None, keys))
        return section, colour

    def _nodes_of(self, component: str) -> list[str]:
        return [
            self._node_names[node]
            for element, name in self._names.items()
            if name == component
            for location in self._at.get(element, ())
            for node in self._tree.referred(location, "ReferencedNode")
            if node in self._node_names
        ]

    def _devices(self, connections: list[Connection]) -> Iterator[Device]:
        used = {ref.component for c in connections for ref in (c.a, c.b)}
        for element, name in self._names.items():
            roles = {_type(role) for role in children(element, "Role")}
            is_housing = "ConnectorHousingRole" in roles
            if name in used or is_housing:
                yield Device(
                    name,
                    text_of(element, "Description"),
                    role=Role.JOINT if name in self._joints else Role.CONNECTOR,
                    part_number=self._part_number(element),
                    node=next(iter(self._nodes_of(name)), ""),
                    kinds=self._kinds.get(name, {}),
                    stays_bare=is_housing,
                )

    def _cables(self, connections: list[Connection]) -> Iterator[Cable]:
        used = {connection.cable for connection in connections if connection.cable}
        for element, name in self._names.items():
            if name in used:
                yield Cable(name, self._part_number(element), None, False, source=line_of(element))
        for group in dict.fromkeys(self._groups.values()):
            if group in used:
                yield Cable(group, TWISTED, None, False, source=f"wire grouping {group}")

    def _omitted(self) -> Iterator[LeftOut]:
        """Yield the components that the order has nothing of, and why."""
        for element, name in self._names.items():
            kinds = {_type(role) for role in children(element, "Role")}
            for what, why in (_OMITTED[kind] for kind in kinds if kind in _OMITTED):
                yield LeftOut(f"{line_of(element)}, {what} {name}", why)
            if "FixingRole" in kinds and element not in self._at:
                yield LeftOut(f"{line_of(element)}, fixing {name}", "it is nowhere on the topology")

    def _clips(self) -> Iterator[Clip]:
        for element, name in self._names.items():
            if not any(_type(role) == "FixingRole" for role in children(element, "Role")):
                continue
            kind = self._part_number(element)
            for location in self._at.get(element, ()):
                for node in self._tree.referred(location, "ReferencedNode"):
                    yield Clip(name, kind, node=self._node_names.get(node, ""))
                for segment in self._tree.referred(location, "ReferencedSegment"):
                    passed = self._segments[segment]
                    offset = self._tree.quantity(location, "Offset") or 0.0
                    along = min(1.0, offset / passed.length_m)
                    if "end" in text_of(location, "Anchor").lower():
                        along = 1.0 - along
                    yield Clip(name, kind, passed.name, along)


def _position(end: etree._Element) -> float:
    position = number(text_of(end, "PositionOnWire"))
    return 0.0 if position is None else position


def _type(element: etree._Element) -> str:
    return element.get(_TYPE, "").rpartition(":")[2]


def _has(element: etree._Element, name: str) -> bool:
    return next(children(element, name), None) is not None
