"""Parts of a KBL harness that no wire is: splices, twisted groups, and what no task mounts."""

from __future__ import annotations

from lxml import etree

from remodel_production.core.imports.kbl_tree import KblTree, text_of
from remodel_production.core.imports.shared.account import LeftOut
from remodel_production.core.imports.shared.splices import names_splice
from remodel_production.core.imports.shared.xml_tree import line_of, local_name

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
