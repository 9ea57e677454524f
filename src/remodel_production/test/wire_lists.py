"""Wire lists, read with the mappings that come with the package."""

import io
from pathlib import Path

from openpyxl import Workbook

from remodel_production.core.imports.wire_list import import_wire_list
from remodel_production.core.imports.wire_list_mapping import mapping_from
from remodel_production.edge.design_files import read_catalogue

CONFIG = Path(__file__).parents[1] / "config"
CATALOGUE = read_catalogue(CONFIG / "catalogue.yaml")
MAPPINGS = tuple(
    mapping_from(file.read_text()) for file in sorted((CONFIG / "wire_lists").glob("*.yaml"))
)


def read(data, *mappings):
    """Return the import of a list by those mappings, or by the package's."""
    data = data if isinstance(data, bytes) else data.encode()
    return import_wire_list(data, "test", "test.csv", CATALOGUE, mappings=mappings or MAPPINGS)


def workbook(merged=(), **sheets):
    """Return a workbook with the lines of each sheet; of the last one, cells are merged."""
    book = Workbook()
    book.remove(book.active)
    for title, lines in sheets.items():
        sheet = book.create_sheet(title)
        for line in lines:
            sheet.append(line)
    for span in merged:
        sheet.merge_cells(span)
    data = io.BytesIO()
    book.save(data)
    return data.getvalue()


def rows(imported):
    """Return the wires of an import as tuples."""
    return [
        (w.name, str(w.a), str(w.b), w.colour, w.section_mm2, w.length_m)
        for w in imported.order.wires
    ]
