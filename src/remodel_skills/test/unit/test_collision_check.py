"""Motions that would touch what stands on the plate, found before anything moves."""

import math
from dataclasses import replace
from itertools import product

import pytest
from panels import example, panel
from refusals import refused
from scripted_device import ScriptedPlant

from remodel_skills.belief_state import Feed, Grip
from remodel_skills.cell import Cell
from remodel_skills.edge.collision_check import BulletCollisionCheck
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.motion import Line
from remodel_skills.primitives.motions import move_to, straight_line
from remodel_skills.primitives.pushing import tool_before
from remodel_skills.space import HeldTip
from remodel_states.core.codes import Code
from remodel_work.component_shape import Box
from remodel_work.edge.cell_file import read_cell
from remodel_work.layout import STANDOFF_M
from remodel_work.obstacles import (
    WIRES,
    Obstacles,
    Solid,
    component_name,
    panel_obstacles,
)
from remodel_work.panel import BOARD, WireEnd
from remodel_work.robot.arm import ToolPose

MOTION = read_parameters().parameters.motion
DESIGN = read_cell("cabinet")
(ROBOT,) = DESIGN.robots
# A block of 20 x 20 x 50 mm, in the middle of the plate.
BLOCK = Obstacles((Solid("the block", Box((0.5, 0.0, 0.025), (0.02, 0.02, 0.05), (1, 1, 1))),))
OPEN_M = 0.024
# Behind the tip: fingers and wire fit between a device and the duct before it.
GRASP_M = 0.025
X2 = component_name("X2")


@pytest.fixture(scope="module")
def check():
    made = BulletCollisionCheck(ROBOT.arm, 0.002)
    yield made
    made.close()


@pytest.fixture(scope="module")
def cell():
    made = Cell(ScriptedPlant(panel(), design=DESIGN))
    yield made
    made.close()


def touch(check, start, end, obstacles=BLOCK, **changes):
    line = Line(start, end, 0.1, MOTION)
    return check.first_touch(
        line.between, line.distance, obstacles=[obstacles], finger_gap=OPEN_M, **changes
    )


def at(x, y, z, yaw=0.0):
    return ToolPose(x, y, z, yaw)


def test_a_path_over_a_block_is_free_down_to_the_clearance(check):
    for above, free in ((0.0025, True), (0.0015, False)):
        # The stem and pads of an open finger pass over the block, closing along y.
        z = 0.05 + above + ROBOT.arm.fingers.below
        found = touch(check, at(0.40, OPEN_M / 2, z), at(0.60, OPEN_M / 2, z))
        assert (found is None) is free
        if found is not None:
            assert (found.part, found.solid) == ("a finger", "the block")
            assert above - 1e-4 < found.gap < 0.002
            assert 0.48 < found.tool.x < 0.52


@pytest.mark.parametrize("yaw", [0.0, math.pi / 2])
def test_only_fingers_that_would_touch_are_refused(check, yaw):
    # Open fingers stand astride a block that is narrower than their opening less the clearance.
    narrow = replace(BLOCK.solids[0].box, size=(0.015, 0.015, 0.05))
    obstacles = Obstacles((Solid("the block", narrow),))
    turned = [at(0.5, 0.0, z, yaw) for z in (0.12, 0.03)]
    assert touch(check, *turned, obstacles=obstacles) is None
    assert touch(check, *turned, obstacles=BLOCK).part == "a finger"


def test_nothing_thin_is_missed_on_a_long_path(check):
    wall = Obstacles((Solid("a wall", Box((0.5, 0.0, 0.03), (0.002, 0.3, 0.06), (1, 1, 1))),))
    found = touch(check, at(0.30, 0.05, 0.04), at(0.70, -0.05, 0.04), wall)
    assert found.solid == "a wall" and found.tool.x < 0.5


def test_the_held_end_of_a_wire_counts(check):
    held = HeldTip("W1", radius=0.0015, distance=0.045, height=0.0, flip=0.0)
    start, end = at(0.38, 0.0, 0.03), at(0.45, 0.0, 0.03)
    assert touch(check, start, end) is None
    found = touch(check, start, end, held=held)
    assert found.part == "the held end of 'W1'"
    assert found.tool.x == pytest.approx(0.49 - 0.045 - 0.002, abs=0.005)
    assert touch(check, start, end, held=replace(held, flip=math.pi)) is None


def test_what_is_near_at_the_beginning_may_be_left_but_not_pressed(check):
    near = at(0.5, OPEN_M / 2, 0.05 + 0.001 + ROBOT.arm.fingers.below)
    assert touch(check, near, near.at(z=0.10)) is None
    assert touch(check, near, near.at(z=0.04)).solid == "the block"


