"""Properties of wires by construction and section: the form of config/wire_materials.yaml."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields

from remodel_sim.core.errors import MaterialError


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


@dataclass(frozen=True)
class WireMaterials:
    """The table: materials by construction and section [mm^2]."""

    rows: Mapping[tuple[str, float], WireMaterial]

    def find(self, construction: str, section: float) -> WireMaterial:
        """Return a material; an empty construction means the first that has the section.

        Raises:
            MaterialError: when the table has none.
        """
        for (name, size), material in self.rows.items():
            if math.isclose(size, section) and construction in ("", name):
                return material
        there_are = ", ".join(f"{name} {size:g} mm2" for name, size in self.rows)
        wanted = f"{construction or 'any construction'} of {section:g} mm2"
        raise MaterialError(
            f"config/wire_materials.yaml has no wire of {wanted}; it has {there_are}: add a line, "
            "or give the wire all its properties"
        )


def materials_from(parsed: object) -> WireMaterials:
    """Build the table from the parsed YAML file.

    Raises:
        MaterialError: with everything that is wrong in it.
    """
    problems: list[str] = []
    rows = {key: row for key, row in _rows(parsed, problems)}
    if not rows and not problems:
        problems.append("it has no wire")
    if problems:
        lines = "\n".join(f"  - {problem}" for problem in problems)
        raise MaterialError(f"the table of wire materials has {len(problems)} problems:\n{lines}")
    return WireMaterials(rows)


def _rows(parsed: object, problems: list[str]) -> Iterator[tuple[tuple[str, float], WireMaterial]]:
    for construction, sections in _items(parsed, "the file", problems):
        for section, row in _items(sections, construction, problems):
            name = f"{construction} {section}"
            values = dict(_items(row, name, problems))
            unknown = sorted(values.keys() - set(PROPERTIES))
            missing = [key for key in PROPERTIES if key not in values]
            if unknown or missing:
                problems.append(f"{name}: unknown {unknown}, missing {missing}")
                continue
            numbers = {key: _number(value) for key, value in {"section": section, **values}.items()}
            wrong = [key for key, value in numbers.items() if not 0.0 <= value < math.inf]
            if wrong:
                problems.append(f"{name}: {', '.join(wrong)} must be a number of at least 0")
                continue
            yield (construction, numbers.pop("section")), WireMaterial(**numbers)


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
