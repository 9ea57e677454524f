"""Import a QElectroTech project: its text in, an order and an account of it out.

How a project is read

1. Every diagram (folio) holds elements, which refer to their definition in the embedded
   collection, and conductors, which join two terminals. A conductor names a terminal by the
   element's uuid and the uuid that the definition gives it, or (before format 0.80) by a number
   unique on the folio.
2. The catalogue says which elements are mounted on the plate, which are in the field, and which are
   folio references: at a reference the potential goes on at the reference that it is linked to.
3. A conductor between two terminals on the plate becomes a wire. Terminals that meet at references
   are chained in drawing order, n terminals by n - 1 wires. Every other conductor is left out, with
   a reason.
4. A point at which several wires meet becomes as many terminals: B2.1, B2.2, ...

The format is described by QElectroTech's own source of projects, and by the files it ships.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from dataclasses import dataclass
from itertools import pairwise

from lxml import etree

from remodel_planner.core.catalogue import Catalogue, Place
from remodel_planner.core.production import Component, Order, Side, Terminal, TerminalRef, Wire
from remodel_planner.errors import DesignError

# QElectroTech's terminal orientations: north, east, south, west. East and west terminals open to
# the bottom of a component on a rail.
_NORTH = 0

_LEAVES = "it leaves the cabinet"
_SECTION = re.compile(r"(\d+(?:[.,]\d+)?)\s*mm", re.IGNORECASE)


@dataclass(frozen=True)
class LeftOut:
    """A conductor that became no wire, and why."""

    source: str
    reason: str


@dataclass(frozen=True)
class Account:
    """What an import read, guessed and left out.

    Attributes:
        conductors: number of conductors in the file. Each became a wire, was joined with others
            into wires, or was left out.
        joined: number of conductors that meet at folio references and were joined into wires.
        wires_joined: number of wires that those became.
        guesses: one line for each thing that the file does not say.
        left_out: the others.
    """

    conductors: int
    joined: int
    wires_joined: int
    guesses: tuple[str, ...]
    left_out: tuple[LeftOut, ...]

    @property
    def notes(self) -> tuple[str, ...]:
        """Guesses and what was left out, a line each."""
        omissions = (f"{item.source}: left out, {item.reason}" for item in self.left_out)
        return (*self.guesses, *omissions)


@dataclass(frozen=True)
class _Point:
    """A terminal as drawn: its element's place in the file, and its side and number there."""

    element: str
    side: Side
    number: int


@dataclass(frozen=True)
class _Conductor:
    source: str
    ends: tuple[_Point, _Point]
    colour: str
    section: str


def import_qet(text: bytes, name: str, source: str, catalogue: Catalogue) -> tuple[Order, Account]:
    """Read a project.

    Args:
        text: content of the `.qet` file.
        name: of the order to make.
        source: name of the file, for the record.
        catalogue: rules for what the file leaves unsaid.

    Raises:
        DesignError: if the text is no QElectroTech project or has no wire to place.
    """
    project = _parse(text)
    return _Reader(project, catalogue).order(name, source)


def _parse(text: bytes) -> etree._Element:
    parser = etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=False)
    try:
        root = etree.fromstring(text, parser)
    except etree.XMLSyntaxError as error:
        raise DesignError(f"no XML: {error}; a QElectroTech project is needed") from error
    if root.tag != "project" or root.find("diagram") is None:
        raise DesignError(
            f"the root element is <{root.tag}>; a QElectroTech project is a <project> with at "
            "least one <diagram>"
        )
    return root


