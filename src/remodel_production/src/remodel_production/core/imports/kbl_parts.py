"""What a KBL harness has besides its wires: poses, modules, and parts that no wire is."""

from __future__ import annotations

import math
from collections.abc import Iterator

from lxml import etree

from remodel_production.core.imports.kbl_tree import KblTree, children, text_of
from remodel_production.core.imports.shared.account import LeftOut
from remodel_production.core.imports.shared.assumptions import names_splice
from remodel_production.core.imports.shared.modules import Asked, Composite, ModuleChoice
from remodel_production.core.imports.shared.units import number
from remodel_production.core.imports.shared.variant_codes import VariantCondition
from remodel_production.core.imports.shared.xml_tree import line_of, local_name
from remodel_production.core.production import Pose, Vector


def placed_pose(tree: KblTree, occurrence: etree._Element) -> Pose | None:
    """Return where an occurrence is placed; None if it does not say."""
    for placement in children(occurrence, "Placement"):
        position = tree.position(placement)
        if position is not None:
            return Pose(position, _orientation(_vector(placement, "U"), _vector(placement, "V")))
    return None


def _vector(placement: etree._Element, key: str) -> Vector | None:
    values = [number(child.text or "") for child in children(placement, key)]
    known = [value for value in values if value is not None]
    if len(known) != 3 or not any(known):
        return None
    x, y, z = known
    return x, y, z


def _orientation(u: Vector | None, v: Vector | None) -> tuple[float, float, float, float]:
    """Return the quaternion of a frame by its x axis and (about) its y axis; identity by default.

    Shepperd's method, by the largest of trace and diagonal (J. Guidance and Control 1(3), 1978).
    """
    if u is None or v is None:
        return 0.0, 0.0, 0.0, 1.0
    x = _unit(u)
    z = _cross(x, v)
    if not any(abs(value) > 1e-9 for value in z):
        return 0.0, 0.0, 0.0, 1.0
    z = _unit(z)
    y = _cross(z, x)
    m = tuple(zip(x, y, z, strict=True))  # rows of the matrix with the axes as columns
    trace = m[0][0] + m[1][1] + m[2][2]
    if trace > 0:
        s = 2 * math.sqrt(trace + 1)
        q = (m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1])
        return q[0] / s, q[1] / s, q[2] / s, s / 4
    i = max(range(3), key=lambda n: m[n][n])
    j, k = (i + 1) % 3, (i + 2) % 3
    s = 2 * math.sqrt(max(0.0, 1 + m[i][i] - m[j][j] - m[k][k]))
    parts = [0.0, 0.0, 0.0]
    parts[i], parts[j], parts[k] = s / 4, (m[j][i] + m[i][j]) / s, (m[k][i] + m[i][k]) / s
    return parts[0], parts[1], parts[2], (m[k][j] - m[j][k]) / s


def _unit(vector: Vector) -> Vector:
    norm = math.sqrt(sum(value * value for value in vector))
    return vector[0] / norm, vector[1] / norm, vector[2] / norm


def _cross(a: Vector, b: Vector) -> Vector:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def kbl_modules(tree: KblTree, asked: Asked) -> ModuleChoice:
    """Return the choice of modules, by their part numbers or those of configurations of them.

    Raises:
        DesignError: if the harness has no such module, configuration or code.
    """
    modules = {module: _module(tree, module) for module in tree.all("Module")}
    composites = {text_of(element, "Part_number"): each for element, each in modules.items()}
    for configuration in tree.all("Harness_configuration"):
        inside = [modules[m] for m in tree.referred(configuration, "Modules") if m in modules]
        parts = frozenset[etree._Element]().union(*(module.parts for module in inside))
        composites.setdefault(text_of(configuration, "Part_number"), Composite(parts, False))
    return ModuleChoice(composites, {}, asked)


def _module(tree: KblTree, module: etree._Element) -> Composite:
    configurations = list(children(module, "Module_configuration"))
    controlled = [
        part
        for configuration in configurations
        for part in tree.referred(configuration, "Controlled_components")
    ]
    # A connection or a wiring group among them stands for its wires.
    wires = [
        wire
        for part in controlled
        for key in ("Wire", "Assigned_wire")
        for wire in tree.referred(part, key)
    ]
    parts = frozenset([*controlled, *wires])
    return Composite(parts, True, next(_conditions(configurations), None))


def _conditions(configurations: list[etree._Element]) -> Iterator[VariantCondition]:
    """Yield the conditions of codes; the information may also be a list of modules."""
    for configuration in configurations:
        text = text_of(configuration, "Logistic_control_information")
        if text and "module" not in text_of(configuration, "Configuration_type").lower():
            yield VariantCondition(text, line_of(configuration))


# What the elements are called, and why the order has nothing of those that are not referred to.
_PARTS = {
    "Cavity_seal_occurrence": ("cavity seal", "no contact point refers to it"),
    "Cavity_plug_occurrence": ("cavity plug", "no task closes empty cavities"),
    "Wire_protection_occurrence": ("wire protection", "no task wraps wires"),
    "Fixing_occurrence": ("fixing", "it is on no segment and at no node"),
    "Accessory_occurrence": ("accessory", "no task mounts it"),
    "Co_pack_occurrence": ("co-pack part", "no task mounts it"),
    "Assembly_part_occurrence": ("assembly part", "its parts are read where the harness has them"),
}
# By which elements a part that is used is referred to.
_USERS = (
    ("Cavity_seal_occurrence", "Contact_points", "Associated_parts"),
    ("Fixing_occurrence", "Fixing_assignment", "Fixing"),
    ("Fixing_occurrence", "Node", "Referenced_components"),
)


def is_splice(connector: etree._Element, part: etree._Element | None) -> bool:
    """Return whether a connector is a splice by its usage, or by its housing's type or text."""
    texts = [text_of(connector, "Usage")]
    if part is not None:
        texts += [text_of(part, key) for key in ("Housing_type", "Description", "Abbreviation")]
    return names_splice(*texts)


def twisted_groups(tree: KblTree) -> dict[etree._Element, str]:
    """Return the names of the twisted groups of wires, by wire."""
    groups: dict[etree._Element, str] = {}
    for group in tree.all("Wiring_group"):
        name = text_of(group, "Id") or group.get("id") or line_of(group)
        for wire in tree.referred(group, "Assigned_wire"):
            groups.setdefault(wire, name)
    return groups


def unused_parts(tree: KblTree) -> list[LeftOut]:
    """Return the occurrences of parts that the order has nothing of, and why."""
    used = {
        part
        for name, user, key in _USERS
        for element in tree.all(user)
        for part in tree.referred(element, key)
        if local_name(part).lower() == name.lower()
    }
    return [
        LeftOut(f"{line_of(part)}, {what} {text_of(part, 'Id') or part.get('id')}", why)
        for element, (what, why) in _PARTS.items()
        for part in tree.all(element)
        if part not in used
    ]
