"""Motions of the tool under force control, as steps of an ability.

A held end is pulled out of its terminal, or its hold there is tested.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from remodel_skills.force_control import RIGID, ForceControl, ForceLoop, Yielding
from remodel_skills.primitives.grasping import release
from remodel_skills.primitives.motions import rise, wait
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose
from remodel_work.layout import STANDOFF_M
from remodel_work.panel import unit_x
from remodel_work.robot.arm import ToolPose
from remodel_work.routes import TerminalKey, nearest_terminal


class ForceMotion:
    """A push or pull along a line, or a way near it.

    It slows down as the force rises, and keeps to its limit.

    Commands at the abilities' 120 Hz would be too late: between two of them a push at 20 mm/s
    raises the force on a terminal's bottom by 10 N, and the servo and the sensor's low pass lag by
    two ticks more. So the ability sets the speed at each tick, and
    the arm's controller does each step of the physics, as controllers of arms do at 1 kHz.

    Attributes:
        loop: what the arm's controller runs.
    """

    def __init__(
        self,
        context: RobotContext,
        along: Array,
        limit: float,
        stiffness: float | None = None,
        free: Array | None = None,
        way: Callable[[float], ToolPose] | None = None,
    ) -> None:
        """Prepare a motion from where the tool was sent.

        Args:
            context: the robot.
            along: unit vector (3,), world frame.
            limit: of its force [N].
            stiffness: of the stiffest thing that may stop it [N/m]; None: of a wire in the grip.
            free: what the wrist feels of a hand that touches nothing, world frame (3,) [N]; None:
                as kept by the context.
            way: the tool pose for each travel, which begins where the tool was sent; None: straight
                on along the line.
        """
        start, arm = context.commanded, context.device.arm
        if stiffness is None:
            stiffness = context.parameters.wire.grip_stiffness_n_m
        control = ForceControl(limit, stiffness, context.parameters.motion)
        self._context = context
        self.loop = ForceLoop(
            along, control, context.free_force if free is None else free, arm.hand_mass
        )
        self._way = way or (lambda travel: start.moved(along, travel))
        self._farthest, self._farthest_at_s = 0.0, 0.0

    @property
    def travel(self) -> float:
        """From the start, along the line [m]."""
        return self.loop.travel

    @property
    def yielded(self) -> Array:
        """How far the tool gave way across the motion, (3,) [m]."""
        return self.loop.aside @ self.loop.yielding.directions

    def yield_to(self, yielding: Yielding) -> None:
        """Give way to forces across the motion from now on."""
        self.loop.yield_to(yielding)

    @property
    def force(self) -> float:
        """The force against the motion, low-passed [N]."""
        return float((self._context.device.arm.force - self.loop.free) @ self.loop.along)

    @property
    def met_limit(self) -> bool:
        """Whether the force has reached its limit, or lets the tool no further."""
        # By the controller's own steps: one that is late with them has not met anything.
        stalled_s = self.loop.elapsed_s - self._farthest_at_s
        return (
            self.force >= self.loop.control.limit
            or stalled_s > self._context.parameters.motion.stalled_s
        )

    def tare(self) -> None:
        """Take the force against the motion now for that of a hand that touches nothing."""
        self.loop.free = self.loop.free + self.force * self.loop.along

    def limit_to(self, force: float) -> None:
        """Go on with another limit [N]."""
        if force != self.loop.control.limit:
            self.loop.pressed_at = None
        self.loop.control = replace(self.loop.control, limit=force)

    def advance(self, speed: float) -> Steps[None]:
        """Move on for one tick, at a speed [m/s] or less.

        Raises:
            AbilityError: UNREACHABLE, ROBOT_IN_THE_WAY.
        """
        context, loop = self._context, self.loop
        reach = speed * context.tick_s
        here, there = self._tool(loop.travel), self._tool(loop.travel + reach)
        joints = context.arm.joints_for(here)
        turn = context.arm.joints_for(there) - joints
        aside_turns = np.array(
            [
                (
                    context.arm.joints_for(
                        here.moved(direction, self._context.parameters.motion.derivative_step_m)
                    )
                    - joints
                )
                / self._context.parameters.motion.derivative_step_m
                for direction in loop.yielding.directions
            ]
        ).reshape(-1, len(joints))
        loop.begin_tick(joints, turn, aside_turns, reach=reach, speed=speed)
        context.press(loop, here)
        yield
        if self.travel > self._farthest + self._context.parameters.motion.stalled_m:
            self._farthest, self._farthest_at_s = self.travel, loop.elapsed_s

    def stop(self) -> None:
        """Keep the tool where it is."""
        self._context.drive(self._tool(self.travel))

    def _tool(self, travel: float) -> ToolPose:
        tool = self._way(travel)
        for direction, aside in zip(self.loop.yielding.directions, self.loop.aside, strict=True):
            tool = tool.moved(direction, float(aside))
        return tool


def pull_out(context: RobotContext, socket: Pose, most_n: float) -> Steps[float]:
    """Pull the held end straight back to where a push begins, or until its tip is out at least.

    Args:
        context: the cell; its hand holds the end.
        socket: the opening's frame, x into the terminal.
        most_n: a force at which the end counts as stuck [N]: the hand goes back to where it was,
            releases the end there, and rises.

    Returns:
        The peak force [N].

    Raises:
        AbilityError: EXTRACTION_STUCK, the hand empty.
    """
    out = -unit_x(socket)
    grip, start = context.belief.grip, context.commanded
    assert grip is not None, "the end is held"
    ahead = float((start.position - socket.position) @ -out) + grip.distance
    inside = max(0.0, ahead)
    motion = ForceMotion(context, out, most_n)
    while motion.travel < inside + STANDOFF_M:
        yield from motion.advance(context.parameters.motion.pull_speed_m_s)
        if motion.met_limit and motion.travel > inside + context.parameters.terminal.out_m:
            break  # What holds it now is not the terminal, such as the slot that it passes.
        if motion.met_limit:
            stuck_at = motion.force  # before the hand goes back and the wire relaxes
            context.drive(start)
            yield from wait(context, context.parameters.motion.force_still_s)
            where = yield from _leave_in_terminal(context, socket)
            raise AbilityError(
                Code.EXTRACTION_STUCK,
                f"end {grip.end.value} in '{'/'.join(where)}' does not come out at {stuck_at:.0f} "
                "N; it was released there, the hand is empty",
                peak_force=motion.loop.peak,
            )
    motion.stop()
    context.belief.engaged = None
    return motion.loop.peak


def _leave_in_terminal(context: RobotContext, socket: Pose) -> Steps[TerminalKey]:
    """Release the held end where it sits, and rise; return its terminal."""
    belief = context.belief
    assert belief.grip is not None, "the end is held"
    where = nearest_terminal(socket.position, context.panel, belief.seen)
    belief.seat(belief.grip.end, where)
    yield from release(context, context.parameters.tool.release_opening_m)
    yield from rise(context)
    return where


def pull_test(
    context: RobotContext,
    socket: Pose,
    newtons: float,
    where: str,
    stiffness: float | None = None,
    yielding: Yielding = RIGID,
) -> Steps[float]:
    """Pull the held end outwards until the force is reached; return the slip [m].

    Args:
        context: the cell; its hand holds the end.
        socket: the opening's frame, x into the terminal.
        newtons: the force [N].
        where: the terminal's name.
        stiffness: with which a held end takes up the pull [N/m]; None: as a clamped wire.
        yielding: how the hand gives way across the pull: an end that it holds askew leans on its
            opening, and would jerk between the pads.

    Raises:
        AbilityError: PULLED_OUT.
    """
    wire = context.parameters.wire
    out = -unit_x(socket)
    start = context.commanded
    if stiffness is None:
        stiffness = wire.clamped_stiffness_n_m
    # The push left the end under load; the pull counts from the free hand.
    motion = ForceMotion(context, out, newtons, stiffness)
    motion.yield_to(yielding)
    if motion.force >= wire.taken_up_share * newtons:
        motion.tare()  # a thick wire, bent behind the hand, pulls at it before the end does
    taken_up = None
    while not motion.met_limit and motion.travel < wire.pull_travel_m:
        yield from motion.advance(context.parameters.motion.test_speed_m_s)
        if taken_up is None and motion.force >= wire.taken_up_share * newtons:
            taken_up = motion.travel
    motion.stop()
    slip = motion.travel - (taken_up if taken_up is not None else 0.0)
    # An end that creeps under less than the pull has not met it: the motion only stalled.
    if (
        not motion.met_limit
        or motion.loop.pressed_at is None
        or slip > context.parameters.terminal.max_slip_m
    ):
        raise AbilityError(
            Code.PULLED_OUT,
            f"the end moved {slip * 1e3:.1f} mm in {where} at {motion.force:.1f} of {newtons:.1f} "
            "N; extract, locate again, insert again",
            slip=slip,
        )
    context.drive(start)
    yield from wait(context, context.parameters.motion.force_still_s)
    return slip
