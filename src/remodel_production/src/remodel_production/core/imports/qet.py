"""Import a QElectroTech project, of format 0.3 to 0.90.

How a project is read

1. Every diagram (folio) holds elements, which refer to their definition in the embedded
   collection, and conductors, which join two terminals. A conductor names a terminal by the
   element's uuid and the uuid that the definition gives it, or (before format 0.90, and for old
   elements since) by a number unique on the folio.
2. An element that is linked to a master, such as the contact of a relay, is part of the master's
   device. The catalogue says which devices are mounted on the plate, which are in the field, and
   which elements are folio references: at a reference the potential goes on at the reference that
   it is linked to.
3. A conductor between two devices becomes a wire. Terminals that meet at references are chained in
   drawing order, n terminals by n - 1 wires. Every other conductor is left out, with a reason.

The format is described by QElectroTech's own source of projects, and by the files it ships.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from dataclasses import dataclass, replace
from itertools import pairwise

from lxml import etree

from remodel_production.core.catalogue import Catalogue, Place
from remodel_production.core.imports.assembly import Connection, Device, assemble, unique_name
from remodel_production.core.imports.documents import line_of, parse_xml
from remodel_production.core.imports.qet_drawing import (
    UNNAMED,
    ByNumber,
    Spot,
    definitions_of,
    docked,
    elements_of,
    file_name,
    folio_of,
    information,
    kind_of,
    side_of,
    spot_of,
    terminal_names,
    terminals_by_number,
)
from remodel_production.core.imports.values import Account, Assumptions, Imported, LeftOut
from remodel_production.core.production import Mount, Order, Side, TerminalRef
from remodel_production.errors import DesignError

_NEWEST_FORMAT = 0.90
_SECTION = re.compile(r"\d+(?:[.,]\d+)?\s*(?:mm[2\u00b2]?|awg)|awg\s*\d+", re.IGNORECASE)
_DEVICES = (Place.PLATE, Place.DOOR, Place.OUTSIDE)


@dataclass(frozen=True)
class _Point:
    """A terminal as drawn, by its element and its name in the device."""

    element: str
    name: str


@dataclass(frozen=True)
class _Conductor:
    source: str
    ends: tuple[_Point, _Point]
    colour: str
    section: str
    number: str = ""


def import_qet(data: bytes, name: str, source: str, catalogue: Catalogue) -> Imported:
    """Read a project; arguments are those of `DesignFormat.read`.

    Raises:
        DesignError: if the data is no QElectroTech project or has no wire.
    """
    project = parse_xml(data)
    if project.tag != "project" or project.find("diagram") is None:
        raise DesignError(
            f"the root element is <{project.tag}>; a QElectroTech project is a <project> with at "
            "least one <diagram>"
        )
    return _Reader(project, catalogue).read(name, source)


class _Reader:
    """Reads one project; every method fills what the next one needs."""

    def __init__(self, project: etree._Element, catalogue: Catalogue) -> None:
        self._project = project
        self._catalogue = catalogue
        self._assumptions = Assumptions(catalogue)
        self._left_out: list[LeftOut] = []
        self._note_version()
        self._definitions = definitions_of(project)
        self._elements = elements_of(project)
        self._masters = {uuid: self._master(uuid) for uuid in self._elements}
        self._stated = {uuid: self._place(master) for uuid, master in self._masters.items()}
        self._places = {uuid: place or Place.PLATE for uuid, place in self._stated.items()}
        self._sides: dict[str, dict[str, Side]] = defaultdict(dict)
        self._point_names = self._name_points()

    def read(self, name: str, source: str) -> Imported:
        conductors = [
            conductor
            for folio, diagram in enumerate(self._project.iterfind("diagram"), start=1)
            for conductor in self._conductors(folio, diagram)
        ]
        count = len(conductors) + len(self._left_out)
        wires, joined, wires_joined = self._join(conductors)
        if not wires:
            reasons = _reasons(self._left_out)
            raise DesignError(
                f"none of its {count} conductors joins two devices, so there is nothing to wire"
                + (f"; {reasons}" if reasons else "")
            )
        devices = self._devices()
        wired = {self._masters[end.element] for wire in wires for end in wire.ends}
        names = {uuid: device.name for uuid, device in devices.items() if uuid in wired}
        self._note_names(names)
        self._note_places(names)
        connections = [self._connection(wire, devices) for wire in wires]
        assembly = assemble(devices.values(), connections)
        account = Account(
            "conductors",
            count,
            (*self._assumptions.lines, *assembly.assumptions),
            tuple(self._left_out),
            ignored=self._unwired(wired),
            joined=joined,
            wires_joined=wires_joined,
        )
        title = self._project.get("title", "")
        order = Order(
            name, title, source, assembly.components, wires=assembly.wires, notes=account.notes
        )
        return Imported(order, account)

    def _note_version(self) -> None:
        version = self._project.get("version", "")
        match = re.match(r"\d+\.\d+", version)
        if match is None or float(match[0]) > _NEWEST_FORMAT or version.startswith("0.100"):
            self._assumptions.add(
                f"line {self._project.sourceline}: format {version or 'not given'}; read as 0.90"
            )

    def _place(self, uuid: str) -> Place | None:
        """Return where an element belongs; None if nothing says it."""
        path = self._elements[uuid].get("type", "")
        return self._catalogue.place(path, self._link_type(uuid))

    def _master(self, uuid: str) -> str:
        """Return the element that a device is named and mounted by."""
        if self._link_type(uuid) == "slave":
            for master in self._linked(uuid):
                if master in self._elements and self._link_type(master) == "master":
                    return master
        return uuid

    def _linked(self, uuid: str) -> list[str]:
        """Return the elements that an element is linked to."""
        links = self._elements[uuid].iterfind("links_uuids/link_uuid")
        return [link.get("uuid", "") for link in links]

    def _link_type(self, uuid: str) -> str:
        definition = self._definitions.get(self._elements[uuid].get("type", ""))
        return "" if definition is None else definition.get("link_type", "")

    def _name_points(self) -> dict[tuple[str, Side, Spot], str]:
        """Name the terminals of each device as its definition does, else by side and number.

        They are numbered left to right, element by element.

        Returns:
            The name of each point, by element, side and place in the element.
        """
        names: dict[tuple[str, Side, Spot], str] = {}
        by_texts: set[str] = set()
        for uuid, element in self._elements.items():
            sides = self._sides[self._masters[uuid]]
            symbol = element.get("type", "")
            given, are_texts = terminal_names(self._definitions.get(symbol))
            by_texts |= {symbol.removeprefix("embed://")} if are_texts else set()
            for side in Side:
                letter = side.name[0]
                used = sum(known is side for known in sides.values())
                points = [t for t in element.iterfind("terminals/terminal") if side_of(t) is side]
                for number, spot in enumerate(sorted(set(map(spot_of, points))), start=used + 1):
                    name = unique_name(given.get((side, spot), f"{letter}{number}"), sides)
                    names[uuid, side, spot] = name
                    sides[name] = side
        for symbol in sorted(by_texts):
            self._assumptions.add(f"symbol {symbol}: texts beside its terminals taken as names")
        return names

    def _conductors(self, folio: int, diagram: etree._Element) -> list[_Conductor]:
        """Return the conductors of a folio whose ends are known; note the others as left out."""
        by_number = terminals_by_number(diagram)
        conductors = []
        for node in diagram.iterfind("conductors/conductor"):
            source = f"folio {folio}, {line_of(node)}"
            first, second = (self._end(node, which, by_number) for which in ("1", "2"))
            if isinstance(first, str) or isinstance(second, str):
                reason = first if isinstance(first, str) else str(second)
                self._left_out.append(LeftOut(source, reason))
            elif first == second:
                self._left_out.append(LeftOut(source, "both its ends are at the same terminal"))
            else:
                # Colour and section are attributes since 0.80; before, people wrote them on wires.
                number, drawn = _number_and_section(node.get("num") or "")
                section = (node.get("conductor_section") or "").strip() or drawn
                colour = node.get("conductor_color", "").strip() or node.get("color", "")
                conductors.append(_Conductor(source, (first, second), colour, section, number))
        return conductors

    def _end(self, node: etree._Element, which: str, by_number: ByNumber) -> _Point | str:
        """Return the point at one end of a conductor, or why there is none."""
        uuid, key = node.get(f"element{which}"), node.get(f"terminal{which}", "")
        if uuid is None:
            if key not in by_number:
                return f"terminal {key!r} is on no element of the folio"
            if len(by_number[key]) > 1:
                lines = " and ".join(line_of(terminal) for _, terminal in by_number[key])
                return f"terminal {key} is there twice, at {lines}"
            ((uuid, terminal),) = by_number[key]
        elif uuid not in self._elements:
            return f"element {uuid} is not in the project"
        else:
            definition = self._definitions.get(self._elements[uuid].get("type", ""))
            terminals = definition.iter("terminal") if definition is not None else ()
            found = [terminal for terminal in terminals if terminal.get("uuid") == key]
            if not found:
                return f"terminal {key} is not in the definition of element {uuid}"
            terminal = found[0]
        return _Point(uuid, self._point_name(uuid, terminal))

    def _point_name(self, uuid: str, terminal: etree._Element) -> str:
        side, spot = side_of(terminal), spot_of(terminal)
        for candidate in (spot, docked(spot, terminal.get("orientation", ""))):
            known = self._point_names.get((uuid, side, candidate))
            if known is not None:
                return known
        # The instance lacks it: the definition was changed after the drawing.
        name = f"{side.name[0]}({spot[0]:g},{spot[1]:g})"
        self._sides[self._masters[uuid]][name] = side
        return name

    def _join(self, conductors: list[_Conductor]) -> tuple[list[_Conductor], int, int]:
        """Return the wires, how many conductors were joined at references, and into how many."""
        wires: list[_Conductor] = []
        meetings: dict[str, list[_Conductor]] = defaultdict(list)
        group = self._reference_groups(conductors)
        for conductor in conductors:
            places = [self._places[end.element] for end in conductor.ends]
            if Place.DRAWING in places:
                self._left_out.append(LeftOut(conductor.source, "it ends on a picture"))
            elif Place.REFERENCE in places:
                reference = conductor.ends[places.index(Place.REFERENCE)].element
                meetings[group[reference]].append(conductor)
            else:
                wires.append(conductor)
        joined = wires_joined = 0
        for meeting in meetings.values():
            chained = self._chain(meeting)
            wires += chained
            wires_joined += len(chained)
            joined += len(meeting) if chained else 0
        place = {conductor.source: index for index, conductor in enumerate(conductors)}
        return sorted(wires, key=lambda wire: place[wire.source]), joined, wires_joined

    def _reference_groups(self, conductors: list[_Conductor]) -> dict[str, str]:
        """Return for each folio reference the first of all that carry the same potential."""
        parent = {uuid: uuid for uuid, place in self._places.items() if place is Place.REFERENCE}

        def find(uuid: str) -> str:
            while parent[uuid] != uuid:
                parent[uuid] = parent[parent[uuid]]
                uuid = parent[uuid]
            return uuid

        links = [(uuid, linked) for uuid in parent for linked in self._linked(uuid)]
        links += [
            (first.element, second.element)
            for first, second in (conductor.ends for conductor in conductors)
        ]
        for first, second in links:
            if first in parent and second in parent:
                low, high = sorted((find(first), find(second)))
                parent[high] = low
        return {uuid: find(uuid) for uuid in parent}

    def _chain(self, meeting: list[_Conductor]) -> list[_Conductor]:
        """Join the device terminals that meet at references, each to the next in drawing order."""
        loose = [
            (end, conductor)
            for conductor in meeting
            for end in conductor.ends
            if self._places[end.element] in _DEVICES
        ]
        if len(loose) < 2:
            ends = {end.element for conductor in meeting for end in conductor.ends}
            references = [uuid for uuid in ends if self._places[uuid] is Place.REFERENCE]
            reason = "its folio reference leads to no second device"
            if not any(map(self._linked, references)):
                reason = "its folio reference is linked to no other: link them in QElectroTech"
            self._left_out += [LeftOut(conductor.source, reason) for conductor in meeting]
            return []
        return [
            replace(conductor, ends=(first, second), number=conductor.number or other.number)
            for (first, conductor), (second, other) in pairwise(loose)
        ]

    def _devices(self) -> dict[str, Device]:
        """Return the devices by their master's uuid, each named by its label or its article."""
        devices: dict[str, Device] = {}
        taken: set[str] = set()
        for uuid, element in self._elements.items():
            if self._masters[uuid] != uuid or self._places[uuid] not in _DEVICES:
                continue
            base = (
                information(element, "label")
                or information(element, "designation")
                or file_name(element)
            )
            name = unique_name(base, taken)
            taken.add(name)
            devices[uuid] = Device(
                name,
                kind_of(element),
                self._catalogue.mount(name) or Mount(self._places[uuid].value),
                part_number=information(element, "manufacturer_reference"),
                sides=self._sides[uuid],
            )
        return devices

    def _note_names(self, names: dict[str, str]) -> None:
        """Note devices that are not named by a label, and labels that several devices have."""
        labelled: dict[str, list[str]] = defaultdict(list)
        for uuid, name in names.items():
            if label := information(self._elements[uuid], "label"):
                labelled[label].append(uuid)
            else:
                self._assumptions.add(
                    f"the element at {line_of(self._elements[uuid])} is named {name}"
                )
        for label, uuids in labelled.items():
            if len(uuids) > 1:
                folios = sorted({folio_of(self._elements[uuid]) for uuid in uuids})
                self._assumptions.add(
                    f"{len(uuids)} elements that are not linked have the label {label}, on folio"
                    f"{'s' if len(folios) > 1 else ''} {', '.join(map(str, folios))}: read as "
                    f"devices {', '.join(names[uuid] for uuid in uuids)}; link those that are one "
                    "device, and give the others labels of their own"
                )

    def _note_places(self, names: dict[str, str]) -> None:
        """Note the symbols of devices that are on the plate since nothing says where they are."""
        placed: dict[str, list[str]] = defaultdict(list)
        for uuid, name in names.items():
            if self._stated[uuid] is None and self._catalogue.mount(name) is None:
                placed[self._elements[uuid].get("type", "")].append(name)
        for symbol, devices in sorted(placed.items()):
            self._assumptions.add(
                f"nothing says where symbol {symbol.removeprefix('embed://')} is mounted: the "
                f"plate taken for {', '.join(devices)}"
            )

    def _connection(self, wire: _Conductor, devices: dict[str, Device]) -> Connection:
        a, b = (
            TerminalRef(devices[self._masters[end.element]].name, end.name) for end in wire.ends
        )
        colour = self._assumptions.colour(wire.colour, wire.source)
        section = self._assumptions.section(wire.section, wire.source)
        return Connection(a, b, colour, section, source=wire.source, name=wire.number)

    def _unwired(self, wired: set[str]) -> tuple[LeftOut, ...]:
        """Return the devices with terminals to which no wire goes."""
        return tuple(
            LeftOut(f"{line_of(element)}, {kind_of(element)}", "it has no wire")
            for uuid, element in self._elements.items()
            if self._masters[uuid] == uuid
            and uuid not in wired
            and self._places[uuid] in _DEVICES
            and element.find("terminals/terminal") is not None
        )


def _number_and_section(text: str) -> tuple[str, str]:
    """Return the number that a conductor has, and the section that people wrote beside it."""
    match = _SECTION.search(text)
    number = " ".join(_SECTION.sub(" ", text).split())
    return "" if number == UNNAMED else number, match[0] if match else ""


def _reasons(left_out: list[LeftOut]) -> str:
    counts = Counter(item.reason for item in left_out)
    return "; ".join(f"{count}: {reason}" for reason, count in counts.most_common())
