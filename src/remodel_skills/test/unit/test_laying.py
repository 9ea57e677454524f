"""How two hands lay a wire into its ducts: on scripted devices, with drawn pictures."""

from itertools import pairwise

import numpy as np
import pytest
from laid_wires import HOUSEHOLD, ROUTE, WIRE, laid, led
from refusals import refused
from scripted_device import PARAMETERS

from remodel_skills.abilities.lay_wire import LayGoal, draw_straight, lay_wire
from remodel_skills.belief_state import EndState, Grip
from remodel_skills.motion import Line
from remodel_skills.primitives.together import flat_hold, hold_off, least_gap
from remodel_states.core.codes import Code
from remodel_work.panel import WireEnd
from remodel_work.robot.arm import ToolPose

FIXTURE, MOTION, TOOL = PARAMETERS.fixture, PARAMETERS.motion, PARAMETERS.tool
GUIDE, HOLDER = "robot_1", "robot_2"
GOAL = LayGoal(HOLDER, GUIDE, WIRE.id)
# The end in the holding hand is so far before it [m]; the hand waits beside the plate.
GRIP_M = 0.02
WAITS = ToolPose(0.30, 0.25, 0.25, 0.0)
# A wire that is straight is so stiff [N/m]; one that hangs in a slot pulls harder than it may [N].
STIFF_N_M, SNAGGED_N = 2000.0, 60.0
# Points of a route are so far apart [m].
STEP_M = 0.002
# Where it comes out of its first slot, a wire is so high, held off by the other hand [m].
AT_SLOT_M = 0.060
# A wire goes through the nearest slot of its duct [m].
HALF_PITCH_M = HOUSEHOLD.ducts[0].slot_pitch / 2
# Where others hide it, it is so high there [m].
HIDDEN_M = 0.045
# The pads are around a wire that is so near to the tool, level and up [m].
NEAR_M = 0.006
# A hand in a duct is lower than this, one that has lifted a wire over the rims higher [m].
OVER_RIMS_M = 0.045
# Before and after it passes that height, it is being lifted for so long [ticks].
LIFTING_TICKS = 40


class Laying:
    """A cell whose holder has one end of a wire, the other one fixed; it pulls once it is straight.

    Attributes:
        route: from the fixed end to the held one, (n, 3) [m].
        path: the same, level, STEP_M after STEP_M (n, 2) [m].
        wire_at: where the wire is when it is taken, (3,) [m]; it is nowhere else.
        gripper: of the leading hand.
    """

    def __init__(self, *shapes, wire_at=None, held=WireEnd.B):
        self.route = ROUTE if held is WireEnd.B else ROUTE[::-1]
        far = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(self.route, axis=0), axis=1))]
        steps = np.arange(0.0, far[-1], STEP_M)
        self.path = np.column_stack([np.interp(steps, far, self.route[:, i]) for i in range(2)])
        self.cell = cell = laid(*shapes)
        self.guide, self.holder = cell.contexts[GUIDE], cell.contexts[HOLDER]
        arms, belief = cell.plant.arms, self.holder.belief
        self.wire_at = np.array([*self.route[1, :2], AT_SLOT_M]) if wire_at is None else wire_at
        self.gripper = cell.plant.grippers[GUIDE]
        self.gripper.between = self.between
        belief.ends.update({held: EndState.LOOSE, held.other: EndState.FIXED})
        self.holder.drive(WAITS)
        belief.grip = Grip(held, GRIP_M, 0.0, 0.0, WAITS)
        arms[HOLDER].feels = self.pull
        GOAL.check(cell.plant.panel, self.holder.belief, PARAMETERS)

    def between(self):
        """Return how far apart the wire keeps the pads where it is not in the eyelet [m]."""
        tool, eyelet = self.guide.commanded, self.guide.fingers.eyelet
        away = np.linalg.norm(tool.position[:2] - self.wire_at[:2])
        is_in_eyelet = abs(tool.z + eyelet.above - self.wire_at[2]) < eyelet.height / 2
        return WIRE.diameter if away < NEAR_M and not is_in_eyelet else 0.0

    @property
    def is_closed(self):
        return self.gripper.opened <= TOOL.eyelet_apart_m

    @property
    def closed_at(self):
        """Where the leading hand closed last."""
        trace = pairwise(self.cell.plant.trace[GUIDE])
        return [tool for (_, was), (tool, gap) in trace if gap < was][-1]

    @property
    def fixed_terminals(self):
        component, terminal = WIRE.goes_to(WireEnd.A)
        return [self.cell.plant.panel.component(component).terminal(terminal)]

    def pull(self, tool):
        """Return the pull at the holding hand (3,) [N], once the wire is straight."""
        eyelet = self.guide.commanded.position
        led = STEP_M * np.linalg.norm(self.path - eyelet[:2], axis=1).argmin()
        left = WIRE.length - GRIP_M - led
        apart = tool.position - eyelet
        far = float(np.linalg.norm(apart))
        return STIFF_N_M * max(0.0, far - left) * apart / max(far, STEP_M)

    def run(self, until=""):
        """Lay the wire, until a message begins so; return the commands of both hands."""
        steps, commands = lay_wire(self.holder, self.guide, GOAL), []

        def watched():
            try:
                while True:
                    next(steps)
                    commands.append((self.guide.commanded, self.holder.commanded))
                    if until and self.guide.progress.message.startswith(until):
                        steps.close()
                        return None
                    yield
            except StopIteration as done:
                self.result = done.value

        self.cell.run(watched(), HOLDER, GUIDE)
        return commands


