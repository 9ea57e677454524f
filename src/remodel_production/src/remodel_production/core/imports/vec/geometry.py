"""Where the nodes of a VEC's topology are, by its building blocks."""

from __future__ import annotations

from lxml import etree

from remodel_production.core.imports.kbl_tree import KblTree, children, shown, text_of, unit_scale
from remodel_production.core.imports.shared.units import number
from remodel_production.core.imports.shared.xml_tree import line_of
from remodel_production.core.production import Vector
from remodel_production.errors import DesignError

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
