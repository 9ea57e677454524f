"""What planner and cell both know of wires: their colours, and their properties by kind.

A wire of several colours has their codes one after another, the colour of its ground first: WHBU is
white with a blue stripe. Green-and-yellow is GNYE, in whichever order it is written.

The table of materials (config/wire_materials.yaml) has standard sections; another section, such as
that of an American wire gauge, has the properties of its two neighbours in the table, calculated as
for a wire between them whose strands and insulation are like theirs:

    diameter                      linear in the conductor's diameter, the root of the section
    mass, EI and GJ               linear in the section, as the number of strands that slip
    ferrule, curvatures, the rest that of the thicker neighbour
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace

Rgb = tuple[float, float, float]

# Chosen near RAL cable colours; none comes near the ferrules' magenta in hue and saturation. The
# codes are those of IEC 60757, those that WireViz adds (OL to SN), and DB for the dark blue of
# control voltages, which has no code there.
WIRE_RGB: dict[str, Rgb] = {
    "BK": (0.06, 0.06, 0.07),
    "BN": (0.40, 0.22, 0.10),
    "RD": (0.80, 0.06, 0.05),
    "OG": (0.95, 0.45, 0.05),
    "YE": (0.95, 0.80, 0.08),
    "GN": (0.08, 0.50, 0.16),
    "BU": (0.08, 0.22, 0.75),
    "VT": (0.36, 0.18, 0.60),
    "GY": (0.42, 0.44, 0.46),
    "WH": (0.97, 0.97, 0.96),
    "PK": (0.95, 0.62, 0.66),
    "TQ": (0.05, 0.62, 0.62),
    "GD": (0.79, 0.63, 0.15),
    "SR": (0.66, 0.66, 0.68),
    "DB": (0.05, 0.12, 0.36),
    "OL": (0.42, 0.44, 0.14),
    "LB": (0.40, 0.68, 0.90),
    "BG": (0.82, 0.72, 0.53),
    "IV": (0.93, 0.90, 0.76),
    "SL": (0.35, 0.40, 0.45),
    "CU": (0.72, 0.45, 0.20),
    "SN": (0.72, 0.72, 0.70),
}
GREEN_AND_YELLOW = "GNYE"
# The colours of most wires, which a camera distinguishes: the others are shades of them.
DISTINCT_COLOURS = (
    *("BK", "BN", "RD", "OG", "YE", "GN", "BU", "VT", "GY", "WH", "PK", "TQ"),
    GREEN_AND_YELLOW,
)
# Letters of a code.
_CODE = 2


def joined_colours(codes: Iterable[str]) -> str:
    """Return the colour of a wire with the colours of those codes, the ground's first."""
    colour = "".join(dict.fromkeys(codes))
    return GREEN_AND_YELLOW if colour == "YEGN" else colour


def codes_of(colour: str) -> tuple[str, ...]:
    """Return the codes of a wire's colours, known or not."""
    return tuple(colour[i : i + _CODE] for i in range(0, len(colour), _CODE))


def is_colour(colour: str) -> bool:
    """Return whether a wire may have that colour: one known code or several."""
    return bool(colour) and all(code in WIRE_RGB for code in codes_of(colour))


def rgbs_of(colour: str) -> tuple[Rgb, ...]:
    """Return what the colours of a wire look like, that of its ground first."""
    return tuple(WIRE_RGB[code] for code in codes_of(colour))


def hex_colours(colour: str) -> tuple[str, ...]:
    """Return the colours of a wire as HTML has them, such as "#1438bf"; grey for unknown ones."""
    unknown = (0.5, 0.5, 0.5)
    return tuple(
        "#" + "".join(f"{round(255 * level):02x}" for level in WIRE_RGB.get(code, unknown))
        for code in codes_of(colour) or ("",)
    )


def nearest_code(rgb: Rgb) -> str:
    """Return the distinct single colour that is nearest to an RGB value in 0 to 1."""
    single = [code for code in DISTINCT_COLOURS if code in WIRE_RGB]
    return min(
        single,
        key=lambda code: sum((a - b) ** 2 for a, b in zip(rgb, WIRE_RGB[code], strict=True)),
    )


class MaterialError(ValueError):
    """The table of wire materials is malformed or lacks a wire."""


@dataclass(frozen=True)
class WireMaterial:
    """A kind of wire; fields named as in remodel_msgs/Wire, SI units."""

    diameter: float
    linear_density: float
    bending_stiffness: float
    torsional_stiffness: float
    friction: float
    rest_curvature: float
    yield_curvature: float
    hardening: float
    ferrule_length: float


PROPERTIES = tuple(field.name for field in fields(WireMaterial))

# Of a row whose diameter and mass are from no data sheet.
_CALCULATED = "calculated"
_LINEAR = ("linear_density", "bending_stiffness", "torsional_stiffness")

_Key = tuple[str, float]