def test_wires_may_be_touched_only_where_a_motion_begins_and_ends(check):
    block = BLOCK.solids[0]
    wires = Obstacles((replace(block, name=WIRES),))
    past = [at(0.38, 0.0, 0.03), at(0.62, 0.0, 0.03)]
    found = touch(check, *past, wires)
    assert found.solid == WIRES and 0.4 < found.tool.x < 0.5
    among = at(0.5, OPEN_M / 2, 0.05)
    # The hand comes down to them, and leaves them.
    assert touch(check, among.at(z=0.12), among, wires) is None
    assert touch(check, among, among.at(z=0.12), wires) is None
    assert touch(check, among.at(z=0.12), among).solid == "the block"
    # A hand that leads a wire along a duct lies among others all the way.
    assert touch(check, *past, wires, allowed={WIRES}) is None


def test_what_is_allowed_hides_nothing_else(check):
    name = BLOCK.solids[0].name
    other = replace(BLOCK.solids[0], name="another")
    at_it = [at(0.38, 0.0, 0.03), at(0.62, 0.0, 0.03)]
    assert touch(check, *at_it, allowed={name}) is None
    assert touch(check, *at_it, Obstacles((other,)), allowed={name}).solid == "another"


def test_every_terminal_of_the_household_panel_is_approached_without_touching_anything(check):
    household = example("household")
    obstacles = panel_obstacles(household, {})
    ends = [(wire, wire.goes_to(end)) for wire in household.wires for end in WireEnd]
    for (wire, terminal), flip in product(ends, (0.0, math.pi)):
        socket = BOARD @ household.panel_from_socket(*terminal)
        grip = Grip(WireEnd.A, distance=GRASP_M, height=0.0, flip=flip, tool=ROBOT.home)
        before = tool_before(socket, grip, -STANDOFF_M)
        held = HeldTip(wire.id, wire.radius, GRASP_M, height=0.0, flip=flip)
        line = Line(before.at(z=0.15), before, 0.1, MOTION)
        found = check.first_touch(
            line.between,
            line.distance,
            obstacles=[obstacles],
            finger_gap=wire.diameter,
            held=held,
        )
        assert found is None, (wire.id, terminal, str(found))


def beside_x2(side):
    """Return a tool pose low beside component X2: -1 in the channel, +1 beyond its row."""
    return at(0.58 + side * 0.055, 0.12, 0.03)


def travel(cell, target, **changes):
    """Move and return the heights of the tool on the way."""
    heights, context = [], cell.context

    def steps():
        for _ in move_to(context, target, MOTION.free_speed_m_s, **changes):
            heights.append(context.commanded.z)
            yield

    cell.run(steps())
    return heights


def test_a_pose_inside_a_component_is_refused_before_anything_moves(cell):
    before = cell.context.commanded
    with refused(Code.UNREACHABLE, r"a finger would .* mm .*component 'X2'") as caught:
        travel(cell, at(0.58, 0.12, 0.03))
    assert "nor one over it, is free" in str(caught.value)
    assert cell.context.commanded == before


def test_a_blocked_straight_line_is_refused_though_a_way_over_it_is_free(cell):
    travel(cell, beside_x2(-1).at(z=0.12))
    travel(cell, beside_x2(-1))
    with refused(Code.UNREACHABLE, r"no straight path to .* is free") as caught:
        straight_line(cell.context, beside_x2(1), MOTION.free_speed_m_s)
    assert "nor one over it" not in str(caught.value), "none was searched for"


def test_a_planned_contact_is_allowed_by_name(cell):
    context = cell.context
    line = Line(beside_x2(-1), at(0.58, 0.12, 0.03), 0.1, MOTION)
    assert context.scene.first_touch(line.between, line.distance, frozenset()).solid == X2
    assert context.scene.first_touch(line.between, line.distance, frozenset([X2])) is None


def test_the_held_end_is_taken_from_the_belief(cell):
    context, belief = cell.context, cell.context.belief
    belief.feed = Feed("W1", "A", 1)
    line = Line(at(0.48, 0.12, 0.03), at(0.53, 0.12, 0.03), 0.1, MOTION)
    assert context.scene.first_touch(line.between, line.distance, frozenset()) is None
    belief.grip = Grip(WireEnd.A, distance=0.045, height=0.0, flip=0.0, tool=line.start)
    found = context.scene.first_touch(line.between, line.distance, frozenset())
    assert found.part == "the held end of 'W1'"
    belief.grip, belief.feed = None, None


def test_a_cell_without_a_clearance_checks_nothing():
    made = Cell(ScriptedPlant(panel()))
    inside = Line(at(0.5, 0.12, 0.10), at(0.58, 0.12, 0.03), 0.1, MOTION)
    assert made.context.scene.first_touch(inside.between, inside.distance, frozenset()) is None
    made.close()
