"""LayWire in the cell of two heads, on the board of a household."""

import inspect
import itertools
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from panels import example
from place_wire import do, extract, fix, insert, locate
from stored import shape_of

from remodel_sim.physics import truth
from remodel_sim.physics.device import SimulatedGripper
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.wires.parked_wire import draw_parked
from remodel_skills import goals
from remodel_skills.abilities import lay_wire as lay_wire_module
from remodel_skills.abilities.detect_cable import detect_cable
from remodel_skills.abilities.discard_cable import discard_cable
from remodel_skills.abilities.fix_cable import fix_cable
from remodel_skills.abilities.insert_cable import insert_cable
from remodel_skills.abilities.lay_wire import _check_closed, _take, draw_straight, lay_wire
from remodel_skills.abilities.pick_cable import pick_cable
from remodel_skills.abilities.place_cable import place_cable
from remodel_skills.cell import Cell
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.primitives.ducts import leading, tucking
from remodel_skills.primitives.ducts.tucking import tuck_in
from remodel_skills.primitives.observation.duct_check import check_ducts, inspect_ducts
from remodel_skills.primitives.taking_up import take_up
from remodel_skills.robot_context import RobotContext
from remodel_states.core.codes import Code
from remodel_states.fix_cable_state import FixCableState
from remodel_vision.board.graspable import graspable_places
from remodel_vision.laid_wire import uppermost_past, wire_past
from remodel_vision.opening_occupancy import is_seen_empty
from remodel_vision.wire_lines import WireLines
from remodel_work.edge.cell_file import read_cell
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.openings import opening_of
from remodel_work.panel import BOARD, WireEnd
from remodel_work.placed_wires import ParkedWire
from remodel_work.robot.arm import ToolPose

