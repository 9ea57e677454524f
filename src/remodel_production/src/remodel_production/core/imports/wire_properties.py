"""Report of which sections of wires the table of materials has no data sheet, or nothing at all."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.imports.shared.account import Imported
from remodel_run.whole_task import counted
from remodel_states.core.wires.wire_materials import MaterialError


def with_wire_properties(imported: Imported, catalogue: Catalogue) -> Imported:
    """Return the import with a line for each section of which what wires are like is calculated."""
    sections = Counter(wire.section_mm2 for wire in imported.order.wires)
    lines = []
    for section, count in sorted(sections.items()):
        wires = f"{counted(count, 'wire')} of {section:g} mm2"
        try:
            origin = catalogue.materials.origin("", section)
        except MaterialError as error:
            lines.append(f"{wires}: {error}")
        else:
            lines += [f"{wires}: properties {origin}"] if origin else []
    order, account = imported.order, imported.account
    return Imported(
        replace(order, notes=(*order.notes, *lines)),
        replace(account, assumptions=(*account.assumptions, *lines)),
    )
