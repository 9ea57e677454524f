"""The elements, terminals and definitions of a QElectroTech project."""

from __future__ import annotations

from collections import defaultdict

from lxml import etree

from remodel_production.core.imports.shared.xml_tree import line_of
from remodel_production.core.production import Side
from remodel_production.errors import DesignError

# QElectroTech's terminal orientations: north, east, south, west. East and west terminals open to
# the bottom of a component on a rail.
_NORTH = 0
# A definition says where a terminal's line ends, an instance where it begins: 4 units inwards.
_INWARDS = {"n": (0, 4), "e": (-4, 0), "s": (0, -4), "w": (4, 0)}
# What QElectroTech writes in place of a number or a name that nobody has given.
UNNAMED = "_"

# x to the right and y down, in the drawing's units.
Spot = tuple[float, float]
# Terminals, each with its element's key, by their numbers on a folio.
ByNumber = dict[str, list[tuple[str, etree._Element]]]


def elements_of(project: etree._Element) -> dict[str, etree._Element]:
    """Return the elements of all folios by their keys.

    Raises:
        DesignError: if a uuid stands for two of them.
    """
    elements: dict[str, etree._Element] = {}
    for element in project.iterfind("diagram/elements/element"):
        key = key_of(element)
        if key in elements:
            raise DesignError(
                f"{line_of(element)}: element {key} is there before, at "
                f"{line_of(elements[key])}; a uuid stands for one element: give it another one"
            )
        elements[key] = element
    return elements


def key_of(element: etree._Element) -> str:
    """Return an element's uuid, or its place in the project before there were uuids."""
    return element.get("uuid") or element.getroottree().getpath(element)


def terminals_by_number(diagram: etree._Element) -> ByNumber:
    """Return the terminals of a folio, each with its element's key, by their numbers."""
    found: ByNumber = defaultdict(list)
    for element in diagram.iterfind("elements/element"):
        for terminal in element.iterfind("terminals/terminal"):
            found[terminal.get("id", "")].append((key_of(element), terminal))
    return found


def definitions_of(project: etree._Element) -> dict[str, etree._Element]:
    """Return the definitions of the embedded collection by the path that elements refer to."""
    definitions = {}
    for element in project.iterfind("collection//element"):
        definition = element.find("definition")
        if definition is not None:
            folders = [a.get("name", "") for a in element.iterancestors("category")]
            path = "/".join([*reversed(folders), element.get("name", "")])
            definitions[f"embed://{path}"] = definition
    return definitions


def side_of(terminal: etree._Element) -> Side:
    """Return the side on which a terminal opens; instances number it, definitions name it."""
    return Side.TOP if terminal.get("orientation") in (str(_NORTH), "n") else Side.BOTTOM


def spot_of(terminal: etree._Element) -> Spot:
    """Return where a terminal is in its element."""
    try:
        return float(terminal.get("x", "0")), float(terminal.get("y", "0"))
    except ValueError as error:
        raise DesignError(
            f"{line_of(terminal)}: a terminal is at x = {terminal.get('x')!r}, "
            f"y = {terminal.get('y')!r}; numbers are needed"
        ) from error


def docked(spot: Spot, orientation: str) -> Spot:
    """Return where an instance has a terminal that its definition has at the spot."""
    dx, dy = _INWARDS.get(orientation, (0, 0))
    return spot[0] + dx, spot[1] + dy


def terminal_names(definition: etree._Element | None) -> dict[tuple[Side, Spot], str]:
    """Return the names that a definition gives its terminals, by where an instance has them."""
    names = {}
    for terminal in () if definition is None else definition.iter("terminal"):
        name = " ".join(terminal.get("name", "").split())
        if name in ("", UNNAMED):
            continue
        spot, side = spot_of(terminal), side_of(terminal)
        for place in (spot, docked(spot, terminal.get("orientation", ""))):
            names[side, place] = name
    return names


def information(element: etree._Element, key: str) -> str:
    """Return what a person has written about an element; empty if nothing."""
    for node in element.iterfind("elementInformations/elementInformation"):
        if node.get("name") == key and node.text:
            return " ".join(node.text.split())
    return ""


def folio_of(element: etree._Element) -> int:
    """Return the number of the folio that an element is on, from 1."""
    diagram = next(element.iterancestors("diagram"))
    return 1 + sum(1 for _ in diagram.itersiblings("diagram", preceding=True))


def kind_of(element: etree._Element) -> str:
    """Return what an element is, for a person."""
    return (
        information(element, "description")
        or information(element, "designation")
        or file_name(element)
    )


def file_name(element: etree._Element) -> str:
    """Return the name of an element's definition."""
    return element.get("type", "element").rsplit("/", 1)[-1].removesuffix(".elmt") or "element"
