"""A cell that is killed finds again what a real one would: placed wires, and the time."""

import place_wire as do
import pytest
from panels import panel

from remodel_sim.cell import Cell
from remodel_sim.core.errors import MemoryFileError
from remodel_sim.core.panel import End
from remodel_sim.edge.cell_memory import CellMemory
from remodel_sim.physics.truth import ground_truth

OTHER = panel(name="other")


@pytest.fixture
def memory(tmp_path):
    memory = CellMemory(tmp_path / "cell")
    yield memory
    memory.close()


def test_a_placed_wire_is_there_after_the_cell_was_killed(memory):
    cell = Cell(panel(), seed=1, memory=memory)
    do.place(cell, "W1")
    before = ground_truth(cell.plant, ["W1"])
    cell.close()

    again = Cell(OTHER, seed=1, memory=memory)
    assert again.plant.parked == {}
    again.load(panel(), keep=True)
    try:
        assert ground_truth(again.plant, again.station.book.fed) == before
        assert again.plant.parked["W1"].nodes == pytest.approx(cell.plant.parked["W1"].nodes)
        assert again.station.book.occupant(("X1", "1")) == ("W1", End.A)
        do.place(again, "W2")
        assert all(truth.placed for truth in ground_truth(again.plant, ["W1", "W2"]))
    finally:
        again.close()


def test_a_panel_that_is_built_anew_is_empty(memory):
    cell = Cell(panel(), seed=1, memory=memory)
    try:
        do.place(cell, "W1")
        cell.load(panel(), keep=True)
        assert "W1" in cell.plant.parked, "the same panel stays"
        cell.load(panel())
        assert cell.plant.parked == {}
        assert memory.placed(panel()).parked == {}
    finally:
        cell.close()


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
