"""LayWire in the cell of two heads, on the board of a household."""

import itertools
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from panels import example
from place_wire import do, extract, fix, insert, locate
from stored import put_held, shape_of

from remodel_sim.physics import truth
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.wires.parked_wire import draw_parked
from remodel_skills.abilities.extracting import DiscardGoal, discard_cable
from remodel_skills.abilities.inserting import FixGoal, InsertGoal, fix_cable, insert_cable
from remodel_skills.abilities.lay_wire import LayGoal, lay_wire
from remodel_skills.abilities.picking import (
    DetectGoal,
    PickGoal,
    PlaceGoal,
    detect_cable,
    pick_cable,
    place_cable,
)
from remodel_skills.cell import Cell
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.primitives import in_ducts
from remodel_skills.primitives.in_ducts import tuck_in
from remodel_skills.primitives.observation.checks import check_ducts, inspect_ducts
from remodel_skills.primitives.picking_up import take_up
from remodel_states.core.codes import Code
from remodel_work.component_shape import Box
from remodel_work.edge.bullet import add_static
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import BOARD, WireEnd
from remodel_work.routes import ParkedWire

PARAMETERS = read_parameters().parameters
MOTION = PARAMETERS.motion
GUIDE, HOLDER, WIRE = "robot_1", "robot_2", "W3"
DESIGN = read_cell("two_arms_cabinet")
# A wire over one other lies below the rims at so much of its route or more.
LEAST_BELOW = 0.9
# Tucked in, a wire lies below the rims at so much more of its route.
TUCKED = 0.3
# So far beside an opening, along the row, a tip meets the terminal's face.
BESIDE_M = 0.004
# Wires of the same diameter, of the same colour and of another one.
ALIKE, UNLIKE = "W15", "W7"
# On each leg of a route.
NODES = 40
# It is 0.67 m long; between hands that are farther apart than this share of it, it would be taut.
SHORT, STRAIGHT = "W96", 0.95
# An eyelet that opens so far aside, so much higher, leaves the wire in the notch of a finger; one
# that is out of it is so far from the hand above the rims [m].
INTO_NOTCH_M, LIFTED_M, SHED_M = 0.004, 0.015, 0.030
# A wire is still that moves no farther in so many steps [m].
STILL_M, STILL_STEPS = 0.001, 60
# Over the rims of the ducts; what hides a slot from above is so large [m].
OVER_RIM_M, COVER_M = 0.066, (0.09, 0.09, 0.001)
# No end of a wire is near here (3,) [m].
NOWHERE = (0.9, 0.9, 0.002)
# An empty hand feels no more than this across its weight [N].
LEVEL_N = 0.3


def cell_of(design=DESIGN):
    panel = example("household")
    return Cell(SimulatedPlant(panel, design=design, seed=1))


def hold_an_end(cell, wire_id=WIRE, end=WireEnd.B):
    """Feed a wire and hold an end; return where the other goes, by name and as it was located."""
    cell.feed(wire_id, "")
    do(cell, detect_cable, DetectGoal(wire_id))
    key = cell.plant.panel.wire(wire_id).goes_to(end.other)
    socket = locate(cell, *key)
    pick = PickGoal(HOLDER, wire_id, end, 0.0)
    cell.run(pick_cable(cell.contexts[HOLDER], pick), HOLDER)
    return key, socket


def lay(cell):
    goal = LayGoal(HOLDER, GUIDE, WIRE)
    steps = lay_wire(cell.contexts[HOLDER], cell.contexts[GUIDE], goal)
    return cell.run(steps, HOLDER, GUIDE)


def lay_from_b(cell):
    """Fix end b, and lay the wire: one hand keeps it in its duct, the other holds end a."""
    key, socket = hold_an_end(cell, end=WireEnd.A)
    insert(cell, WIRE, WireEnd.B, *key, socket)
    fix(cell, WIRE, *key, pull=5.0)
    lay(cell)


def route_of(cell, wire_id=WIRE):
    points = [BOARD.apply(np.array(at)) for at in cell.plant.panel.wire(wire_id).route]
    return np.array(points)


def along(route, height):
    """Return a wire's nodes (n, 3) [m] along a route, all at one height [m]."""
    flat = np.column_stack([route[:, :2], np.full(len(route), height)])
    legs = [np.linspace(a, b, NODES, endpoint=False) for a, b in itertools.pairwise(flat)]
    return np.concatenate([*legs, flat[-1:]])