@pytest.mark.parametrize("length", [0.20, 0.30])
def test_a_hand_that_holds_a_short_wire_leaves_room_for_the_one_that_takes_it(length):
    laying = Laying()
    slot = ToolPose(*laying.route[1].tolist(), 0.0)
    visit = laying.guide, slot.at(z=MOTION.travel_z_m)
    onward = laying.route[2] - laying.route[1]

    def gap(visits):
        move = hold_off(
            *(laying.holder, slot, onward / np.linalg.norm(onward), length),
            *(flat_hold(PARAMETERS.wire), visits),
        )
        return least_gap(
            [
                (robot, Line(there, there, 1.0, MOTION))
                for robot, there in ((laying.holder, dict(move)[laying.holder]), visit)
            ]
        )

    assert gap([visit]) >= MOTION.holding_apart_m
    assert (gap([]) < MOTION.holding_apart_m) == (length < 0.25), "a longer one leaves it anyhow"


def at_slot(held=WireEnd.B):
    """Return a wire as it hangs between its first slot and the holding hand."""
    nodes = led(AT_SLOT_M)
    part = len(nodes) // 3
    return nodes[:part] if held is WireEnd.B else nodes[-part:]


def test_a_wire_is_led_along_its_route_and_released_at_its_last_slot():
    laying = Laying(at_slot())
    commands = laying.run()
    assert laying.result.message == "W3 laid into D0, L, D1"
    in_ducts = np.array([guide.position for guide, _ in commands if guide.z < OVER_RIMS_M])
    at_corners = [np.linalg.norm(in_ducts[:, :2] - at[:2], axis=1) for at in ROUTE[2:4]]
    assert max(away.min() for away in at_corners) < FIXTURE.duct_corner_m
    assert at_corners[0].argmin() < at_corners[1].argmin()
    assert not laying.is_closed and not laying.guide.keeps_wire
    assert laying.guide.commanded.z >= MOTION.travel_z_m - 1e-6
    assert laying.holder.belief.grip is not None, "the holder keeps the free end"


def test_where_there_is_room_a_wire_is_kept_at_its_last_corner():
    laying = Laying(at_slot(WireEnd.A), held=WireEnd.A)
    laying.run()
    guide, holder = laying.guide, laying.holder
    corner, slot = laying.route[-3:-1]
    onward = (slot - corner)[:2] / np.linalg.norm(slot - corner)
    kept = guide.commanded.position[:2] - corner[:2]
    assert kept == pytest.approx(FIXTURE.duct_corner_m * onward, abs=1e-3)
    assert laying.is_closed and guide.keeps_wire
    assert holder.belief.grip is not None, "the holder keeps the free end"
    tip_yaw = holder.commanded.yaw + holder.belief.grip.flip
    away = holder.commanded.position - slot
    assert away[:2] @ [np.cos(tip_yaw), np.sin(tip_yaw)] > 0, "its tip points away from the duct"


def hang(laying, *, also_lifted):
    """Let the wire hang in a slot of its first duct; return the pull that it stands [N]."""
    arm, middle = laying.cell.plant.arms[GUIDE], ROUTE[1:3].mean(axis=0)
    retained = min(terminal.retention_force for terminal in laying.fixed_terminals)
    lifted = []

    def feels(tool):
        is_there = abs(tool.y - middle[1]) < FIXTURE.duct_straight_again_m
        lifted.append(is_there and tool.z > OVER_RIMS_M)
        hangs = is_there and (also_lifted or not any(lifted))
        return np.array([SNAGGED_N * hangs, 0.0, 0.0])

    arm.feels = feels
    return PARAMETERS.terminal.lead_pull_share * retained