class _Reader:
    """One pass over one project; every method fills what the next one needs."""

    def __init__(self, project: etree._Element, catalogue: Catalogue) -> None:
        self._project = project
        self._catalogue = catalogue
        self._guesses: list[str] = []
        self._left_out: list[LeftOut] = []
        self._definitions = _definitions(project)
        self._elements: dict[str, etree._Element] = {}
        self._places: dict[str, Place] = {}
        for element in project.iterfind("diagram/elements/element"):
            uuid = element.get("uuid", f"line {element.sourceline}")
            self._elements[uuid] = element
            self._places[uuid] = self._place(element)

    def order(self, name: str, source: str) -> tuple[Order, Account]:
        conductors = [
            conductor
            for folio, diagram in enumerate(self._project.iterfind("diagram"), start=1)
            for conductor in self._conductors(folio, diagram)
        ]
        count = len(conductors) + len(self._left_out)
        wires, joined, wires_joined = self._join(conductors)
        if not wires:
            raise DesignError(
                f"none of its {count} conductors joins two devices in the cabinet; "
                f"{_reasons(self._left_out)}"
            )
        components, placed = self._build(wires)
        account = Account(count, joined, wires_joined, tuple(self._guesses), tuple(self._left_out))
        title = self._project.get("title", "")
        return Order(name, title, source, components, placed, account.notes), account

    def _place(self, element: etree._Element) -> Place:
        path = element.get("type", "")
        definition = self._definitions.get(path)
        link_type = definition.get("link_type", "") if definition is not None else ""
        return self._catalogue.place(path, link_type)

    def _conductors(self, folio: int, diagram: etree._Element) -> list[_Conductor]:
        """Return the conductors of a folio whose ends are known; note the others as left out."""
        by_number = {
            terminal.get("id"): (element.get("uuid", f"line {element.sourceline}"), terminal)
            for element in diagram.iterfind("elements/element")
            for terminal in element.iterfind("terminals/terminal")
        }
        conductors = []
        for node in diagram.iterfind("conductors/conductor"):
            source = f"folio {folio}, line {node.sourceline}"
            first, second = (self._end(node, number, by_number) for number in ("1", "2"))
            if isinstance(first, str) or isinstance(second, str):
                reason = first if isinstance(first, str) else str(second)
                self._left_out.append(LeftOut(source, reason))
                continue
            # Colour and section are attributes since 0.80; before, people wrote them on the wire.
            section = node.get("conductor_section") or node.get("num") or ""
            colour = node.get("conductor_color", "").strip() or node.get("color", "")
            conductors.append(_Conductor(source, (first, second), colour, section))
        return conductors

    def _end(
        self,
        node: etree._Element,
        number: str,
        by_number: dict[str | None, tuple[str, etree._Element]],
    ) -> _Point | str:
        """Return the point at one end of a conductor, or why there is none."""
        uuid, key = node.get(f"element{number}"), node.get(f"terminal{number}", "")
        if uuid is None:
            if key not in by_number:
                return f"terminal {key!r} is on no element of the folio"
            uuid, terminal = by_number[key]
        elif uuid not in self._elements:
            return f"element {uuid} is not in the project"
        else:
            definition = self._definitions.get(self._elements[uuid].get("type", ""))
            terminals = definition.iter("terminal") if definition is not None else ()
            found = [terminal for terminal in terminals if terminal.get("uuid") == key]
            if not found:
                return f"terminal {key} is not in the definition of element {uuid}"
            terminal = found[0]
        return self._point(uuid, terminal)

    def _point(self, uuid: str, terminal: etree._Element) -> _Point:
        """Return the terminal by its side, and its number from left to right on that side."""
        side = _side(terminal)
        columns = {
            float(other.get("x", 0))
            for other in self._elements[uuid].iterfind("terminals/terminal")
            if _side(other) is side
        }
        x = float(terminal.get("x", 0))
        return _Point(uuid, side, sum(column < x for column in columns) + 1)

    def _join(self, conductors: list[_Conductor]) -> tuple[list[_Conductor], int, int]:
        """Return the wires, how many conductors were joined at references, and into how many."""
        wires: list[_Conductor] = []
        meetings: dict[str, list[_Conductor]] = defaultdict(list)
        group = self._reference_groups(conductors)
        for conductor in conductors:
            places = {self._places[end.element] for end in conductor.ends}
            if Place.DRAWING in places:
                self._left_out.append(LeftOut(conductor.source, "it ends on a picture"))
            elif Place.REFERENCE in places:
                meetings[group[_reference(conductor, self._places)]].append(conductor)
            elif places == {Place.PLATE}:
                wires.append(conductor)
            else:
                self._left_out.append(LeftOut(conductor.source, _LEAVES))
        joined = wires_joined = 0
        for meeting in meetings.values():
            chained, used = self._chain(meeting)
            wires += chained
            wires_joined += len(chained)
            joined += used
        place = {conductor.source: index for index, conductor in enumerate(conductors)}
        return sorted(wires, key=lambda wire: place[wire.source]), joined, wires_joined

    def _reference_groups(self, conductors: list[_Conductor]) -> dict[str, str]:
        """Return for each folio reference the first of all that carry the same potential."""
        parent = {uuid: uuid for uuid, place in self._places.items() if place is Place.REFERENCE}

        def find(uuid: str) -> str:
            while parent[uuid] != uuid:
                uuid = parent[uuid]
            return uuid

        links = [
            (uuid, link.get("uuid", ""))
            for uuid in parent
            for link in self._elements[uuid].iterfind("links_uuids/link_uuid")
        ]
        links += [
            (first.element, second.element)
            for first, second in (conductor.ends for conductor in conductors)
        ]
        for first, second in links:
            if first in parent and second in parent:
                low, high = sorted((find(first), find(second)))
                parent[high] = low
        return {uuid: find(uuid) for uuid in parent}

    def _chain(self, meeting: list[_Conductor]) -> tuple[list[_Conductor], int]:
        """Join the plate terminals that meet at references, each to the next in drawing order.

        Returns:
            The wires, and how many of the conductors they were made of.
        """
        inside: list[_Conductor] = []
        leaving: list[_Conductor] = []
        loose: list[tuple[_Point, _Conductor]] = []
        for conductor in meeting:
            ends = {self._places[end.element]: end for end in conductor.ends}
            (leaving if Place.FIELD in ends else inside).append(conductor)
            if Place.PLATE in ends:
                loose.append((ends[Place.PLATE], conductor))
        self._left_out += [LeftOut(conductor.source, _LEAVES) for conductor in leaving]
        if len(loose) < 2:
            reason = "its folio reference leads to no second device in the cabinet"
            self._left_out += [LeftOut(conductor.source, reason) for conductor in inside]
            return [], 0
        wires = [
            _Conductor(conductor.source, (first, second), conductor.colour, conductor.section)
            for (first, conductor), (second, _) in pairwise(loose)
        ]
        return wires, len(inside)

    def _build(
        self, conductors: list[_Conductor]
    ) -> tuple[tuple[Component, ...], tuple[Wire, ...]]:
        uses = Counter(end for conductor in conductors for end in conductor.ends)
        names = self._component_names()
        taken: Counter[_Point] = Counter()
        terminals: dict[str, list[Terminal]] = defaultdict(list)
        wires = []
        for number, conductor in enumerate(conductors, start=1):
            refs: list[TerminalRef] = []
            for end in conductor.ends:
                taken[end] += 1
                label = point = f"{'T' if end.side is Side.TOP else 'B'}{end.number}"
                if uses[end] > 1:
                    label += f".{taken[end]}"
                terminals[end.element].append(
                    Terminal(label, end.side, point if label != point else "")
                )
                refs.append(TerminalRef(names[end.element], label))
            colour, section = self._colour(conductor), self._section(conductor)
            a, b = refs
            wires.append(Wire(f"W{number}", a, b, colour, section, conductor.source))
        for end, count in uses.items():
            if count > 1:
                label = f"{names[end.element]}:{'T' if end.side is Side.TOP else 'B'}{end.number}"
                self._guesses.append(f"{label} is given {count} clamps, one for each of its wires")
        components = tuple(
            Component(
                names[uuid],
                self._kind(self._elements[uuid]),
                tuple(sorted(terminals[uuid], key=lambda terminal: terminal.name)),
            )
            for uuid in self._elements
            if uuid in terminals
        )
        return components, tuple(wires)

    def _component_names(self) -> dict[str, str]:
        """Give every element on the plate a name: its label, else its article, made unique."""
        names: dict[str, str] = {}
        seen: Counter[str] = Counter()
        for uuid, element in self._elements.items():
            if self._places[uuid] is not Place.PLATE:
                continue
            label = _information(element, "label")
            base = label or _information(element, "designation") or _file_name(element)
            seen[base] += 1
            names[uuid] = base if seen[base] == 1 else f"{base}#{seen[base]}"
            if names[uuid] != label:
                where = f"line {element.sourceline}"
                self._guesses.append(f"the element at {where} is named {names[uuid]}")
        return names

    def _kind(self, element: etree._Element) -> str:
        return (
            _information(element, "description")
            or _information(element, "designation")
            or _file_name(element)
        )

    def _colour(self, conductor: _Conductor) -> str:
        name = conductor.colour.lower()
        known = {**self._catalogue.colour_values, **self._catalogue.colour_names}
        if name in known:
            return known[name]
        code = conductor.colour.upper()
        if code in set(known.values()):
            return code
        default = self._catalogue.default_colour
        self._guesses.append(f"{conductor.source}: colour {name or 'not given'!r}, {default} taken")
        return default

    def _section(self, conductor: _Conductor) -> float:
        match = _SECTION.search(conductor.section)
        if match:
            return float(match[1].replace(",", "."))
        default = self._catalogue.default_section
        self._guesses.append(f"{conductor.source}: section not given, {default:g} mm2 taken")
        return default


