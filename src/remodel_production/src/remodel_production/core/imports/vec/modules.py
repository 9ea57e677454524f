"""The modules of a VEC harness, and which components those asked for have.

A composite part, such as a module or a harness, has a PartStructureSpecification that lists its
components; an occurrence of a composite part among them stands for that part's components.
"""

from __future__ import annotations

from collections.abc import Collection

from lxml import etree

from remodel_production.core.imports.kbl_tree import KblTree, children, text_of
from remodel_production.errors import DesignError

_SHOWN = 20


class VecModules:
    """The components of chosen composite parts, and of no module."""

    def __init__(self, tree: KblTree, asked: Collection[str]) -> None:
        """Choose composite parts by their part numbers.

        Raises:
            DesignError: if the file has no such composite part.
        """
        self._tree = tree
        structures = {
            name: structure
            for structure in tree.all("Specification")
            if next(children(structure, "InBillOfMaterial"), None) is not None
            for name in self._names(structure)
        }
        unknown = [name for name in asked if name not in structures]
        if unknown:
            known = ", ".join([*structures][:_SHOWN]) + (
                ", ..." if len(structures) > _SHOWN else ""
            )
            raise DesignError(
                f"no module or other composite part {unknown[0]}; there are {known or 'none'}: "
                "give one of their part numbers to --module"
            )
        modules = {
            name: structure
            for name, structure in structures.items()
            if "module" in text_of(structure, "Content").lower()
        }
        present = self._parts([structures[name] for name in asked])
        self._absent = self._parts(modules.values()) - present if asked else set()
        self.note = ""
        if asked:
            self.note = f"the wires of modules {', '.join(sorted(asked))} are read"
        elif len(modules) > 1:
            self.note = (
                f"the parts of all {len(modules)} modules are read, as of one harness; --module "
                f"chooses of {', '.join([*structures][:_SHOWN])}"
            )

    def has(self, component: etree._Element | None) -> bool:
        """Return whether a component is chosen."""
        return component not in self._absent

    def _names(self, structure: etree._Element) -> list[str]:
        """Return the part numbers of the parts that a structure describes, else its own name."""
        numbers = [
            text_of(part, "PartNumber") for part in self._tree.referred(structure, "DescribedPart")
        ]
        return [*filter(None, numbers)] or [text_of(structure, "Identification")]

    def _parts(self, structures: Collection[etree._Element]) -> set[etree._Element]:
        """Return the components of structures, and of the composite parts among them."""
        found: set[etree._Element] = set()
        left = [*structures]
        while left:
            for component in self._tree.referred(left.pop(), "InBillOfMaterial"):
                if component in found:
                    continue
                found.add(component)
                for role in children(component, "Role"):
                    found.update(self._tree.referred(role, "SubComponent"))
                    left += self._tree.referred(role, "PartStructureSpecification")
        return found
