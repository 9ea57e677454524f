"""A panel that a cell cannot hold is refused, and nothing is built."""

import dataclasses

import pytest
from panels import panel

from remodel_sim.physics.plant import SimulatedPlant
from remodel_work.errors import PanelError


def changed(old, **changes):
    return dataclasses.replace(old, **changes)


def with_wire(**changes):
    good = panel()
    return changed(good, wires=(changed(good.wires[0], **changes), good.wires[1]))


def test_all_problems_are_reported_at_once_and_nothing_is_built():
    plant = SimulatedPlant(panel())
    bodies = plant.world.bullet.getNumBodies()
    broken = changed(with_wire(colour="XX", length=9.0), size=(2.0, 0.7, 0.003))
    with pytest.raises(PanelError) as caught:
        plant.load(broken)
    assert len(caught.value.problems) == 3
    assert plant.panel == panel()
    assert plant.world.bullet.getNumBodies() == bodies
    plant.close()
