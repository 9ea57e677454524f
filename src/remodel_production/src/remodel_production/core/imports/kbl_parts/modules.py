"""The modules of a KBL harness, and which wires those asked for have."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from lxml import etree

from remodel_production.core.imports.kbl_tree import KblTree, children, text_of
from remodel_production.errors import DesignError

_SHOWN = 20


class ModuleChoice:
    """The wires of chosen modules, and of none."""

    def __init__(self, tree: KblTree, asked: Collection[str]) -> None:
        """Choose modules by their part numbers, or by those of configurations that consist of them.

        Raises:
            DesignError: if the harness has no such module or configuration.
        """
        modules = {text_of(module, "Part_number"): module for module in tree.all("Module")}
        configurations = {
            text_of(each, "Part_number"): tree.referred(each, "Modules")
            for each in tree.all("Harness_configuration")
        }
        controlled = {
            name: {
                part
                for configuration in children(module, "Module_configuration")
                for part in tree.referred(configuration, "Controlled_components")
            }
            for name, module in modules.items()
        }
        names = [*modules, *configurations]
        known = ", ".join(names[:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")
        chosen: set[str] = set()
        for name in asked:
            if name in modules:
                chosen.add(name)
            elif name in configurations:
                parts = configurations[name]
                chosen |= {other for other, module in modules.items() if module in parts}
            else:
                raise DesignError(
                    f"no module or harness configuration {name}; there are {known or 'none'}: "
                    "give one of their part numbers to --module"
                )
        absent = [parts for name, parts in controlled.items() if name not in chosen]
        present = [parts for name, parts in controlled.items() if name in chosen]
        self._absent = set().union(*absent) - set().union(*present) if asked else set()
        self.note = ""
        if asked:
            self.note = f"the wires of modules {', '.join(sorted(chosen))} are read"
        elif len(modules) > 1:
            self.note = (
                f"the parts of all {len(modules)} modules are read, as of one harness; --module "
                f"chooses of {known}"
            )

    def has(self, wires: Iterable[etree._Element]) -> bool:
        """Return whether wires, or the cables that they are cores of, are chosen."""
        return not any(wire in self._absent or wire.getparent() in self._absent for wire in wires)
