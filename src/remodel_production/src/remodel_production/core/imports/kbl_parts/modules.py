"""The modules and configurations of a KBL harness."""

from __future__ import annotations

from collections.abc import Iterator

from lxml import etree

from remodel_production.core.imports.kbl_tree import KblTree, children, text_of
from remodel_production.core.imports.shared.modules import Asked, Composite, ModuleChoice
from remodel_production.core.imports.shared.variant_codes import VariantCondition
from remodel_production.core.imports.shared.xml_tree import line_of


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