def _definitions(project: etree._Element) -> dict[str, etree._Element]:
    """Return the definitions of the embedded collection by the path that elements refer to."""
    definitions = {}
    for element in project.iterfind("collection//element"):
        definition = element.find("definition")
        if definition is not None:
            folders = [a.get("name", "") for a in element.iterancestors("category")]
            path = "/".join([*reversed(folders), element.get("name", "")])
            definitions[f"embed://{path}"] = definition
    return definitions


def _side(terminal: etree._Element) -> Side:
    """Return the side on which a terminal opens; instances number it, definitions name it."""
    return Side.TOP if terminal.get("orientation") in (str(_NORTH), "n") else Side.BOTTOM


def _reference(conductor: _Conductor, places: dict[str, Place]) -> str:
    """Return the element of the (first) end that is a folio reference."""
    return next(end.element for end in conductor.ends if places[end.element] is Place.REFERENCE)


def _information(element: etree._Element, key: str) -> str:
    for node in element.iterfind("elementInformations/elementInformation"):
        if node.get("name") == key and node.text:
            return node.text.strip()
    return ""


def _file_name(element: etree._Element) -> str:
    return element.get("type", "element").rsplit("/", 1)[-1].removesuffix(".elmt")


def _reasons(left_out: list[LeftOut]) -> str:
    counts = Counter(item.reason for item in left_out)
    return "; ".join(f"{count}: {reason}" for reason, count in counts.most_common())
