"""The shipped cells, by physics, without ROS."""

import numpy as np
import place_wire
import pytest
from panels import example, moved_onto, panel

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth, share_in_ducts
from remodel_skills.abilities.inserting import FixGoal, InsertGoal, fix_cable, insert_cable
from remodel_skills.abilities.inspection import LocateGoal, locate_gearbox_component
from remodel_skills.abilities.picking import PickGoal, PlaceGoal, pick_cable, place_cable
from remodel_skills.abilities.place_pin import PlacePinGoal, place_pin
from remodel_skills.cell import Cell
from remodel_skills.primitives.together import concurrently
from remodel_skills.robot_context import occupy, run
from remodel_work.edge.cell_file import read_cell
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, WireEnd

pytestmark = pytest.mark.physics


@pytest.mark.slow
def test_an_iiwa_places_a_whole_wire():
    made = Cell(SimulatedPlant(panel(), design=read_cell("one_iiwa"), seed=1))
    place_wire.place(made, "W1")
    (truth,) = ground_truth(made.plant, ["W1"])
    assert truth.placed
    made.close()


@pytest.fixture
def cell():
    """Two Pandas, W1 fed."""
    made = Cell(SimulatedPlant(panel(), design=read_cell("two_pandas"), seed=1))
    made.feed("W1", "A")
    yield made
    made.close()


def do(cell, robot, ability, goal):
    context = cell.contexts[robot]
    goal.check(context.panel, context.belief, context.parameters)
    return cell.run(ability(context, goal), robot)


def gap(cell):
    """Return how near the arms are to each other [m], at most 0.5."""
    first, second = (robot.body for robot in cell.plant.robots.values())
    points = cell.plant.world.bullet.getClosestPoints(first, second, 0.5)
    return min((point[8] for point in points), default=0.5)


def watched(cell, steps, gaps):
    """Do steps and note how near the arms come to each other."""
    try:
        while True:
            next(steps)
            gaps.append(gap(cell))
            yield
    except StopIteration as done:
        return done.value


def test_two_arms_work_at_once_and_keep_apart(cell):
    one, two = cell.contexts.values()
    locate = locate_gearbox_component(one, LocateGoal("X2", "1"))
    pick = pick_cable(two, PickGoal("robot_2", "W1", WireEnd.B, 0.0))
    gaps = []
    both = concurrently(occupy([one], locate), occupy([two], pick))
    located, _ = run(cell.plant.tick, watched(cell, both, gaps))
    assert located.socket_pose is not None
    assert two.belief.grip is not None and one.belief.grip is None
    assert min(gaps) > 0.03, "what the claims keep free"


@pytest.mark.slow
def test_a_wire_goes_from_one_arm_to_the_other_by_the_plate(cell):
    do(cell, "robot_1", pick_cable, PickGoal("robot_1", "W1", WireEnd.A, 0.0))
    belief, tool = cell.context.belief, cell.context.commanded
    lying = Pose.level(tool.x, tool.y, 0.0035, tool.yaw + belief.grip.flip)
    do(cell, "robot_1", place_cable, PlaceGoal("robot_1", "W1", lying))
    located = do(cell, "robot_2", locate_gearbox_component, LocateGoal("X1", "1"))
    socket = located.socket_pose
    goal = InsertGoal(
        robot_name="robot_2",
        cable_id="W1",
        end=WireEnd.A,
        component_id="X1",
        terminal_id="1",
        socket=socket,
        force_limit=8.0,
    )
    do(cell, "robot_2", insert_cable, goal)
    do(
        cell,
        "robot_2",
        fix_cable,
        FixGoal(
            robot_name="robot_2",
            cable_id="W1",
            component_id="X1",
            terminal_id="1",
            pull_test_force=10.0,
        ),
    )
    (truth,) = ground_truth(cell.plant, ["W1"])
    assert (truth.a.at, truth.a.fixed) == ("X1/1", True)


@pytest.mark.parametrize("times", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_two_arms_place_the_pins_of_a_wire_also_again(cell, times):
    one, two = cell.contexts.values()
    goal = PlacePinGoal(
        robot_1="robot_1",
        robot_2="robot_2",
        path_space=0.10,
        connector_space=0.474,
        centered=True,
        rotate=True,
        show_in_tf=False,
    )
    for _ in range(times):
        for context in (one, two):
            goal.check(context.panel, context.belief, context.parameters)
        cell.run(place_pin(one, two, goal), "robot_1", "robot_2")
        for end, y in ((WireEnd.A, -0.237), (WireEnd.B, 0.237)):
            tip = cell.plant.live.cable.tip(end)[0]
            assert np.linalg.norm(tip[:2] - [0.5, y]) < 0.015
        assert one.commanded == one.home and two.commanded == two.home


@pytest.mark.slow
def test_small_labels_show_no_tilt_where_there_is_none():
    household = example("household")
    made = Cell(SimulatedPlant(household, design=read_cell("two_arms_cabinet"), seed=1))
    made.feed("W105", "")
    for terminal in (("Q3", "B2.7"), ("D31", "T2"), ("D35", "T2"), ("D32", "T1")):
        for view in range(3):
            goal = LocateGoal(*terminal, view)
            found = place_wire.do(made, locate_gearbox_component, goal).socket_pose
            true = BOARD @ household.panel_from_socket(*terminal)
            np.testing.assert_allclose(found.position, true.position, atol=5e-4)
    made.close()


@pytest.mark.slow
def test_two_heads_place_a_wire_in_a_far_corner_of_the_largest_plate():
    design = read_cell("large_cabinet")
    board = moved_onto(example("household"), design.takes.plate, 0.30, 0.25)
    made = Cell(SimulatedPlant(board, design=design, seed=1))
    place_wire.place_in_ducts(made, "W3", WireEnd.B)
    (truth,) = ground_truth(made.plant, ["W3"])
    assert truth.placed
    assert share_in_ducts(made.plant, "W3") > 0.9
    made.close()