@dataclass(frozen=True)
class WireMaterials:
    """The table: materials by construction and section [mm^2], the preferred ones first.

    Attributes:
        calculated: those whose figures are from no data sheet.
    """

    rows: Mapping[_Key, WireMaterial]
    calculated: frozenset[_Key] = frozenset()

    def find(self, construction: str, section: float) -> WireMaterial:
        """Return a material, that of the table or one calculated from its neighbours in it.

        Args:
            construction: such as "H07V-K"; empty: the first that has the section.
            section: of the conductor [mm^2].

        Raises:
            MaterialError: if the section is beyond the table's.
        """
        thinner, thicker = self._neighbours(construction, section)
        return _between(thinner[1], self.rows[thinner], thicker[1], self.rows[thicker], section)

    def origin(self, construction: str, section: float) -> str:
        """Return from what a material is calculated; empty if the table has it from a data sheet.

        Args:
            construction: as of `find`.
            section: of the conductor [mm^2].

        Raises:
            MaterialError: if the section is beyond the table's.
        """
        thinner, thicker = self._neighbours(construction, section)
        if thinner != thicker:
            return f"calculated between {_named(thinner)} and {_named(thicker)}"
        return "calculated from strands and insulation" if thinner in self.calculated else ""

    def beside(self, own: WireMaterials) -> WireMaterials:
        """Return a table with rows of one's own, which are preferred to those of this one."""
        calculated = own.calculated | (self.calculated - own.rows.keys())
        return WireMaterials({**own.rows, **{**self.rows, **own.rows}}, calculated)

    def _neighbours(self, construction: str, section: float) -> tuple[_Key, _Key]:
        """Return the rows nearest to a section, not above and not below it; both may be the same.

        Raises:
            MaterialError: if there are none.
        """
        known: dict[float, _Key] = {}
        for key in self.rows:
            if construction in ("", key[0]):
                known.setdefault(key[1], key)
        same = next((key for size, key in known.items() if math.isclose(size, section)), None)
        if same is not None:
            return same, same
        thinner = max((size for size in known if size < section), default=None)
        thicker = min((size for size in known if size > section), default=None)
        if thinner is None or thicker is None:
            raise MaterialError(self._unknown(construction, section, tuple(known)))
        return known[thinner], known[thicker]

    def _unknown(self, construction: str, section: float, sections: tuple[float, ...]) -> str:
        of = f"{construction} " if construction else ""
        if sections:
            allowed = f"{min(sections):g} to {max(sections):g} mm2"
        else:
            allowed = f"constructions {', '.join(dict.fromkeys(name for name, _ in self.rows))}"
        return (
            f"no material is known of a wire of {of}{section:g} mm2; allowed: {allowed}: add it to "
            "a file that REMODEL_WIRE_MATERIALS names, or give the wire all its properties"
        )


def _between(
    below: float, thinner: WireMaterial, above: float, thicker: WireMaterial, section: float
) -> WireMaterial:
    """Return the material of a section [mm^2] between two, which may be one."""
    if below == above:
        return thicker
    share = (section - below) / (above - below)
    of_roots = (math.sqrt(section) - math.sqrt(below)) / (math.sqrt(above) - math.sqrt(below))
    found = {name: _mixed(name, thinner, thicker, share) for name in _LINEAR}
    return replace(thicker, diameter=_mixed("diameter", thinner, thicker, of_roots), **found)


def _mixed(name: str, thinner: WireMaterial, thicker: WireMaterial, share: float) -> float:
    first, last = getattr(thinner, name), getattr(thicker, name)
    # Four digits: more are not known.
    return float(f"{first + share * (last - first):.4g}")


def _named(key: _Key) -> str:
    return f"{key[0]} {key[1]:g} mm2"


def materials_from(parsed: object) -> WireMaterials:
    """Build the table from the parsed YAML file.

    Raises:
        MaterialError: with everything that is wrong in it.
    """
    problems: list[str] = []
    calculated: set[_Key] = set()
    rows = {key: row for key, row in _rows(parsed, problems, calculated)}
    if not rows and not problems:
        problems.append("it has no wire")
    if problems:
        lines = "\n".join(f"  - {problem}" for problem in problems)
        raise MaterialError(f"the table of wire materials has {len(problems)} problems:\n{lines}")
    return WireMaterials(rows, frozenset(calculated))


def _rows(
    parsed: object, problems: list[str], calculated: set[_Key]
) -> Iterator[tuple[_Key, WireMaterial]]:
    for construction, sections in _items(parsed, "the file", problems):
        for section, row in _items(sections, construction, problems):
            name = f"{construction} {section}"
            values = dict(_items(row, name, problems))
            mark = values.pop(_CALCULATED, False)
            unknown = sorted(values.keys() - set(PROPERTIES))
            missing = [key for key in PROPERTIES if key not in values]
            if unknown or missing:
                problems.append(f"{name}: unknown {unknown}, missing {missing}")
                continue
            if not isinstance(mark, bool):
                problems.append(f"{name}: {_CALCULATED} is {mark!r}; it must be true or false")
                continue
            numbers = {key: _number(value) for key, value in {"section": section, **values}.items()}
            wrong = [key for key, value in numbers.items() if not 0.0 <= value < math.inf]
            if wrong:
                problems.append(f"{name}: {', '.join(wrong)} must be a number of at least 0")
                continue
            key = (construction, numbers.pop("section"))
            calculated.update([key] if mark else [])
            yield key, WireMaterial(**numbers)


def _items(value: object, name: str, problems: list[str]) -> Iterator[tuple[str, object]]:
    if not isinstance(value, Mapping):
        problems.append(f"{name} is {value!r}; it must be a mapping")
        return
    yield from ((str(key), item) for key, item in value.items())


def _number(value: object) -> float:
    """Return a number, or NaN for what is none."""
    try:
        return float(str(value))
    except ValueError:
        return math.nan
