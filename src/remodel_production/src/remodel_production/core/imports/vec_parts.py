"""The composite parts of a VEC harness, such as modules, and the conditions of its variants.

A composite part, such as a module or a harness, has a PartStructureSpecification that lists its
components; an occurrence of a composite part among them stands for that part's components. An
element refers to its VariantConfiguration itself (ConfigInfo, until version 2.0), or a
ConfigurationConstraint in it, or in a specification of its own, does (from 2.0 and 2.0.2).
"""

from __future__ import annotations

from collections.abc import Iterator

from lxml import etree

from remodel_production.core.imports.design_format import (
    Asked,
    Composite,
    ModuleChoice,
    VariantCondition,
)
from remodel_production.core.imports.documents import line_of
from remodel_production.core.imports.kbl_parts import KblTree, children, shown, text_of, unit_scale
from remodel_production.core.imports.values import number
from remodel_production.core.production import Vector
from remodel_production.errors import DesignError

_TEXTS = ("LogisticControlExpression", "LogisticControlString")


def vec_modules(tree: KblTree, asked: Asked) -> ModuleChoice:
    """Return the choice of composite parts, by their part numbers, and of variants.

    Raises:
        DesignError: if the file has no such composite part or code.
    """
    conditions = dict(_conditions(tree))
    condition_of = {  # of the occurrences of composite parts
        structure: conditions[component]
        for component in conditions
        for role in children(component, "Role")
        for structure in tree.referred(role, "PartStructureSpecification")
    }
    composites: dict[str, Composite] = {}
    for structure in tree.all("Specification"):
        if next(children(structure, "InBillOfMaterial"), None) is None:
            continue
        is_module = "module" in text_of(structure, "Content").lower()
        each = Composite(_parts(tree, structure), is_module, condition_of.get(structure))
        composites.update(dict.fromkeys(_names(tree, structure), each))
    return ModuleChoice(composites, conditions, asked)


def _names(tree: KblTree, structure: etree._Element) -> list[str]:
    """Return the part numbers of the parts that a structure describes, else its own name."""
    numbers = [text_of(part, "PartNumber") for part in tree.referred(structure, "DescribedPart")]
    return [*filter(None, numbers)] or [text_of(structure, "Identification")]


def _parts(tree: KblTree, structure: etree._Element) -> frozenset[etree._Element]:
    """Return the components of a structure, and of the composite parts among them."""
    found: set[etree._Element] = set()
    left = [structure]
    while left:
        for component in tree.referred(left.pop(), "InBillOfMaterial"):
            if component in found:
                continue
            found.add(component)
            for role in children(component, "Role"):
                found.update(tree.referred(role, "SubComponent"))
                left += tree.referred(role, "PartStructureSpecification")
    return frozenset(found)


def _conditions(tree: KblTree) -> Iterator[tuple[etree._Element, VariantCondition]]:
    """Yield the elements that have a condition, each with it."""
    for name in ("Component", "PartUsage", "WireElementReference", "Routing"):
        for element in tree.all(name):
            inside = [element, *children(element, "ConfigurationConstraint")]
            for condition in (c for each in inside for c in _of(tree, each)):
                yield element, condition
    for constraint in tree.all("ConfigurationConstraint"):
        for element in tree.referred(constraint, "ConstrainedElements"):
            for condition in _of(tree, constraint):
                yield element, condition


def _of(tree: KblTree, element: etree._Element) -> Iterator[VariantCondition]:
    for configuration in tree.referred(element, "ConfigInfo"):
        text = next((t for key in _TEXTS if (t := text_of(configuration, key))), "")
        if text:
            yield VariantCondition(text, line_of(configuration))


_AXES = ("X", "Y", "Z")


def node_positions(tree: KblTree) -> tuple[dict[etree._Element, Vector], str]:
    """Return the places [m] of topology nodes, and a line about places that are not read.

    Building blocks have frames of their own: the places of the one with most nodes are taken, one
    in space before a drawing.

    Raises:
        DesignError: if a point has no coordinates.
    """
    blocks: dict[etree._Element, dict[etree._Element, Vector]] = {}
    for node in tree.all("GeometryNode"):
        block = node.getparent()
        for point in tree.referred(node, "CartesianPoint"):
            for represented in tree.referred(node, "ReferenceNode"):
                blocks.setdefault(block, {})[represented] = _position(tree, point, block)
    if not blocks:
        return {}, ""
    best = max(blocks, key=lambda block: (_is_in_space(block), len(blocks[block])))
    others = len(blocks) - 1
    note = f"the places of nodes are those of {shown(best)}; {others} other building blocks"
    return blocks[best], note if others else ""


def _is_in_space(block: etree._Element) -> bool:
    return any(text_of(point, "Z") for point in children(block, "CartesianPoint"))


def _position(tree: KblTree, point: etree._Element, block: etree._Element) -> Vector:
    units = tree.referred(block, "BaseUnit")
    scale = unit_scale(units[0] if units else None)
    values = [number(text_of(point, axis)) for axis in _AXES]
    x, y, z = values
    if x is None or y is None or scale is None:
        raise DesignError(
            f"{line_of(point)}: {shown(point)}: numbers are needed as X and Y, and a unit of "
            f"length as BaseUnit of {shown(block)}"
        )
    return round(x * scale, 9), round(y * scale, 9), round((z or 0.0) * scale, 9)
