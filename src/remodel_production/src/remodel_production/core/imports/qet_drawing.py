"""The elements, terminals and definitions of a QElectroTech project."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator
from math import dist

from lxml import etree

from remodel_production.core.imports.documents import line_of
from remodel_production.core.production import Side
from remodel_production.errors import DesignError

# QElectroTech's terminal orientations: north, east, south, west. East and west terminals open to
# the bottom of a component on a rail.
_NORTH = 0
# A definition says where a terminal's line ends, an instance where it begins: 4 units inwards.
_INWARDS = {"n": (0, 4), "e": (-4, 0), "s": (0, -4), "w": (4, 0)}
# What QElectroTech writes in place of a number or a name that nobody has given.
UNNAMED = "_"

# Names that people write beside terminals: 13, A1, L+, 1/L1. A symbol of one terminal has a text of
# another kind, such as its label.
_TERMINAL_NAME = re.compile(r"[0-9A-Z]{1,4}[+-]?(/[0-9A-Z]{1,4})?|[+-]")
_LEAST_NAMED = 2
# How far beside a terminal its name is, and how high a line is, in the drawing's units: a grid's
# step is 10.
_BESIDE, _LINE = 16.0, 8.0

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


def terminal_names(definition: etree._Element | None) -> tuple[dict[tuple[Side, Spot], str], bool]:
    """Return the names that a definition gives its terminals, by where an instance has them.

    Before they had names, people wrote them beside the terminals: these texts are the names if each
    terminal has one of its own.

    Returns:
        The names, and whether they are such texts.
    """
    terminals = [] if definition is None else list(definition.iter("terminal"))
    given = [" ".join(terminal.get("name", "").split()) for terminal in terminals]
    are_texts = definition is not None and all(name in ("", UNNAMED) for name in given)
    if definition is not None and are_texts:
        given = _names_beside(terminals, list(_texts_of(definition)))
    names = {}
    for terminal, name in zip(terminals, given, strict=False):
        if name not in ("", UNNAMED):
            spot, side = spot_of(terminal), side_of(terminal)
            for place in (spot, docked(spot, terminal.get("orientation", ""))):
                names[side, place] = name
    return names, are_texts and bool(names)


def _names_beside(terminals: list[etree._Element], texts: list[tuple[Spot, str]]) -> list[str]:
    """Return the text beside each terminal; none if not each of them has one of its own.

    A terminal and its text are each other's nearest.
    """
    spots = [spot_of(terminal) for terminal in terminals]
    if len(spots) < _LEAST_NAMED or len(texts) < len(spots):
        return []
    names = []
    for spot in spots:
        place, name = min(texts, key=lambda text: dist(text[0], spot))
        if dist(place, spot) > _BESIDE or min(spots, key=lambda s: dist(place, s)) != spot:
            return []
        names.append(name)
    return names if len(set(names)) == len(names) else []


def _texts_of(definition: etree._Element) -> Iterator[tuple[Spot, str]]:
    """Yield the texts of a definition that may be names of terminals, with their places."""
    for node in definition.iter("text", "input", "dynamic_text"):
        if node.get("x") is None or node.get("tagg") == "label":
            continue
        lines = (node.get("text") or node.findtext("text") or "").split()
        if lines and _TERMINAL_NAME.fullmatch("/".join(lines)):
            x, y = spot_of(node)
            # The place of a dynamic text is its upper corner, that of the others its base line.
            yield (x, y + _LINE if node.tag == "dynamic_text" else y), "/".join(lines)


def information(element: etree._Element, key: str) -> str:
    """Return what a person has written about an element; empty if nothing."""
    for node in element.iterfind("elementInformations/elementInformation"):
        text = " ".join((node.text or "").split())
        if node.get("name") == key and text not in ("", UNNAMED):
            return text
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
