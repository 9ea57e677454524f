"""A motion of the tool under force control, as steps of an ability."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from remodel_skills.force_control import ForceControl, ForceLoop, Yielding
from remodel_skills.robot_context import RobotContext, Steps
from remodel_work.geometry import Array
from remodel_work.robot.arm import ToolPose


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
