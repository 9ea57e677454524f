"""The elements of a KBL or VEC container by their ids, and the values that elements hold.

Names are compared without namespace, case and `_`: containers of different makers differ in the
first two, and VEC writes StartNode where KBL writes Start_node.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

from lxml import etree

from remodel_production.core.imports.shared.units import number
from remodel_production.core.imports.shared.xml_tree import line_of, local_name, parse_xml
from remodel_production.core.production import Vector
from remodel_production.errors import DesignError

_ASSEMBLY = "assembly_part"
_PREFIXES = {"milli": 1e-3, "centi": 1e-2, "deci": 0.1, "micro": 1e-6, "kilo": 1e3, "": 1.0}
# Units that are named, instead of built of SI ones.
_NAMED_M = {"millimetre": 1e-3, "millimeter": 1e-3, "mm": 1e-3, "metre": 1.0, "meter": 1.0, "m": 1}
_MM = 1e-3  # coordinates have no unit; the recommendation's drawings are in mm


class KblTree:
    """A container, indexed."""

    def __init__(self, text: bytes, root: str = "KBL_container") -> None:
        """Read a container whose root element has a name.

        Raises:
            DesignError: if it is no such container, or an id stands for two elements.
        """
        self.root = parse_xml(text)
        if _key(local_name(self.root)) != _key(root):
            raise DesignError(
                f"the root element is <{local_name(self.root)}>; a <{root}> is needed"
            )
        self._by_id: dict[str, etree._Element] = {}
        self._by_name: dict[str, list[etree._Element]] = {}
        inside = {e for part in children(self.root, _ASSEMBLY) for e in part.iter()}
        for element in self.root.iter():
            if element not in inside:
                self._by_name.setdefault(_key(local_name(element)), []).append(element)
            key = element.get("id")
            if key is None or element is self.root:
                continue
            if key in self._by_id:
                before = self._by_id[key]
                raise DesignError(
                    f"{line_of(element)}: id {key} of a <{local_name(element)}> is there before, "
                    f"at {line_of(before)} of a <{local_name(before)}>; an id stands for one "
                    "element: give one of them another id"
                )
            self._by_id[key] = element

    def all(self, *names: str) -> list[etree._Element]:
        """Return all elements of these names, name by name, but those of assembly parts.

        What an assembly part is made of, its parts list repeats, and the harness has again.
        """
        return [element for name in names for element in self._by_name.get(_key(name), [])]

    def referred(self, element: etree._Element, name: str) -> list[etree._Element]:
        """Return the elements to which a child's ids refer; none if there is no such child.

        Raises:
            DesignError: if an id stands for nothing.
        """
        found = []
        for child in children(element, name):
            for key in (child.text or "").split():
                if key not in self._by_id:
                    raise DesignError(
                        f"{line_of(child)}: {local_name(child)} of {shown(element)} refers to "
                        f"{key}, and no element has that id"
                    )
                found.append(self._by_id[key])
        return found

    def part(self, occurrence: etree._Element) -> etree._Element | None:
        """Return the part that an occurrence is one of; None if it does not say."""
        return next(iter(self.referred(occurrence, "Part")), None)

    def quantity(self, element: etree._Element, name: str, power: int = 1) -> float | None:
        """Return a child's numerical value [m^power]; None if it has none, or no known unit."""
        for child in children(element, name):
            value = number(text_of(child, "Value_component"))
            units = self.referred(child, "Unit_component")
            scale = _scale(units[0], power) if units else _MM**power
            if value is not None and scale is not None:
                return round(value * scale, 9)
        return None

    def position(self, element: etree._Element) -> Vector | None:
        """Return the place [m] of what has a Cartesian point; None if it has none."""
        for point in self.referred(element, "Cartesian_point"):
            values = [number(child.text or "") for child in children(point, "Coordinates")]
            known = [value for value in values if value is not None]
            if len(known) == len(values) and len(values) in (2, 3):
                x, y, z = (round(value * _MM, 9) for value in (*known, 0.0)[:3])
                return x, y, z
            raise DesignError(
                f"{line_of(point)}: {shown(point)}: two or three numbers are needed as Coordinates"
            )
        return None


def children(element: etree._Element, name: str) -> Iterator[etree._Element]:
    """Yield the children of that name."""
    wanted = _key(name)
    for child in element:
        if _key(local_name(child)) == wanted:
            yield child


@cache
def _key(name: str) -> str:
    return name.lower().replace("_", "")


def text_of(element: etree._Element, name: str) -> str:
    """Return a child's text; empty if there is none or it is the format's null."""
    for child in children(element, name):
        text = " ".join((child.text or "").split())
        return "" if text in ("/NULL", "-") else text
    return ""


def shown(element: etree._Element) -> str:
    """Return an element as an error names it."""
    name = text_of(element, "Id") or element.get("id", "")
    return f"{local_name(element)} {name}".strip()


def unit_scale(unit: etree._Element | None) -> float | None:
    """Return how many metres a unit is, a millimetre if none is given; None if none of length."""
    return _MM if unit is None else _scale(unit, 1)


def _scale(unit: etree._Element, power: int) -> float | None:
    """Return how many m^power the unit is; None if it is none of length."""
    named = text_of(unit, "Unit_name").lower()
    base = text_of(unit, "Si_unit_name").lower()
    if base in ("metre", "meter"):
        prefix = _PREFIXES.get(text_of(unit, "Si_prefix").lower())
        return None if prefix is None else prefix**power
    named = named.removeprefix("square").removesuffix("2").removesuffix("²").strip(" _-")
    return _NAMED_M[named] ** power if named in _NAMED_M else None
