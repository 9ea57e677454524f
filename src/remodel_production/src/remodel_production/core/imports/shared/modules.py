"""Which wires of a harness are read: those of the modules and variants that are asked for.

A harness file describes all variants at once (150 %). A module lists its parts, and may have a
condition of variant codes; so may a part itself. What no module lists is in every variant.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from lxml import etree

from remodel_production.core.imports.shared.variant_codes import VariantCondition
from remodel_production.errors import DesignError
from remodel_run.whole_task import counted

_SHOWN = 20


@dataclass(frozen=True)
class Asked:
    """What is asked for; all is read if nothing is.

    Attributes:
        modules: part numbers of modules, or of what consists of modules.
        codes: variant codes that the vehicle has; an empty one stands for none.
    """

    modules: tuple[str, ...] = ()
    codes: tuple[str, ...] = ()


ALL = Asked()


@dataclass(frozen=True)
class Composite:
    """A part that lists other parts.

    Attributes:
        is_module: whether its parts are in some variants only.
        condition: of the variants that it is in; None: it is asked for by its name alone.
    """

    parts: frozenset[etree._Element]
    is_module: bool
    condition: VariantCondition | None = None


class ModuleChoice:
    """The parts that are chosen."""

    def __init__(
        self,
        composites: Mapping[str, Composite],
        conditions: Mapping[etree._Element, VariantCondition],
        asked: Asked,
    ) -> None:
        """Choose.

        Args:
            composites: by part number.
            conditions: of single parts.
            asked: what is asked for.

        Raises:
            DesignError: if there is no such part or code, or a condition cannot be read.
        """
        _require_known("module or harness configuration", asked.modules, composites, "--module")
        self._conditions = conditions
        self._codes = asked.codes
        modules = {name: each for name, each in composites.items() if each.is_module}
        written = [*conditions.values(), *(m.condition for m in modules.values() if m.condition)]
        if asked.codes:
            known = sorted({code for condition in written for code in condition.codes()})
            codes = [code for code in asked.codes if code]
            _require_known("variant code", codes, known, "--variant")
        chosen = [composites[name] for name in asked.modules]
        if asked.codes and not asked.modules:
            chosen = [
                module
                for module in modules.values()
                if module.condition is None or module.condition.holds(asked.codes)
            ]
        present = _parts(chosen)
        self._absent = _parts(modules.values()) - present if asked != ALL else frozenset()
        self.notes = tuple(_notes(asked, [*composites], len(modules), len(written)))

    def why_not(self, *parts: etree._Element | None) -> str:
        """Return why a wire with these parts is not chosen; empty if it is."""
        if any(part in self._absent for part in parts):
            return "its wire is in none of the modules asked for"
        for part in parts if self._codes else ():
            condition = self._conditions.get(part) if part is not None else None
            if condition is not None and not condition.holds(self._codes):
                return f"its variant {condition.text} is not asked for"
        return ""


def _parts(composites: Collection[Composite]) -> frozenset[etree._Element]:
    return frozenset[etree._Element]().union(*(composite.parts for composite in composites))


def _require_known(what: str, asked: Collection[str], known: Collection[str], option: str) -> None:
    unknown = [name for name in asked if name not in known]
    if unknown:
        advice = f"; there are {_shown(known)}: give one of them to" if known else ": omit"
        raise DesignError(f"the file has no {what} {unknown[0]}{advice} {option}")


def _notes(asked: Asked, names: list[str], modules: int, conditions: int) -> list[str]:
    notes = []
    if asked.modules:
        notes.append(f"the wires of modules {', '.join(sorted(asked.modules))} are read")
    elif modules > 1 and not asked.codes:
        notes.append(
            f"the parts of all {modules} modules are read, as of one harness; --module chooses of "
            f"{_shown(names)}"
        )
    if asked.codes:
        codes = ", ".join(filter(None, asked.codes)) or "none"
        notes.append(f"the wires of a vehicle with the variant codes {codes} are read")
    elif conditions:
        notes.append(
            "the parts of all variants are read, as of one harness, without regard to "
            f"{counted(conditions, 'condition')} of variant codes; --variant gives the codes of "
            "one vehicle"
        )
    return notes


def _shown(names: Collection[str]) -> str:
    return ", ".join([*names][:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")