def before(cell):
    """Return a picture of the board as it is."""
    (picture,) = cell.context.cameras.take_overhead_pictures()
    assert picture.depth is not None
    return picture


def draw(cell, nodes):
    """Show a wire that touches nothing, its nodes (n, 3) [m], beside the live one."""
    draw_parked(cell.plant.world, nodes, cell.plant.panel.wire(UNLIKE))


def check(cell):
    """Return at which share of its route the live wire lies in its ducts, from above."""

    def checked():
        found = yield from inspect_ducts(cell.context)
        check_ducts(found, PARAMETERS.fixture)
        return found.share

    return cell.run(checked(), GUIDE)


@pytest.mark.slow
@pytest.mark.physics
def test_two_hands_take_a_short_wire_and_insert_its_first_end():
    cell = cell_of()
    key, socket = hold_an_end(cell, SHORT)
    insert(cell, SHORT, WireEnd.A, *key, socket, force=14.0)
    (found,) = truth.ground_truth(cell.plant, [SHORT])
    assert found.a.seated
    grips = [cell.contexts[robot].belief.grip for robot in (GUIDE, HOLDER)]
    tools = [cell.contexts[robot].device.arm.tool.position for robot in (GUIDE, HOLDER)]
    free = cell.plant.panel.wire(SHORT).length - sum(grip.distance for grip in grips)
    assert np.linalg.norm(tools[0] - tools[1]) < STRAIGHT * free
    cell.close()


def from_the_wire(cell, robot):
    """Return how far a hand is from the live wire [m]."""
    tool = cell.contexts[robot].device.arm.tool
    return np.linalg.norm(cell.plant.live.cable.nodes() - tool.position, axis=1).min()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_is_led_into_its_ducts_over_one_that_lies_there():
    cell = cell_of()
    there = along(route_of(cell, ALIKE), 0.020)
    cell.plant.parked[ALIKE] = ParkedWire(there, frozenset(WireEnd))
    key, socket = hold_an_end(cell, end=WireEnd.A)
    guide, holder = cell.contexts[GUIDE], cell.contexts[HOLDER]
    second = cell.plant.panel.wire(WIRE).goes_to(WireEnd.A)
    at_second = locate(cell, *second)
    insert(cell, WIRE, WireEnd.B, *key, socket)
    fix(cell, WIRE, *key, pull=5.0)
    empty = cell.contexts[GUIDE].empty_force
    assert np.linalg.norm(empty[:2]) < LEVEL_N, "what the wire pulls with is not the hand's own"
    lay(cell)
    _, slot, corner, *_ = route_of(cell)
    onward = (slot - corner)[:2] / np.linalg.norm(slot - corner)
    at = guide.commanded
    kept = at.position[:2] - corner[:2]
    assert np.linalg.norm(kept - PARAMETERS.fixture.duct_corner_m * onward) < 1e-3
    assert guide.device.gripper.gap < PARAMETERS.tool.open_m / 2, (
        "its eyelet is closed around the wire there"
    )
    grip = holder.belief.grip
    assert grip is not None, "the holder keeps the free end"
    tip_yaw = holder.commanded.yaw + grip.flip
    away = holder.commanded.position - slot
    assert away[:2] @ [np.cos(tip_yaw), np.sin(tip_yaw)] > 0, "its tip points away from the duct"
    (found,) = truth.ground_truth(cell.plant, [WIRE])
    assert found.b.seated and found.b.fixed
    assert truth.share_in_ducts(cell.plant, WIRE) >= LEAST_BELOW
    push = InsertGoal(HOLDER, WIRE, WireEnd.A, *second, at_second, 14.0)
    cell.run(insert_cable(holder, push), HOLDER)
    assert truth.share_in_ducts(cell.plant, WIRE) >= LEAST_BELOW
    assert guide.commanded == at.at(z=MOTION.travel_z_m)
    assert from_the_wire(cell, GUIDE) > SHED_M
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_that_is_kept_in_its_duct_is_let_go_before_it_is_discarded():
    cell = cell_of()
    lay_from_b(cell)
    steps = discard_cable(cell.contexts[HOLDER], DiscardGoal(HOLDER, WIRE))
    cell.run(steps, HOLDER)
    assert cell.contexts[GUIDE].device.gripper.gap > PARAMETERS.tool.open_m
    assert cell.plant.live is None
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_that_lies_in_the_notch_of_an_open_finger_is_shed():
    cell = cell_of()
    lay_from_b(cell)
    guide = cell.contexts[GUIDE]
    here = guide.commanded
    across = np.array([-math.sin(here.yaw), math.cos(here.yaw), 0.0])
    beside = here.moved(across, INTO_NOTCH_M).at(z=here.z + LIFTED_M)
    cell.run(
        in_ducts.move_to(guide, beside, MOTION.leave_speed_m_s, in_ducts.in_ducts(guide)),
        GUIDE,
    )
    cell.run(in_ducts.let_go(guide), GUIDE)
    assert guide.commanded == beside.at(z=MOTION.travel_z_m)
    assert from_the_wire(cell, GUIDE) > SHED_M
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_that_left_its_ducts_when_its_second_end_was_inserted_is_discarded():
    cell = cell_of()
    holder = cell.contexts[HOLDER]
    key, socket = hold_an_end(cell)
    second = cell.plant.panel.wire(WIRE).goes_to(WireEnd.B)
    at_second = locate(cell, *second)
    insert(cell, WIRE, WireEnd.A, *key, socket, force=14.0)
    fix(cell, WIRE, *key, pull=5.0)
    lay(cell)
    push = InsertGoal(HOLDER, WIRE, WireEnd.B, *second, at_second, 14.0)
    cell.run(insert_cable(holder, push), HOLDER)
    close = FixGoal(HOLDER, WIRE, *second, 5.0)
    fixed = cell.run(fix_cable(holder, close), HOLDER)
    share = truth.share_in_ducts(cell.plant, WIRE)
    (reported,) = re.findall(r"it lies in its ducts at (\d+)% of its route", fixed.message)
    assert int(reported) / 100 == pytest.approx(share, abs=0.1)
    assert check(cell) == pytest.approx(share, abs=0.1)
    # As if it had been lifted out.
    draw(cell, along(route_of(cell), OVER_RIM_M))
    with pytest.raises(AbilityError, match="lies outside its ducts along") as caught:
        check(cell)
    assert caught.value.code is Code.OUT_OF_DUCT
    assert caught.value.found["in_ducts"] == pytest.approx(0.0, abs=0.2)
    do(cell, discard_cable, DiscardGoal(GUIDE, WIRE))
    assert WIRE not in cell.context.belief.fed
    assert cell.plant.live is None
    cell.close()


