"""A motion of the tool under force control, as steps of an ability."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from remodel_sim.abilities.execution.robot_context import RobotContext, Steps
from remodel_sim.core.robot.force_control import ForceControl, Yielding
from remodel_work.geometry import Array
from remodel_work.robot.arm import ToolPose

# A motion that gets no further than this within this time has met its limit as well: what it rests
# on may swing about the limit by less than the sensor's low pass lets through.
STALLED_M = 1e-4
STALLED_S = 0.3
# What presses with such a share of its limit has met something.
PRESSED_SHARE = 0.8
# Step of the numeric derivatives of the joints [m].
STEP_M = 1e-3
# A motion that gives way nowhere.
RIGID = Yielding(np.zeros((0, 3)), np.zeros(0))


class ForceMotion:
    """A push or pull along a line, or a way near it.

    It slows down as the force rises, and keeps to its limit.

    Commands at the abilities' 120 Hz would be too late: between two of them a push at 20 mm/s
    raises the force on a terminal's bottom by 10 N, and the servo and the sensor's low pass lag by
    two ticks more. So the ability sets the speed at each tick, and
    the arm's controller does each step of the physics, as controllers of arms do at 1 kHz.

    Attributes:
        travel: from the start, along the line [m].
        peak: the largest force so far, of each step, not filtered [N].
        pressed_at: travel at which the force first came to PRESSED_SHARE of its limit [m]; None:
            it has not yet.
    """

    def __init__(
        self,
        context: RobotContext,
        along: Array,
        control: ForceControl,
        free: Array | None = None,
        way: Callable[[float], ToolPose] | None = None,
    ) -> None:
        """Prepare a motion from where the tool was sent.

        Args:
            context: the robot.
            along: unit vector (3,), world frame.
            control: its limit.
            free: what the wrist feels of a hand that touches nothing, world frame (3,) [N]; None:
                as kept by the context.
            way: the tool pose for each travel, which begins where the tool was sent; None: straight
                on along the line.
        """
        self._context, self._along, self._control = context, along, control
        self._free = context.free_force if free is None else free
        start, self._hand_mass = context.commanded, context.hand_mass
        self._way = way or (lambda travel: start.moved(along, travel))
        self._speed = self._wanted = 0.0
        self._acceleration = 0.0
        self.travel = self.peak = 0.0
        self.pressed_at: float | None = None
        self._farthest, self._stalled_s = 0.0, 0.0
        self._yielding, self._aside = RIGID, np.zeros(0)
        self._aside_speed = self._aside_acceleration = np.zeros(0)

    @property
    def yielded(self) -> Array:
        """How far the tool gave way across the motion, (3,) [m]."""
        return self._aside @ self._yielding.directions

    def yield_to(self, yielding: Yielding) -> None:
        """Give way to forces across the motion from now on."""
        self._yielding = yielding
        self._aside = np.zeros(len(yielding.most))
        self._aside_speed = self._aside_acceleration = np.zeros(len(yielding.most))

    @property
    def force(self) -> float:
        """The force against the motion, low-passed [N]."""
        return float((self._context.force - self._free) @ self._along)

    @property
    def met_limit(self) -> bool:
        """Whether the force has reached its limit, or lets the tool no further."""
        return self.force >= self._control.limit or self._stalled_s > STALLED_S

    def tare(self) -> None:
        """Take the force against the motion now for that of a hand that touches nothing."""
        self._free = self._free + self.force * self._along

    def limit_to(self, force: float) -> None:
        """Go on with another limit [N]."""
        if force != self._control.limit:
            self.pressed_at = None
        self._control = replace(self._control, limit=force)

    def advance(self, speed: float) -> Steps[None]:
        """Move on for one tick, at a speed [m/s] or less.

        Raises:
            AbilityError: UNREACHABLE, ROBOT_IN_THE_WAY.
        """
        context = self._context
        self._wanted = speed
        self._from = self.travel
        self._reach = speed * context.tick_s
        here, there = self._tool(self.travel), self._tool(self.travel + self._reach)
        self._joints = context.arm.joints_for(here)
        self._turn = context.arm.joints_for(there) - self._joints
        self._aside_from = self._aside
        self._aside_turns = np.array(
            [
                (context.arm.joints_for(here.moved(direction, STEP_M)) - self._joints) / STEP_M
                for direction in self._yielding.directions
            ]
        ).reshape(-1, len(self._joints))
        context.drive_by(self._step, here)
        yield
        self._stalled_s += context.tick_s
        if self.travel > self._farthest + STALLED_M:
            self._farthest, self._stalled_s = self.travel, 0.0

    def stop(self) -> None:
        """Keep the tool where it is."""
        self._context.drive(self._tool(self.travel))

    def _tool(self, travel: float) -> ToolPose:
        tool = self._way(travel)
        for direction, aside in zip(self._yielding.directions, self._aside, strict=True):
            tool = tool.moved(direction, float(aside))
        return tool

    def _step(self, wrist_force: Array, time_step: float) -> Array:
        """Return the joints of the next step, (joints,), see `Robot.drive_by`."""
        all_felt = wrist_force - self._free
        felt = float(all_felt @ self._along)
        force = felt - self._hand_mass * self._acceleration
        self.peak = max(self.peak, force)
        if self.pressed_at is None and force >= PRESSED_SHARE * self._control.limit:
            self.pressed_at = self.travel
        speed = self._control.speed(self._wanted, force, self._speed, time_step)
        travel = self.travel + speed * time_step
        travel = float(np.clip(travel, self._from - self._reach, self._from + self._reach))
        reached = (travel - self.travel) / time_step
        self._acceleration = (reached - self._speed) / time_step
        self.travel, self._speed = travel, reached
        aside = self._give_way(all_felt, time_step) @ self._aside_turns
        return self._joints + (travel - self._from) / self._reach * self._turn + aside

    def _give_way(self, felt: Array, time_step: float) -> Array:
        """Give way across the motion for a step; return how far since the tick began, (k,) [m]."""
        yielding, before = self._yielding, self._aside_speed
        forces = yielding.directions @ felt - self._hand_mass * self._aside_acceleration
        speeds = yielding.speeds(forces, before, time_step)
        aside = np.clip(self._aside + speeds * time_step, -yielding.most, yielding.most)
        self._aside_speed = (aside - self._aside) / time_step
        self._aside_acceleration = (self._aside_speed - before) / time_step
        self._aside = aside
        return aside - self._aside_from
