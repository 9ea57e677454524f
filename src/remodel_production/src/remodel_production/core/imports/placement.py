"""Where a user says that devices are: the YAML that comes with a design, and its form.

devices: {S1: door, "M*": outside}     # by their names in the order: plate, door or outside
symbols: {"*/my_button.elmt": door}    # of QElectroTech, by their paths: also reference or drawing

A pattern may hold * for any letters; the first one that fits counts. The file counts more than the
catalogue and the list.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from enum import Enum
from fnmatch import fnmatchcase
from typing import TypeVar

from remodel_production.core.catalogue import Catalogue, Place
from remodel_production.core.imports.shared.account import Imported
from remodel_production.core.imports.shared.yaml_tree import Value, parse_yaml
from remodel_production.core.production import Mount
from remodel_production.errors import DesignError

_SECTIONS = ("devices", "symbols")
_Word = TypeVar("_Word", bound=Enum)


def with_placement(catalogue: Catalogue, text: str) -> Catalogue:
    """Return a catalogue in which a user's placement counts first.

    Raises:
        DesignError: naming the line, what was found, and what is allowed.
    """
    root = parse_yaml(text).mapping("the placement")
    for key, value in root.items():
        if key not in _SECTIONS:
            raise DesignError(
                f"{value.where}: the placement: key {key} is not known; allowed: "
                f"{', '.join(_SECTIONS)}"
            )
    symbols = tuple((name.lower(), place) for name, place in _entries(root, "symbols", Place))
    return replace(
        catalogue,
        placement=(*symbols, *catalogue.placement),
        mounts=tuple(_entries(root, "devices", Mount)),
    )


def with_mounts(imported: Imported, catalogue: Catalogue) -> Imported:
    """Return the order with its components where the user says that they are."""
    order, account = imported.order, imported.account
    components = tuple(
        replace(component, mount=catalogue.mount(component.name) or component.mount)
        for component in order.components
    )
    unknown = tuple(
        f"the placement names {pattern}, and no device is called so"
        for pattern, _ in catalogue.mounts
        if not any(fnmatchcase(component.name, pattern) for component in order.components)
    )
    account = replace(account, assumptions=(*account.assumptions, *unknown))
    order = replace(order, components=components, notes=(*order.notes, *unknown))
    return Imported(order, account)


def _entries(
    root: dict[str, Value], section: str, words: type[_Word]
) -> Iterator[tuple[str, _Word]]:
    for pattern, value in root[section].mapping(section).items() if section in root else ():
        known = {word.value: word for word in words}
        if value.text not in known:
            raise DesignError(
                f"{value.where}: {section}: {pattern}: {value.shown} found; allowed: "
                f"{', '.join(known)}"
            )
        yield pattern, known[value.text]