def arched(cell):
    """Let SHORT stand over the rims from corner to corner, as after its second insertion."""
    holder = cell.contexts[HOLDER]
    picture = before(cell)
    cell.plant.parked[SHORT] = shape_of(cell, SHORT, *WireEnd)
    take_up(holder, SHORT)
    moved = math.inf
    while moved > STILL_M:
        nodes = cell.plant.live.cable.nodes()
        for _ in range(STILL_STEPS):
            cell.plant.step()
        moved = np.abs(cell.plant.live.cable.nodes() - nodes).max()
    holder.belief.untouched[:] = [picture]
    return holder


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_that_arches_over_its_last_corner_is_tucked_in():
    cell = cell_of()
    holder = arched(cell)
    was = truth.share_in_ducts(cell.plant, SHORT)
    assert was < PARAMETERS.fixture.duct_least_share
    found = cell.run(tuck_in(holder), HOLDER)
    share = truth.share_in_ducts(cell.plant, SHORT)
    assert share >= was + TUCKED, "the physics"
    assert found.share == pytest.approx(share, abs=0.15), "the picture from above"
    assert from_the_wire(cell, HOLDER) > SHED_M
    assert holder.device.gripper.gap > PARAMETERS.tool.open_m
    assert holder.commanded.z >= MOTION.travel_z_m
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_that_missed_its_terminal_leaves_the_cell_from_hand_to_hand():
    cell = cell_of()
    key, socket = hold_an_end(cell)
    holder = cell.contexts[HOLDER]
    beside = replace(socket, position=socket.position + np.array([0.0, BESIDE_M, 0.0]))
    with pytest.raises(AbilityError) as caught:
        insert(cell, WIRE, WireEnd.A, *key, beside)
    assert caught.value.code is Code.INSERTION_MISALIGNED
    let_down = do(cell, place_cable, PlaceGoal(GUIDE, WIRE, socket))
    assert "laid down" in let_down.message, "the other hand has the wire"
    guide = cell.contexts[GUIDE]
    guide.begin()  # its hand stays in the picture
    dropped = cell.run(place_cable(holder, PlaceGoal(HOLDER, WIRE, socket)), HOLDER)
    assert "dropped into the scrap bin" in dropped.message
    assert cell.context.belief.fed == []
    assert cell.plant.live is None
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_that_hangs_from_its_first_terminal_is_discarded():
    # Behind its slot it bends aside, and pulls at the hand that draws its end out.
    bent, end = "W97", WireEnd.B
    cell = cell_of()
    key, socket = hold_an_end(cell, bent, end.other)
    insert(cell, bent, end, *key, socket, force=14.0)
    fix(cell, bent, *key, pull=5.0)
    cell.run(place_cable(cell.contexts[HOLDER], PlaceGoal(HOLDER, bent, socket)), HOLDER)
    discarded = do(cell, discard_cable, DiscardGoal(GUIDE, bent))
    assert "dropped into the scrap bin" in discarded.message
    assert cell.plant.live is None and bent not in cell.context.belief.fed
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_whose_ends_are_seen_nowhere_is_picked_up_between_them():
    cell = cell_of()
    key, socket = hold_an_end(cell)
    insert(cell, WIRE, WireEnd.A, *key, socket, force=14.0)
    let_down = PlaceGoal(HOLDER, WIRE, socket)
    cell.run(place_cable(cell.contexts[HOLDER], let_down), HOLDER)
    extract(cell, WIRE, *key, socket)
    belief = cell.context.belief
    # As if both had sprung away.
    for end in WireEnd:
        belief.expected[end] = np.array(NOWHERE)
    discard = DiscardGoal(GUIDE, WIRE)
    kept = belief.untouched.pop()
    with pytest.raises(AbilityError) as caught:
        do(cell, discard_cable, discard)
    assert caught.value.code is Code.TIP_NOT_FOUND, "nothing shows what is new"
    assert not belief.hands and WIRE in belief.fed
    belief.untouched.append(kept)
    discarded = do(cell, discard_cable, discard)
    assert "dropped into the scrap bin" in discarded.message
    assert cell.plant.live is None and WIRE not in belief.fed
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_the_pull_on_a_clamped_end_keeps_to_its_limit(pushes):
    cell = cell_of()
    key, socket = hold_an_end(cell, "W22", WireEnd.A)
    insert(cell, "W22", WireEnd.B, *key, socket, force=14.0)
    fix(cell, "W22", *key, pull=5.0)
    assert pushes[-1].limit == 5.0
    assert 5.0 <= pushes[-1].peak <= pushes[-1].allowed
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_is_led_into_its_ducts():
    cell = cell_of()
    assert put_held(cell, WIRE) == HOLDER
    laid = lay(cell)
    assert "laid into D0, L, D1" in laid.message
    assert truth.share_in_ducts(cell.plant, WIRE) >= PARAMETERS.fixture.duct_least_share
    (found,) = truth.ground_truth(cell.plant, [WIRE])
    assert found.a.seated and found.a.fixed, "it was not torn out"
    assert cell.contexts[HOLDER].belief.grip is not None, "the holder keeps the free end"
    assert from_the_wire(cell, GUIDE) > SHED_M
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_that_others_hide_at_its_slot_is_taken_and_laid():
    cell = cell_of()
    cell.feed(WIRE, "")
    cover = Box((0.0, 0.0, OVER_RIM_M), COVER_M, (0.5, 0.5, 0.5), solid=False)
    x, y, _ = (float(v) for v in route_of(cell)[1])
    add_static(cell.plant.world.bullet, [cover], Pose.level(x, y, 0.0))
    key, socket = hold_an_end(cell)
    insert(cell, WIRE, WireEnd.A, *key, socket)
    fix(cell, WIRE, *key, pull=5.0)
    lay(cell)
    assert truth.share_in_ducts(cell.plant, WIRE) >= PARAMETERS.fixture.duct_least_share
    cell.close()
