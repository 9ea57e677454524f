"""What design files leave unsaid: where elements are mounted, what wires are like.

The values stand in config/catalogue.yaml; this is their form.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from fnmatch import fnmatchcase
from typing import Any

from remodel_production.core.production import Role
from remodel_production.errors import CatalogueError


class Place(Enum):
    """Where an element of a drawing is mounted."""

    PLATE = "plate"
    FIELD = "field"
    REFERENCE = "reference"
    DRAWING = "drawing"


# Link types of QElectroTech's elements that are no devices; they hold in collections of any kind.
_PLACES_OF_LINK_TYPES = {
    "next_report": Place.REFERENCE,
    "previous_report": Place.REFERENCE,
    "thumbnail": Place.DRAWING,
}


@dataclass(frozen=True)
class WireType:
    """Properties of a wire of one section.

    Attributes:
        diameter_m: [m] over the insulation.
        density_kg_m: [kg/m] per length.
        stiffness_n_m2: [N m^2] EI.
        ferrule_m: [m] length of the rigid end.
    """

    diameter_m: float
    density_kg_m: float
    stiffness_n_m2: float
    ferrule_m: float


@dataclass(frozen=True)
class TerminalRule:
    """How wire ends go into the terminals of some components.

    Attributes:
        role: of the components.
        part: pattern of their part numbers.
        force_limit_n: [N] that an insertion must not exceed.
        clearance_m: [m] around an opening, for the gripper.
    """

    role: Role
    part: str
    force_limit_n: float
    clearance_m: float


@dataclass(frozen=True)
class Catalogue:
    """Rules and tables for what a design file leaves unsaid."""

    placement: tuple[tuple[str, Place], ...]
    colour_names: Mapping[str, str]
    colour_values: Mapping[str, str]
    colour_codes: frozenset[str]
    default_colour: str
    default_section: float
    wires: Mapping[float, WireType]
    terminals: tuple[TerminalRule, ...]

    def place(self, path: str, link_type: str) -> Place:
        """Return where an element belongs, by its path in the collection and its link type."""
        if link_type in _PLACES_OF_LINK_TYPES:
            return _PLACES_OF_LINK_TYPES[link_type]
        for pattern, place in self.placement:
            if fnmatchcase(path, pattern):
                return place
        return Place.PLATE

    def terminal_rule(self, role: Role, part_number: str) -> TerminalRule:
        """Return the first rule that fits a component; the last one of each role fits all."""
        return next(
            rule
            for rule in self.terminals
            if rule.role is role and fnmatchcase(part_number, rule.part)
        )

    def wire_type(self, section_mm2: float) -> WireType:
        """Return the properties of a wire of that section.

        Raises:
            CatalogueError: if the catalogue has no such section.
        """
        if section_mm2 not in self.wires:
            known = ", ".join(f"{section:g}" for section in sorted(self.wires))
            raise CatalogueError(
                f"the catalogue has no wire of {section_mm2:g} mm2; it has {known}: add a line to "
                "`wires` in config/catalogue.yaml"
            )
        return self.wires[section_mm2]


def catalogue_from(data: Mapping[str, Any]) -> Catalogue:
    """Build a catalogue from a document in the form of config/catalogue.schema.json.

    Raises:
        CatalogueError: if a role has no rule for terminals of any part.
    """
    terminals = tuple(
        TerminalRule(
            Role(row["role"]), row["part"], float(row["force_limit"]), float(row["clearance"])
        )
        for row in data["terminals"]
    )
    for role in Role:
        if not any(rule.role is role and rule.part == "*" for rule in terminals):
            raise CatalogueError(
                f"terminals: no rule with part '*' for role {role.value}: add one at the end"
            )
    return Catalogue(
        placement=tuple((rule["pattern"], Place(rule["place"])) for rule in data["placement"]),
        colour_names=data["colour_names"],
        colour_values=data["colour_values"],
        colour_codes=frozenset(data["colour_codes"]),
        default_colour=data["default_colour"],
        default_section=float(data["default_section"]),
        wires={
            float(section): WireType(
                float(row["diameter"]),
                float(row["density"]),
                float(row["stiffness"]),
                float(row["ferrule"]),
            )
            for section, row in data["wires"].items()
        },
        terminals=terminals,
    )