PARAMETERS = read_parameters().parameters
MOTION, SEARCH_M = PARAMETERS.motion, PARAMETERS.looking.slot_search_m

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
# On each leg of a route; and so much of a wire lies under another one.
NODES = 40
HIDDEN = 0.7
# It is 0.67 m long; between hands that are farther apart than this share of it, it would be taut.
SHORT, STRAIGHT = "W96", 0.95
# Farther aside than wires that lie beside each other; a hand that stopped early is so far above
# where it would have gone [m].
FAR_ASIDE_M, WELL_ABOVE_M = 0.016, 0.016
# A wire pulls at the leading hand with more than this where it is led along a duct [N]; the hand is
# higher than this where it has lifted the wire over the rims [m].
PULLS_N, LIFTED_Z = 1.5, 0.045
# Two hands lift it by so much: the leading one alone would come too near to the other one [m].
LIFT_M = 0.020
# An eyelet that opens so far aside, so much higher, leaves the wire in the notch of a finger; one
# that is out of it is so far from the hand above the rims [m].
INTO_NOTCH_M, LIFTED_M, SHED_M = 0.004, 0.015, 0.030
# So many wires beside each other fill a duct's floor.
BUNDLE = 7
# A line over the devices of WIRE's row, from its first duct to its last one [m].
ACROSS = ((0.66, 0.26, 0.0), (0.57, 0.08, 0.0))
# A wire that sprang out of its ducts loops over the devices from terminal to terminal [m].
LOOP_ACROSS = ((0.62, -0.10, 0.12), (0.59, -0.10, 0.12))
# A wire is so far on from where the open hand would be around it.
ASLANT_M = 0.016
# A wire is still that moves no farther in so many steps [m].
STILL_M, STILL_STEPS = 0.001, 60
# Over the rims of the ducts, and so far aside along both axes over an outer wall [m].
OVER_RIM_M = 0.066
OVER_WALL_M = 0.028
# Nodes along 0.04 of the 0.69 m of a route in ducts; curled so far to each side of its leg [m], the
# wire is 0.23 m long there.
CURL, CURL_M = slice(5 * NODES // 2, 5 * NODES // 2 + 8), 0.016
# A curl of it comes back beside the middle of its second duct, so far from that one's middle [m].
COMES_BACK, BESIDE_DUCT_M = slice(9 * NODES // 4, 11 * NODES // 4), 0.035
# Of FixCable's time the clamp, the pull test and farther ways to the wire may take so much [s].
FIX_S = 20.0
# No end of a wire is near here (3,) [m]. A place on a wire is so near to one of its nodes [m], and
# is turned from it by no more than this [sine]; the depth camera errs by less than this [m].
NOWHERE = (0.9, 0.9, 0.002)
NEAR_NODE_M, ALONG, SEEN_HEIGHT_M = 0.010, 0.05, 0.002
# An empty hand feels no more than this across its weight [N].
LEVEL_N = 0.3


def cell_of(design=DESIGN):
    panel = example("household")
    return Cell(SimulatedPlant(panel, design=design, seed=1))


def changed(**groups):
    """Return the parameters with some numbers changed, by group."""
    return replace(
        PARAMETERS,
        **{group: replace(getattr(PARAMETERS, group), **new) for group, new in groups.items()},
    )


def hold_an_end(cell, wire_id=WIRE, end=WireEnd.B):
    """Feed a wire and hold an end; return where the other goes, by name and as it was located."""
    cell.feed(wire_id, "")
    do(cell, detect_cable, goals.DetectGoal(wire_id))
    key = cell.plant.panel.wire(wire_id).goes_to(end.other)
    socket = locate(cell, *key)
    pick = goals.PickGoal(HOLDER, wire_id, end, 0.0)
    cell.run(pick_cable(cell.contexts[HOLDER], pick), HOLDER)
    return key, socket


def lay(cell):
    goal = goals.LayGoal(HOLDER, GUIDE, WIRE)
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
    picture = cell.context.cameras.take_overhead_picture()
    assert picture.depth is not None
    return picture


def draw(cell, nodes):
    """Show a wire that touches nothing, its nodes (n, 3) [m], beside the live one."""
    draw_parked(cell.plant.world, nodes, cell.plant.panel.wire(UNLIKE))


def check(cell):
    """Return at which share of its route the live wire lies in its ducts, from above."""

    def checked():
        found = yield from inspect_ducts(cell.context)
        check_ducts(found, PARAMETERS.fixture.duct_least_share)
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


def note_leaving(monkeypatch):
    """Return a list that gets the targets of a hand that leaves a wire in its duct."""
    move_to, targets = leading.move_to, []

    def noted(context, target, *how):
        targets.append(target)
        return move_to(context, target, *how)

    monkeypatch.setattr(leading, "move_to", noted)
    return targets


def sheds(targets):
    """Return whether a hand at last rises, sheds the wire to both sides, and leaves."""
    to_sides = [side * by for by in PARAMETERS.fixture.duct_asides_m for side in (1, -1)]
    expected = [0.0, *to_sides, 0.0, 0.0]
    targets = targets[-len(expected) :]
    rises = targets[0]
    across = np.array([-math.sin(rises.yaw), math.cos(rises.yaw)])
    aside = [float((target.position - rises.position)[:2] @ across) for target in targets]
    return aside == pytest.approx(expected, abs=1e-6) and targets[-1].z > rises.z


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_is_led_into_its_ducts_over_one_that_lies_there(monkeypatch):
    cell = cell_of()
    targets = note_leaving(monkeypatch)
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
    targets.clear()
    push = goals.InsertGoal(HOLDER, WIRE, WireEnd.A, *second, at_second, 14.0)
    cell.run(insert_cable(holder, push), HOLDER)
    assert truth.share_in_ducts(cell.plant, WIRE) >= LEAST_BELOW
    assert guide.commanded == at.at(z=MOTION.travel_z_m)
    assert sheds(targets)
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_that_is_kept_in_its_duct_is_let_go_before_it_is_discarded():
    cell = cell_of()
    lay_from_b(cell)
    steps = discard_cable(cell.contexts[HOLDER], goals.DiscardGoal(HOLDER, WIRE))
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
        leading.move_to(guide, beside, MOTION.leave_speed_m_s, leading.in_ducts(guide)),
        GUIDE,
    )
    cell.run(leading.let_go(guide), GUIDE)
    assert guide.commanded == beside.at(z=MOTION.travel_z_m)
    away = np.linalg.norm(cell.plant.live.cable.nodes() - guide.device.arm.tool.position, axis=1)
    assert away.min() > SHED_M
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
    push = goals.InsertGoal(HOLDER, WIRE, WireEnd.B, *second, at_second, 14.0)
    cell.run(insert_cable(holder, push), HOLDER)
    close = goals.FixGoal(HOLDER, WIRE, *second, 5.0)
    fixed = cell.run(fix_cable(holder, close), HOLDER)
    share = truth.share_in_ducts(cell.plant, WIRE)
    (reported,) = re.findall(r"it lies in its ducts at (\d+)% of its route", fixed.message)
    assert int(reported) / 100 == pytest.approx(share, abs=0.1)
    assert check(cell) == pytest.approx(share, abs=0.1)
    # As if it had been lifted out.
    draw(cell, along(route_of(cell), OVER_RIM_M))
    with pytest.raises(AbilityError, match="allowed: 80% or more; draw it out") as caught:
        check(cell)
    assert caught.value.code is Code.OUT_OF_DUCT
    assert caught.value.found["in_ducts"] == pytest.approx(0.0, abs=0.2)
    do(cell, discard_cable, goals.DiscardGoal(GUIDE, WIRE))
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
def test_a_wire_that_arches_over_its_last_corner_is_tucked_in(monkeypatch):
    cell = cell_of()
    holder, targets = arched(cell), note_leaving(monkeypatch)
    was = truth.share_in_ducts(cell.plant, SHORT)
    assert was < PARAMETERS.fixture.duct_least_share
    found = cell.run(tuck_in(holder), HOLDER)
    share = truth.share_in_ducts(cell.plant, SHORT)
    assert share >= was + TUCKED, "the physics"
    assert found.share == pytest.approx(share, abs=0.15), "the picture from above"
    assert sheds(targets)
    assert holder.device.gripper.gap > PARAMETERS.tool.open_m
    assert holder.commanded.z >= MOTION.travel_z_m
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_that_would_be_refused_is_tucked_into_duct_after_duct_and_fixed_in_time(monkeypatch):
    cell = cell_of()
    holder = arched(cell)
    found = cell.run(inspect_ducts(holder), HOLDER)
    at = next(tucking._standing(holder, found))
    stood = [replace(at, duct=duct) for duct in found.places]
    assert len(stood) > 1
    tuck, tucked = tucking._tuck, []

    def noted(context, standing):
        tucked.append(standing.duct.id)
        return tuck(context, standing)

    monkeypatch.setattr(tucking, "_standing", lambda *_: iter(stood))
    monkeypatch.setattr(tucking, "_tuck", noted)
    holder.parameters = changed(fixture={"duct_least_share": 1.1})
    monkeypatch.setattr(tucking, "grips_nothing", lambda *_: False)
    world = cell.plant.world
    began = world.steps
    cell.run(tuck_in(holder), HOLDER)
    allowed = inspect.signature(FixCableState).parameters["timeout_s"].default
    assert (world.steps - began) * world.time_step < allowed - FIX_S
    assert len(tucked) == MOTION.tucks_of_refused
    assert all(one != other for one, other in itertools.pairwise(tucked))
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_fingers_go_below_the_rim_only_where_both_are_beside_the_duct(monkeypatch):
    cell = cell_of()
    holder = arched(cell)
    duct = next(duct for duct in cell.plant.panel.ducts if duct.id == "L")
    place = BOARD @ duct.panel_from_duct @ Pose.level(0.0, 0.0, duct.height)
    closed_at = []
    monkeypatch.setattr(
        RobotContext, "close_fingers", lambda context, _: closed_at.append(context.commanded.z)
    )
    low, over_rim = (
        duct.height + PARAMETERS.fixture.tuck_graspable_m,
        duct.height + PARAMETERS.fixture.tuck_over_rim_m + holder.fingers.below,
    )
    for aside in (0.043, 0.030, -0.016):
        standing = tucking.Standing(duct, place, tucking.Passing(aside, low), 0.0)
        cell.run(tucking._tuck(holder, standing), HOLDER)
    assert closed_at == pytest.approx([low, over_rim, over_rim])
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_only_the_openings_of_a_wire_are_not_seen_empty():
    cell = cell_of()
    arched(cell)
    picture, panel = before(cell), cell.plant.panel
    wire = panel.wire(SHORT)
    keys = [(part.id, terminal.id) for part in panel.components for terminal in part.terminals]
    taken = {key for key in keys if not is_seen_empty(picture, opening_of(key, panel, {}), wire)}
    assert taken == {wire.goes_to(end) for end in WireEnd}
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_that_resists_is_brought_down_no_farther(monkeypatch):
    cell = cell_of()
    holder = arched(cell)
    holder.parameters = changed(wire={"tuck_most_n": 1.0}, motion={"tucks_of_refused": 1})
    open_fingers, opened_at = leading.open_fingers, []

    def noted(context, opening):
        opened_at.append(context.device.arm.tool.z)
        return open_fingers(context, opening)

    monkeypatch.setattr(leading, "open_fingers", noted)
    cell.run(tuck_in(holder), HOLDER)
    (height,) = opened_at
    assert height > PARAMETERS.fixture.tuck_down_m + WELL_ABOVE_M
    assert holder.device.gripper.gap > PARAMETERS.tool.open_m
    assert holder.commanded.z >= MOTION.travel_z_m
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_fingers_that_close_beside_a_wire_press_nothing_down(monkeypatch):
    cell = cell_of()
    holder = arched(cell)
    standing = tucking._standing

    def beside(context, found):
        for at in standing(context, found):
            aside = at.passing.aside + FAR_ASIDE_M
            yield replace(at, passing=replace(at.passing, aside=aside))

    monkeypatch.setattr(tucking, "_standing", beside)
    holder.parameters = changed(motion={"tucks_of_refused": 1})
    was = truth.share_in_ducts(cell.plant, SHORT)
    cell.run(tuck_in(holder), HOLDER)
    assert truth.share_in_ducts(cell.plant, SHORT) == pytest.approx(was, abs=0.1)
    assert holder.device.gripper.gap > PARAMETERS.tool.open_m
    assert holder.commanded.z >= MOTION.travel_z_m
    cell.close()


@pytest.mark.physics
@pytest.mark.parametrize(
    ("aside", "height", "is_out"),
    [(0.0, 0.030, False), (0.0, OVER_RIM_M, True), (OVER_WALL_M, OVER_RIM_M, True)],
)
def test_a_wire_over_the_rims_or_the_wall_is_out_of_its_ducts(aside, height, is_out):
    cell = cell_of()
    empty, route = before(cell), route_of(cell)
    lies = along(route, height) + np.array([aside, aside, 0.0])
    cell.plant.parked[ALIKE] = ParkedWire(lies, frozenset(WireEnd))
    cell.feed(WIRE, "")
    cell.context.belief.note_board(empty)
    if is_out:
        with pytest.raises(AbilityError) as caught:
            check(cell)
        assert caught.value.code is Code.OUT_OF_DUCT
    else:
        assert check(cell) == pytest.approx(1.0, abs=0.05)
    cell.close()


@pytest.mark.physics
def test_a_wire_that_curls_up_is_out_of_its_ducts_along_its_route_not_along_itself():
    cell = cell_of()
    empty, lies = before(cell), along(route_of(cell), 0.030)
    lies[CURL, 1] += CURL_M * np.resize([1.0, -1.0], len(lies[CURL]))
    lies[CURL, 2] = OVER_RIM_M
    cell.plant.parked[ALIKE] = ParkedWire(lies, frozenset(WireEnd))
    cell.feed(WIRE, "")
    cell.context.belief.note_board(empty)
    assert check(cell) == pytest.approx(1 - 0.04 / 0.69, abs=0.05)
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_that_curls_up_beside_its_duct_where_it_is_seen_in_it_lies_in_its_duct():
    cell = cell_of()
    empty, lies = before(cell), along(route_of(cell), 0.030)
    cell.plant.parked[ALIKE] = ParkedWire(lies, frozenset(WireEnd))
    cell.feed(WIRE, "")
    cell.context.belief.note_board(empty)
    draw(cell, lies[COMES_BACK] + [0.0, BESIDE_DUCT_M, LIFTED_Z])
    assert check(cell) == pytest.approx(1.0, abs=0.05)
    cell.close()


@pytest.mark.physics
def test_a_wire_that_lies_across_the_devices_is_not_in_its_ducts():
    cell = cell_of()
    empty, route = before(cell), route_of(cell)
    lies = [route[0], *np.array(LOOP_ACROSS), route[-1]]
    nodes = np.concatenate(
        [np.linspace(a, b, NODES, endpoint=False) for a, b in itertools.pairwise(lies)]
    )
    cell.plant.parked[ALIKE] = ParkedWire(nodes, frozenset(WireEnd))
    cell.feed(WIRE, "")
    cell.context.belief.note_board(empty)
    with pytest.raises(AbilityError, match="allowed: 80% or more") as caught:
        check(cell)
    assert caught.value.code is Code.OUT_OF_DUCT
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_that_pulls_too_hard_is_lifted_by_both_hands_and_led_on(monkeypatch):
    cell = cell_of()
    move_together, lifted = lay_wire_module.move_together, []

    def noted(targets, *how, **more):
        rises = {robot.name: tool.z - robot.commanded.z for robot, tool in targets}
        if set(more) == {"allowed"}:
            lifted.append(rises)
        return move_together(targets, *how, **more)

    monkeypatch.setattr(lay_wire_module, "move_together", noted)
    key, socket = hold_an_end(cell)
    insert(cell, WIRE, WireEnd.A, *key, socket)
    fix(cell, WIRE, *key, pull=5.0)
    allowed = lay_wire_module._max_pull(cell.contexts[GUIDE])
    monkeypatch.setattr(
        lay_wire_module,
        "_max_pull",
        lambda guide: allowed if guide.commanded.z > LIFTED_Z else PULLS_N,
    )
    laid = lay(cell)
    assert PULLS_N < laid.peak_force <= allowed
    assert lifted and all(
        rises == pytest.approx({GUIDE: LIFT_M, HOLDER: LIFT_M}, abs=0.001) for rises in lifted
    )
    assert truth.share_in_ducts(cell.plant, WIRE) >= 0.8
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_that_still_pulls_too_hard_is_given_up_with_what_it_pulled_with(monkeypatch):
    cell = cell_of()
    key, socket = hold_an_end(cell)
    insert(cell, WIRE, WireEnd.A, *key, socket)
    fix(cell, WIRE, *key, pull=5.0)
    monkeypatch.setattr(lay_wire_module, "_max_pull", lambda guide: PULLS_N)
    with pytest.raises(AbilityError, match="it hangs on something") as caught:
        lay(cell)
    assert caught.value.code is Code.SNAGGED
    assert caught.value.found["peak_force"] > PULLS_N
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
    let_down = do(cell, place_cable, goals.PlaceGoal(GUIDE, WIRE, socket))
    assert "laid down" in let_down.message, "the other hand has the wire"
    guide = cell.contexts[GUIDE]
    guide.begin()  # its hand stays in the picture
    dropped = cell.run(place_cable(holder, goals.PlaceGoal(HOLDER, WIRE, socket)), HOLDER)
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
    cell.run(place_cable(cell.contexts[HOLDER], goals.PlaceGoal(HOLDER, bent, socket)), HOLDER)
    discarded = do(cell, discard_cable, goals.DiscardGoal(GUIDE, bent))
    assert "dropped into the scrap bin" in discarded.message
    assert cell.plant.live is None and bent not in cell.context.belief.fed
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_wire_whose_ends_are_seen_nowhere_is_picked_up_between_them():
    cell = cell_of()
    key, socket = hold_an_end(cell)
    insert(cell, WIRE, WireEnd.A, *key, socket, force=14.0)
    let_down = goals.PlaceGoal(HOLDER, WIRE, socket)
    cell.run(place_cable(cell.contexts[HOLDER], let_down), HOLDER)
    extract(cell, WIRE, *key, socket)
    belief = cell.context.belief
    # As if both had sprung away.
    for end in WireEnd:
        belief.expected[end] = np.array(NOWHERE)
    discard = goals.DiscardGoal(GUIDE, WIRE)
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


@pytest.mark.physics
@pytest.mark.parametrize("leg", [1, 2])
def test_a_new_wire_is_graspable_where_it_is_highest(leg):
    cell = cell_of()
    empty, lies = before(cell), along(route_of(cell), 0.030)
    high = slice(leg * NODES + NODES // 4, leg * NODES + 3 * NODES // 4)
    lies[high, 2] = OVER_RIM_M
    cell.plant.parked[ALIKE] = ParkedWire(lies, frozenset(WireEnd))
    cell.feed(WIRE, "")
    radius = cell.plant.panel.wire(ALIKE).radius
    picture = before(cell)
    first, *others = graspable_places(picture, empty, radius)
    assert np.linalg.norm(lies[high] - first.position, axis=1).min() < NEAR_NODE_M
    assert first.position[2] == pytest.approx(OVER_RIM_M, abs=SEEN_HEIGHT_M)
    way = lies[high][-1] - lies[high][0]
    assert abs(math.sin(first.yaw - math.atan2(way[1], way[0]))) < ALONG
    assert all(place.position[2] < OVER_RIM_M + SEEN_HEIGHT_M for place in others)
    assert not list(graspable_places(picture, picture, radius)), "nothing is new"
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
def test_a_wire_that_does_not_become_straight_is_not_in_the_eyelet():
    cell = cell_of()
    hold_an_end(cell)
    holder = cell.contexts[HOLDER]
    # Its other end lies in the magazine: the wire hangs far lower than the hand.
    below = holder.commanded.position - np.array([0.0, 0.0, 0.1])
    height = holder.commanded.z
    with pytest.raises(AbilityError, match="is not in the eyelet") as caught:
        cell.run(draw_straight(holder, below, 1.0), HOLDER)
    assert caught.value.code is Code.GRASP_MISSED
    assert holder.commanded.z - height == pytest.approx(MOTION.tighten_m, abs=0.01)
    cell.close()


@pytest.mark.physics
def test_the_uppermost_of_two_wires_beside_each_other_is_taken():
    cell = cell_of()
    lower = along(route_of(cell), 0.030)
    upper = lower + np.array([BESIDE_M, 0.0, 0.008])
    cell.plant.parked[ALIKE] = ParkedWire(lower, frozenset())
    cell.plant.parked[UNLIKE] = ParkedWire(upper, frozenset())
    cell.feed(WIRE, "")
    picture = cell.context.cameras.take_overhead_picture()
    lower_seen, upper_seen = (
        WireLines(picture, cell.plant.panel.wire(name)) for name in (ALIKE, UNLIKE)
    )
    x, y, _ = route_of(cell)[1:3].mean(axis=0)
    place = Pose.level(float(x), float(y), 0.030, math.pi / 2)
    alone = wire_past(place, SEARCH_M, upper_seen)
    passing = uppermost_past(place, SEARCH_M, lower_seen)
    assert alone is not None and passing is not None
    assert passing.aside == pytest.approx(-BESIDE_M, abs=0.001)
    assert passing.height == pytest.approx(alone.height, abs=0.001)
    other = replace(cell.plant.panel.wire(ALIKE), colour="YE")
    assert wire_past(place, SEARCH_M, WireLines(picture, other)) is None
    by_depth = uppermost_past(place, SEARCH_M, WireLines(picture, other))
    assert by_depth is not None
    assert by_depth.height == pytest.approx(alone.height, abs=0.001)
    cell.close()


@pytest.mark.physics
def test_the_highest_of_several_wires_of_one_colour_is_taken_not_the_nearest():
    cell = cell_of()
    own = cell.plant.panel.wire(WIRE)
    alike = [
        wire.id
        for wire in cell.plant.panel.wires
        if (wire.colour, wire.diameter) == (own.colour, own.diameter) and wire is not own
    ]
    # Above the rims: the walls are lower.
    for name, aside, height in zip(alike, (0.004, -0.014), (0.070, 0.082), strict=False):
        line = along(route_of(cell), height) + np.array([aside, 0.0, 0.0])
        cell.plant.parked[name] = ParkedWire(line, frozenset())
    cell.feed(WIRE, "")
    seen = WireLines(cell.context.cameras.take_overhead_picture(), own)
    x, y, _ = route_of(cell)[1:3].mean(axis=0)
    place = Pose.level(float(x), float(y), 0.070, math.pi / 2)
    passing = uppermost_past(place, SEARCH_M, seen)
    assert passing is not None
    assert passing.height == pytest.approx(0.082, abs=0.005)
    assert passing.aside == pytest.approx(0.014, abs=0.003)
    cell.close()


def test_of_two_wires_of_one_colour_the_one_that_is_new_is_taken_below_the_other():
    cell = cell_of()
    own = cell.plant.panel.wire(WIRE)
    x, y, _ = route_of(cell)[1:3].mean(axis=0)
    place = Pose.level(float(x), float(y), 0.070, math.pi / 2)
    stood, new = (
        along(route_of(cell), height) + np.array([aside, 0.0, 0.0])
        for aside, height in ((-0.014, 0.082), (0.004, 0.070))
    )
    cell.plant.load(cell.plant.loaded, {ALIKE: ParkedWire(stood, frozenset())})
    picture = before(cell)
    cell.plant.load(
        cell.plant.loaded,
        {ALIKE: ParkedWire(stood, frozenset()), WIRE: ParkedWire(new, frozenset())},
    )
    before(cell)  # the noise of the next picture is another one
    seen = WireLines(before(cell), own)
    highest = uppermost_past(place, SEARCH_M, seen)
    passing = uppermost_past(place, SEARCH_M, seen, picture)
    assert highest is not None and passing is not None
    assert highest.aside == pytest.approx(0.014, abs=0.003)
    assert passing.aside == pytest.approx(-0.004, abs=0.003)
    assert passing.height == pytest.approx(0.070, abs=0.003)
    cell.close()


def test_an_older_wire_that_hides_the_new_one_is_not_taken_for_it():
    cell = cell_of()
    seen_from = cell.plant.views["overhead"].world_from_camera.position
    x, y, _ = route_of(cell)[1:3].mean(axis=0)
    place = Pose.level(float(x), float(y), 0.040, math.pi / 2)
    stood = along(route_of(cell), 0.070)
    new = seen_from + (stood - seen_from) * (seen_from[2] - 0.040) / (seen_from[2] - 0.070)
    cell.plant.load(cell.plant.loaded, {UNLIKE: ParkedWire(stood, frozenset())})
    picture = before(cell)
    cell.plant.load(
        cell.plant.loaded,
        {UNLIKE: ParkedWire(stood, frozenset()), WIRE: ParkedWire(new, frozenset())},
    )
    before(cell)  # the noise of the next picture is another one
    seen = WireLines(before(cell), cell.plant.panel.wire(WIRE))
    taken = uppermost_past(place, SEARCH_M, seen)
    assert taken is not None and taken.height == pytest.approx(0.070, abs=0.005)
    assert uppermost_past(place, SEARCH_M, seen, picture) is None
    cell.close()


def test_a_wire_whose_colour_is_not_seen_is_found_by_what_is_new_far_aside():
    cell = cell_of()
    stood = along(route_of(cell), 0.034) + np.array([-0.008, 0.0, 0.0])
    new = along(route_of(cell), 0.030) + np.array([FAR_ASIDE_M, 0.0, 0.0])
    cell.plant.load(cell.plant.loaded, {UNLIKE: ParkedWire(stood, frozenset())})
    picture = before(cell)
    cell.plant.load(
        cell.plant.loaded,
        {UNLIKE: ParkedWire(stood, frozenset()), WIRE: ParkedWire(new, frozenset())},
    )
    before(cell)  # the noise of the next picture is another one
    other = replace(cell.plant.panel.wire(WIRE), colour="YE")
    x, y, _ = route_of(cell)[1:3].mean(axis=0)
    place = Pose.level(float(x), float(y), 0.030, math.pi / 2)
    passing = uppermost_past(place, SEARCH_M, WireLines(before(cell), other), picture)
    assert passing is not None
    assert passing.aside == pytest.approx(-FAR_ASIDE_M, abs=0.002)
    assert passing.height == pytest.approx(0.030, abs=0.002)
    assert uppermost_past(place, SEARCH_M, WireLines(picture, other), picture) is None
    cell.close()


@pytest.mark.physics
def test_a_wire_that_others_hide_at_its_slot_is_taken(monkeypatch):
    cell = cell_of()
    key, socket = hold_an_end(cell)
    insert(cell, WIRE, WireEnd.A, *key, socket)
    fix(cell, WIRE, *key, pull=5.0)
    monkeypatch.setattr(lay_wire_module, "uppermost_past", lambda *place: None)
    lay(cell)
    assert truth.share_in_ducts(cell.plant, WIRE) >= 0.8
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_a_hidden_wire_that_comes_aslant_from_its_slot_is_taken_farther_on(monkeypatch):
    cell = cell_of()
    key, socket = hold_an_end(cell)
    insert(cell, WIRE, WireEnd.A, *key, socket)
    fix(cell, WIRE, *key, pull=5.0)
    _, slot, corner, *_ = route_of(cell)
    onward = (corner - slot) * [1.0, 1.0, 0.0] / np.linalg.norm((corner - slot)[:2])
    find = lay_wire_module._find

    def hidden(guide, *where):
        tool, _ = find(guide, *where)
        # As where it is hidden, the pads come first to the wire, then the eyelet above them.
        return tool.moved(-onward, ASLANT_M).at(
            z=tool.z + lay_wire_module._eyelet_above(guide)
        ), False

    monkeypatch.setattr(lay_wire_module, "_find", hidden)
    lay(cell)
    assert truth.share_in_ducts(cell.plant, WIRE) >= 0.8
    cell.close()


@pytest.mark.physics
def test_a_steep_wire_is_taken_where_it_is_seen_and_lets_the_pads_close_later(monkeypatch):
    cell = cell_of()
    guide = cell.context
    cell.feed(WIRE, "")
    tool = ToolPose(*map(float, route_of(cell)[1]), 0.0)
    monkeypatch.setattr(SimulatedGripper, "gap", 0.003)
    cell.run(_take(guide, tool, is_seen=True), GUIDE)
    assert guide.commanded.z == pytest.approx(tool.z - PARAMETERS.tool.eyelet_step_down_m)
    with pytest.raises(AbilityError, match=r"3\.0 mm apart; draw it out") as caught:
        _check_closed(guide)
    assert caught.value.code is Code.GRASP_MISSED
    cell.close()


@pytest.mark.slow
@pytest.mark.physics
def test_the_board_is_remembered_as_it_was_before_the_wire_was_touched():
    cell = cell_of()
    hold_an_end(cell)
    (picture,) = cell.context.belief.untouched
    cell.context.cameras.take_overhead_picture()
    assert cell.contexts[GUIDE].belief.untouched == [picture], "the wire is in the hand"
    cell.context.belief.start_wire(cell.context.belief.feed, {})
    assert not cell.context.belief.untouched, "another wire was fed"
    cell.close()


@pytest.mark.parametrize(("height", "share"), [(0.020, 1.0), (0.065, 0.0)])
def test_the_truth_counts_places_below_the_rims(height, share):
    cell = cell_of()
    cell.plant.parked[WIRE] = ParkedWire(along(route_of(cell), height), frozenset())
    assert truth.share_in_ducts(cell.plant, WIRE) == pytest.approx(share)
    cell.close()
