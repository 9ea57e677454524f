"""The message of a board has the names of its tasks and all geometry; its text reads as it."""

from pathlib import Path

import pytest
import yaml
from boards import loom
from genpy.message import fill_message_args
from remodel_msgs.msg import Panel
from wire_lists import CATALOGUE

from remodel_production.core.board.board import board_of
from remodel_production.core.board.panel import panel_of
from remodel_production.core.imports.qet import import_qet
from remodel_states.core.wires import PROPERTIES
from remodel_supervision.ros.peers.board_message import board_message, panel_text
from remodel_tasks.core.orders.board_order import board_order
from remodel_tasks.edge.use_case_files import find_use_case

EXAMPLES = Path("/usr/share/qelectrotech/examples")


@pytest.mark.parametrize("name", ["tableau_domestique", "industrial"])
def test_the_wires_of_the_message_are_the_tasks_and_their_terminals_are_on_components(name):
    design = (EXAMPLES / f"{name}.qet").read_bytes()
    board = board_of(import_qet(design, name, name, CATALOGUE).order, CATALOGUE)
    order = board_order(board, find_use_case("cabinet"), arms=1)
    message = board_message(panel_of(board, CATALOGUE), order)
    terminals = {f"{c.id}:{t.id}" for c in message.components for t in c.terminals}
    assert [wire.id for wire in message.wires] == [task.name for task in order.tasks]
    for wire, task in zip(message.wires, order.tasks, strict=True):
        ends = (f"{wire.a_component}:{wire.a_terminal}", f"{wire.b_component}:{wire.b_terminal}")
        assert ends == task.terminals
        assert set(ends) <= terminals
        assert {*wire.ducts} <= {duct.id for duct in message.ducts}
        # The cell need not know the planner's materials.
        assert all(getattr(wire, name) > 0 for name in PROPERTIES)
    assert message.rails
    assert not message.channels


def test_the_text_of_a_panel_reads_as_the_message():
    board = board_of(loom(), CATALOGUE)
    order = board_order(board, find_use_case("automotive_formboard"), arms=1)
    message = board_message(panel_of(board, CATALOGUE), order)
    read = Panel()
    fill_message_args(read, [yaml.safe_load(panel_text(message))])
    assert read == message
    assert message.clips or message.ducts
