"""A wire through the whole stack in one process, and what the events of a run come to."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from remodel_production.core.imports.formats import format_of, import_design
from remodel_production.edge.design_files import (
    catalogue_file,
    design_formats,
    read_catalogue,
    read_mappings,
)
from remodel_rehearsal import stack
from remodel_rehearsal.core.variation import vary
from remodel_rehearsal.edge.rehearsal_files import read_uncertainty
from remodel_rehearsal.stack import Outcome, Setting, differ, planned_wires, rehearse_wire
from remodel_sim.physics.plant import SimulatedPlant
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import OperationEnded, Part, TaskBegun
from remodel_work.edge.cell_file import read_cell
from remodel_work.panel import WireEnd
from remodel_work.ros.panel_message import read_panel
from remodel_work.routes import PlacedWires

PANEL = Path(__file__).parents[3] / "remodel_sim/config/household.yaml"
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


def test_a_plant_differs_from_its_model_as_its_seed_draws():
    plant = SimulatedPlant(read_panel(PANEL, read_wire_materials()), design=read_cell("cabinet"))
    drawn = vary(read_uncertainty(), 4, plant.design.overhead_names, [])
    differ(plant, drawn)
    (robot,), (design,) = plant.robots.values(), plant.design.robots
    assert robot.force_noise == drawn.force_noise > 0.0
    assert robot.grip_force == drawn.factors["grip_force"] * design.gripper.grip_force
    plant.close()


@pytest.mark.physics
def test_a_wire_of_a_strangers_cabinet_is_placed_in_a_cell_that_differs_from_its_model(setting):
    (wire,) = planned_wires(setting)
    found = rehearse_wire(setting, wire, 1, PlacedWires(), read_uncertainty())
    assert found.trial.placed, found.trial
    assert found.board.parked[wire].fixed == frozenset(WireEnd)
    assert {"LayWire", "InsertCable", "FixCable"} <= {call.ability for call in found.calls}
    # What is not physics, vision and skills takes little.
    assert found.cpu_s < 1.25 * found.physics_s


BEGUN = TaskBegun("W1", 1, Part.WHOLE, "Place Wire W1", chart="", at_s=1.0)
JAM = Operation("/Insert", "InsertCable", "failed", 301, text="jammed", ended_s=2.0, elapsed_s=1.0)
EMPTY = Operation("/Discard", "DiscardCable", "failed", 202, "empty", ended_s=4.0, elapsed_s=0.1)
GOOD = Operation("/Fix", "FixCable", "fixed", 0, text="fixed", ended_s=3.0, elapsed_s=1.0)


def rehearsed(monkeypatch, *events, placed=()):
    state = SimpleNamespace(ended=SimpleNamespace(because="the panel is refused"))
    after = PlacedWires({"W1": None})
    outcome = Outcome(state, events, frozenset(placed), (), after, cell_s=60.0)
    monkeypatch.setattr(stack, "carry_out", lambda *_, **__: outcome)
    before = PlacedWires()
    found = stack.rehearse_wire(Setting(None), "W1", 3, before, {})
    return found, found.board is (after if placed else before)


def test_a_wire_without_a_failed_ability_is_placed_at_once(monkeypatch):
    found, lies_as_it_should = rehearsed(
        monkeypatch, BEGUN, OperationEnded("W1", GOOD), placed=["W1"]
    )
    assert found.trial.at_once and lies_as_it_should


def test_a_failure_that_was_mended_is_kept_and_an_empty_hand_is_none(monkeypatch):
    operations = [OperationEnded("W1", each) for each in (JAM, EMPTY, GOOD)]
    found, _ = rehearsed(monkeypatch, BEGUN, *operations, placed=["W1"])
    assert found.trial.placed and not found.trial.at_once
    assert [(each.ability, each.code) for each in found.trial.failures] == [
        ("InsertCable", "INSERTION_JAMMED")
    ]


@pytest.mark.parametrize("events", [(), (BEGUN, OperationEnded("W1", GOOD))])
def test_a_wire_that_is_not_placed_has_a_reason_though_no_ability_failed(monkeypatch, events):
    found, lies_as_it_should = rehearsed(monkeypatch, *events)
    (failure,) = found.trial.failures
    assert (failure.code, failure.text) == ("NOT_PLACED", "the panel is refused")
    assert lies_as_it_should
