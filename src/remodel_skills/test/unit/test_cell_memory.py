"""A cell that is killed finds again what a real one would: placed wires, and the time."""

from dataclasses import replace

import numpy as np
import pytest
from panels import panel
from refusals import refused
from scripted_device import ScriptedPlant

from remodel_skills.belief_state import EndState
from remodel_skills.cell import Cell
from remodel_skills.edge.cell_memory import CellMemory
from remodel_skills.ros.owner import Owner
from remodel_states.core.codes import Code
from remodel_states.core.contract import NO_OWNER
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import MemoryFileError
from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd
from remodel_work.routes import ParkedWire, PlacedWires


@pytest.fixture
def memory(tmp_path):
    memory = CellMemory(tmp_path / "cell")
    yield memory
    memory.close()


def put_w1(cell):
    """Put a wire whose ends are fixed into a fresh cell."""
    occupied = {cell.plant.panel.wire("W1").goes_to(end): ("W1", end) for end in WireEnd}
    nodes = np.array([[0.43, -0.13, 0.02], [0.57, 0.11, 0.02]])
    placed = PlacedWires({"W1": ParkedWire(nodes, frozenset(WireEnd))}, occupied)
    cell.plant.load(cell.plant.loaded, placed.parked)
    cell.context.belief.restore(placed)


def test_a_board_that_the_cell_holds_elsewhere_now_has_no_wires_of_before(memory):
    cell = Cell(ScriptedPlant(panel()), memory=memory)
    put_w1(cell)
    cell.keep()
    cell.close()
    moved = replace(read_cell(), world_from_panel=Pose.level(0.52, 0.0, 0.0))
    for design, wires in ((moved, []), (read_cell(), ["W1"])):
        again = Cell(ScriptedPlant(panel(), design=design), memory=memory)
        assert list(again.plant.parked) == wires
        again.close()


def test_a_panel_that_is_rebuilt_is_empty(memory):
    cell = Cell(ScriptedPlant(panel()), memory=memory)
    try:
        put_w1(cell)
        cell.keep()
        cell.load(panel(), keep=True)
        assert "W1" in cell.plant.parked, "the same panel stays"
        cell.load(panel())
        assert cell.plant.parked == {}
        assert memory.placed(panel()).parked == {}
    finally:
        cell.close()


def test_a_wire_belongs_to_the_product_that_it_was_placed_on(memory):
    first, second = panel(serial="house-1"), panel(serial="house-2")
    placed = PlacedWires({"W1": ParkedWire(np.zeros((3, 3)), frozenset(WireEnd))})
    memory.keep(first, placed)
    assert list(memory.placed(first).parked) == ["W1"]
    assert memory.placed(second).parked == {}, "the next product is an empty panel"
    assert memory.placed(panel()).parked == {}


def test_the_newest_owner_outlives_the_process(memory):
    cell = Cell(ScriptedPlant(panel()), memory=memory)
    cell.admit(17)
    cell.admit(18)
    cell.close()
    again = Cell(ScriptedPlant(panel()), memory=memory)
    try:
        with refused(Code.STALE_OWNER):
            again.admit(17)
        again.admit(18)
        again.admit(NO_OWNER)
    finally:
        again.close()


def test_an_owner_that_no_cell_wrote_is_refused(memory, tmp_path):
    (tmp_path / "cell" / "owner").write_text("me")
    with pytest.raises(MemoryFileError, match="owner is not what a cell has kept"):
        Cell(ScriptedPlant(panel()), memory=memory)


def test_the_time_goes_on(memory, tmp_path):
    assert memory.time_s == 0.0
    memory.keep_time(12.5)
    again = CellMemory(tmp_path / "cell")
    assert again.time_s == 12.5
    again.close()


def test_a_file_that_no_cell_wrote_is_refused(memory, tmp_path):
    (tmp_path / "cell" / "wires.json").write_text('{"wires": []}')
    with pytest.raises(MemoryFileError, match=r"wires\.json is not what a cell has kept"):
        memory.placed(panel())


def test_a_folder_that_cannot_be_made_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(MemoryFileError, match="cannot be written to"):
        CellMemory(tmp_path / "file" / "cell")


class EndedJob:
    """A goal whose last step is done."""

    robots = ("robot_1",)

    def step(self):
        return True


def test_a_finished_wire_that_cannot_be_stored_ends_no_cell_and_is_stored_later(memory, tmp_path):
    cell = Cell(ScriptedPlant(panel()), memory=memory)
    cell.feed("W1", "A")
    cell.context.belief.ends.update(dict.fromkeys(WireEnd, EndState.FIXED))
    owner = Owner(cell, clock=None)
    (tmp_path / "cell").rename(tmp_path / "away")
    owner.jobs.append(EndedJob())
    owner.turn()
    assert list(cell.plant.parked) == ["W1"], "it has its place all the same"
    (tmp_path / "away").rename(tmp_path / "cell")
    cell.keep()
    assert list(memory.placed(panel()).parked) == ["W1"]
    cell.close()
