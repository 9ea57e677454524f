"""A wire of a stranger's cabinet, through the whole stack in one process."""

from pathlib import Path

import pytest

from remodel_production.core.imports.formats import format_of, import_design
from remodel_production.edge.design_files import (
    catalogue_file,
    design_formats,
    read_catalogue,
    read_mappings,
)
from remodel_rehearsal.edge.rehearsal_files import read_uncertainty
from remodel_rehearsal.stack import Setting, planned_wires, rehearse_wire
from remodel_work.panel import WireEnd
from remodel_work.routes import PlacedWires

# A machine's cabinet of Debian's package qelectrotech-examples.
DESIGN = Path("/usr/share/qelectrotech/examples/schema_indus.qet")


@pytest.fixture(scope="module")
def setting():
    data = DESIGN.read_bytes()
    form = format_of(data, design_formats(read_mappings(None)))
    found = import_design(data, form, "machine", DESIGN.name, read_catalogue(catalogue_file()))
    return Setting(found.order, wires=1)


def test_the_wires_are_planned_in_the_same_order_each_time(setting):
    wires = Setting(setting.order)
    assert list(planned_wires(wires).items()) == list(planned_wires(wires).items())
    assert planned_wires(setting).items() <= planned_wires(wires).items()


@pytest.mark.physics
def test_a_wire_of_a_strangers_cabinet_is_placed_in_a_cell_that_differs_from_its_model(setting):
    (wire,) = planned_wires(setting)
    found = rehearse_wire(setting, wire, 1, PlacedWires(), read_uncertainty())
    assert found.trial.placed, found.trial
    assert found.board.parked[wire].fixed == frozenset(WireEnd)
    assert {"LayWire", "InsertCable", "FixCable"} <= {call.ability for call in found.calls}
    # What is not physics, vision and skills takes little.
    assert found.cpu_s < 1.25 * found.physics_s