def test_a_wire_that_hangs_in_a_slot_is_lifted_by_both_hands_and_led_on():
    laying = Laying(at_slot())
    allowed = hang(laying, also_lifted=False)
    commands = laying.run()
    assert laying.result.peak_force > allowed
    heights = np.array([[hand.z for hand in hands] for hands in commands])
    is_low = heights[:, 0] < OVER_RIMS_M
    first = is_low.argmax()
    rises = first + (~is_low[first:]).argmax()
    around = heights[rises - LIFTING_TICKS : rises + LIFTING_TICKS]
    lift_m = FIXTURE.duct_over_rim_m + FIXTURE.duct_under_rim_m
    assert np.all(np.ptp(around, axis=0) > 0.9 * lift_m), "both hands"
    assert "laid into" in laying.result.message


def test_a_wire_that_still_pulls_too_hard_is_given_up_with_what_it_pulled_with():
    laying = Laying(at_slot())
    allowed = hang(laying, also_lifted=True)
    with refused(Code.SNAGGED, "it hangs on something") as caught:
        laying.run()
    assert caught.value.found["peak_force"] > allowed
    assert not laying.is_closed and laying.guide.commanded.z >= MOTION.travel_z_m - 1e-6


def test_a_wire_that_others_hide_is_taken_where_it_comes_out_of_its_slot():
    laying = Laying(wire_at=np.array([*ROUTE[1, :2], HIDDEN_M]))
    laying.run(until="leading the wire")
    taken, eyelet = laying.closed_at, laying.guide.fingers.eyelet
    assert taken.position[:2] == pytest.approx(ROUTE[1, :2], abs=HALF_PITCH_M)
    assert taken.z + eyelet.above == pytest.approx(HIDDEN_M, abs=eyelet.height / 2)


def test_a_hidden_wire_that_comes_aslant_from_its_slot_is_taken_farther_on():
    onward = (ROUTE[2] - ROUTE[1]) / np.linalg.norm(ROUTE[2] - ROUTE[1])
    aslant = ROUTE[1] + FIXTURE.duct_onward_m * onward
    laying = Laying(wire_at=np.array([*aslant[:2], HIDDEN_M]))
    laying.run(until="leading the wire")
    ahead = (laying.closed_at.position - ROUTE[1]) @ onward
    assert ahead == pytest.approx(FIXTURE.duct_onward_m, abs=HALF_PITCH_M)


def test_a_hidden_wire_that_is_not_found_is_not_taken():
    laying = Laying(wire_at=ROUTE[4])
    with refused(Code.GRASP_MISSED, "does not close around 'W3'"):
        laying.run()
    assert not laying.is_closed and laying.guide.commanded.z >= MOTION.travel_z_m - 1e-6


def test_a_steep_wire_is_taken_where_it_is_seen_and_must_let_the_pads_close_later():
    laying = Laying(at_slot())
    laying.gripper.between = lambda: WIRE.diameter
    with refused(Code.GRASP_MISSED, r"not in its eyelet: they are 3\.7 mm apart; draw it out"):
        laying.run()


def test_a_wire_that_does_not_become_straight_is_not_in_the_eyelet():
    laying = Laying()
    laying.cell.plant.arms[HOLDER].feels = lambda tool: np.zeros(3)
    holder, height = laying.holder, laying.holder.commanded.z
    below = holder.commanded.position - np.array([0.0, 0.0, 0.1])
    with refused(Code.GRASP_MISSED, "is not in the eyelet"):
        laying.cell.run(draw_straight(holder, below, 1.0), HOLDER)
    assert holder.commanded.z - height == pytest.approx(MOTION.tighten_m, abs=0.01)


def test_a_wire_that_the_holder_lost_before_is_not_taken():
    laying = Laying()
    laying.holder.device.gripper.load = 0.0
    with refused(Code.GRASP_SLIPPED, "end b of 'W3' slipped out of the fingers"):
        laying.run()
    assert not laying.is_closed and laying.holder.belief.grip is None


def test_a_wire_that_the_holder_has_lost_is_not_missed_by_the_eyelet():
    laying = Laying()
    laying.cell.plant.arms[HOLDER].feels = lambda tool: np.zeros(3)
    holder = laying.holder
    holder.device.gripper.load = 0.0
    below = holder.commanded.position - np.array([0.0, 0.0, 0.1])
    with refused(Code.GRASP_SLIPPED, "end b of .* slipped out of the fingers"):
        laying.cell.run(draw_straight(holder, below, 1.0), HOLDER)
    assert holder.belief.grip is None
