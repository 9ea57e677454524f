"""A cell without ROS and physics: what it loads and remembers, and who owns it."""

import dataclasses

import pytest
from panels import panel
from refusals import refused
from scripted_device import ScriptedPlant

from remodel_skills.abilities.extracting import DiscardGoal, discard_cable
from remodel_skills.belief_state import Grip
from remodel_skills.cell import Cell, check_owner
from remodel_states.core.codes import Code
from remodel_states.core.contract import NO_OWNER
from remodel_work.errors import PanelError
from remodel_work.panel import Channel, WireEnd

OTHER_CHANNEL = Channel(id="B", x=0.2, width=0.110, y_min=-0.3, y_max=0.3)


def changed(old, **changes):
    return dataclasses.replace(old, **changes)


def test_goals_that_the_robots_cannot_do_are_refused_with_the_panel_and_nothing_is_built():
    cell = Cell(ScriptedPlant(panel()))
    broken = changed(panel(), size=(2.0, 0.7, 0.003))
    with pytest.raises(PanelError) as caught:
        cell.load(broken, robots=("robot_1", "robot_2"), forces_n={"InsertCable": 40.0})
    robot, force, size = caught.value.problems
    assert robot == "the order's goals name robot 'robot_2'; the cell has robot_1"
    assert "InsertCable push with up to 40 N; this cell's grip holds at most 25 N" in force
    assert "the plate's size in x" in size
    assert cell.plant.panel == panel()
    cell.load(panel(), robots=("robot_1",), forces_n={"InsertCable": 25.0, "Push": 99.0})
    cell.close()


@pytest.fixture
def cell():
    made = Cell(ScriptedPlant(panel(channels=(*panel().channels, OTHER_CHANNEL))))
    made.feed("W1", "A")
    return made


def hold(cell, end):
    belief = cell.context.belief
    belief.grip = belief.picked_at[end] = Grip(end, 0.045, 0.0, 0.0, cell.context.commanded)


def test_a_piece_that_was_not_touched_is_presented_already(cell):
    live = cell.plant.live
    cell.feed("W1", "A")
    assert cell.plant.live is live, "no new piece"
    with refused(Code.WIRE_LEFT_BEHIND, "presented in channel 'A'"):
        cell.feed("W1", "B")
    assert cell.plant.live is live


def test_feeding_with_a_wire_in_the_hand_is_refused(cell):
    hold(cell, WireEnd.A)
    for wire in ("W1", "W2"):
        with refused(Code.OTHER_CABLE_HELD):
            cell.feed(wire, "A")


def test_no_piece_is_fed_beside_another_one_of_the_same_wire(cell):
    touched = cell.plant.live
    hold(cell, WireEnd.A)
    cell.context.belief.grip = None
    with refused(Code.WIRE_LEFT_BEHIND, "moved or connected"):
        cell.feed("W1", "A")
    assert cell.plant.live is touched
    cell.feed("W2", "A")
    with refused(Code.WIRE_LEFT_BEHIND, "left on the panel"):
        cell.feed("W1", "A")
    assert set(cell.plant.parked) == {"W1"} and cell.plant.is_at_hand("W2")


def test_a_hand_that_holds_another_wire_discards_none(cell):
    cell.feed("W2", "A")
    hold(cell, WireEnd.A)
    goal = DiscardGoal("robot_1", "W1")
    with refused(Code.OTHER_CABLE_HELD):
        goal.check(cell.context.panel, cell.context.belief, cell.context.parameters)
        cell.run(discard_cable(cell.context, goal))


def test_only_an_older_token_is_refused():
    for owner in (NO_OWNER, 17, 18):
        check_owner(owner, 17)
    with refused(Code.STALE_OWNER, "owner 16 no longer owns this cell, owner 17"):
        check_owner(16, 17)
