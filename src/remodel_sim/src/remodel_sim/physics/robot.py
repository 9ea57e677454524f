"""A robot in the world: drives joints and fingers, and reads what a real arm's sensors measure.

The skills command it as a device of their port, `remodel_skills.device`.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from remodel_sim.physics.world import CONTACT_DAMPING, CONTACT_STIFFNESS, World
from remodel_skills.force_control import ForceLoop
from remodel_work.camera import Picture, View
from remodel_work.cell.cell_design import Gripper, RobotDesign
from remodel_work.edge.bullet import PARKED_GROUP
from remodel_work.edge.robot_description import (
    AXIS_FORCE_N,
    FINGERS,
    HAND,
    SHEATHS,
    foot_link,
    robot_description,
)
from remodel_work.geometry import Array, Pose
from remodel_work.robot.arm import PANDA_AT_ORIGIN, Kinematics, ToolPose
from remodel_work.robot.fingers import CAMERA_MOUNT
from remodel_work.robot.portal import Portal

ARM_TORQUE = 200.0  # [N m] stiff servo: the arm follows to 0.05 mm
ARM_GAIN = 0.3
# A controller that steps with the physics commands where the arm is to be after one step: the
# servo's lag of three steps would add as much to the force of a push as the ability's tick.
STEP_GAIN = 1.0
# The fingers close slowly and stop as soon as their motors feel the grip force; then they keep that
# force by small, slow corrections of their position. Squeezing by a force-limited motor instead
# loses the wire: the solver moves the light link between two heavy fingers too little per step.
FINGER_SPEED = 0.10  # [m/s] while nothing is near
FINGER_TOUCH_SPEED = 0.012  # [m/s] while a wire may be between the pads
TOUCH_GAP = 0.008  # [m] between the pads: the thickest wire and some
FINGER_MOTOR_FORCE = 150.0  # [N]
# The corrections [m/(N s)]: some 20 mm/s for each millimetre that the pads are pressed in; and how
# far they may go in all [m], far less than a wire's thickness.
GRIP_GAIN = 1e-4
GRIP_CORRECTION_M = 0.0003
# The hand of cells that say nothing else: closing stops at 30 N per finger; the Panda's holds 70 N.
HAND_30_N = Gripper(grip_force=30.0, pad_friction=1.0)
# A rubber pad touches over a patch; its radius of some 4 mm resists turning about the contact
# normal [m].
PAD_SPINNING_FRICTION = 0.004
COLLISION_GROUP = 4
# First-order low pass of the wrist force [s]: a wrist sensor's bandwidth of 20 Hz.
FORCE_TIME_CONSTANT = 0.008

# Returns the joints, as `drive` takes them, for the next step, given the wrist force of the last
# one, not filtered, world frame (3,) [N], and the time step [s].
Controller = Callable[[Array, float], Array]


def _servo_forces(arm: Kinematics) -> list[float]:
    """Return what the servos of all joints can do [N, N m]."""
    if isinstance(arm, Portal):
        return [AXIS_FORCE_N] * 3 + [ARM_TORQUE]
    return [*([] if arm.axis is None else [AXIS_FORCE_N]), *[ARM_TORQUE] * 7]


class Robot:
    """An arm on its base with a hand, pointing its tool down.

    Attributes:
        arm: its kinematics.
        body: PyBullet's number of it.
        grip_force: per finger at which closing stops [N].
        force_noise: standard deviation of a reading of the wrist, each axis [N].
        joint_names: of the axis if there is one, of the arm's seven joints and of the two fingers,
            as the makers call them.
    """

    def __init__(
        self,
        world: World,
        start: ToolPose,
        arm: Kinematics = PANDA_AT_ORIGIN,
        gripper: Gripper = HAND_30_N,
        seed: Sequence[int] = (0,),
    ) -> None:
        """Load the arm in a posture, fingers open; the seed is of the noise of its readings."""
        self._bullet = world.bullet
        self._time_step = world.time_step
        self.arm = arm
        self._gripper = gripper
        base = arm.world_from_base
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "arm.urdf"
            path.write_text(robot_description(arm, sheaths=True))
            self.body = self._bullet.loadURDF(
                str(path), base.position.tolist(), base.quaternion.tolist(), useFixedBase=True
            )
        infos = [
            self._bullet.getJointInfo(self.body, i)
            for i in range(self._bullet.getNumJoints(self.body))
        ]
        links = {info[12].decode(): info[0] for info in infos}
        # The fixed joint between flange and hand, where the force sensor sits, and the hand's link.
        self._wrist = links[HAND]
        self._base = links.get(foot_link(arm))
        self._fingers = [links[finger] for finger in FINGERS]
        self._joint_forces = _servo_forces(arm)
        self._joints = list(range(len(self._joint_forces)))
        self.joint_names = [infos[i][1].decode() for i in self._joints + self._fingers]
        self.grip_force = gripper.grip_force
        self.force_noise = 0.0
        self._random = np.random.default_rng(seed)
        self._force = np.zeros(3)
        self._controller: Controller | None = None
        self._most = arm.fingers.opening / 2
        self._opening = self._target = self._most
        self._touch_gap = TOUCH_GAP
        self._grips = False
        self._correction = 0.0
        joints = arm.joints_for(start)
        for joint, angle in zip(self._joints, joints, strict=True):
            self._bullet.resetJointState(self.body, joint, angle)
        for finger in self._fingers:
            self._bullet.resetJointState(self.body, finger, self._opening)
            self._bullet.changeDynamics(
                self.body,
                finger,
                lateralFriction=gripper.pad_friction,
                spinningFriction=PAD_SPINNING_FRICTION,
                restitution=0,
                contactStiffness=CONTACT_STIFFNESS,
                contactDamping=CONTACT_DAMPING,
                frictionAnchor=1,  # without it a gripped wire creeps by 1 mm/s
            )
        self._set_contacts([links[sheath] for sheath in SHEATHS])
        self._solid = [
            link
            for link in range(-1, len(infos))
            if link != self._base and self._bullet.getCollisionShapeData(self.body, link)
        ]
        if self._base is not None:
            # It slides along its rail, on the plane that wires lie on.
            self._bullet.setCollisionFilterGroupMask(self.body, self._base, 0, 0)
        self._bullet.enableJointForceTorqueSensor(self.body, self._wrist, 1)
        # What the servos were sent last, and what is left of the ramp to the last command.
        self._ramp: list[Array] = []
        self._gain = ARM_GAIN
        self._drive(joints, ARM_GAIN)
        self._drive_fingers()
        world.add_before_step(self._sense)

    def _set_contacts(self, sheaths: list[int]) -> None:
        """Let parked wires touch the sheaths in place of the fingers, and nothing else touch them.

        Two links touch if the mask of either has the group of the other.
        """
        for link in range(-1, self._bullet.getNumJoints(self.body)):
            group, mask = COLLISION_GROUP, -1
            if link in self._fingers:
                mask = ~PARKED_GROUP
            elif link in sheaths:
                group, mask = 0, PARKED_GROUP
                friction = self._gripper.pad_friction
                self._bullet.changeDynamics(self.body, link, lateralFriction=friction)
            self._bullet.setCollisionFilterGroupMask(self.body, link, group, mask)

    def drive(self, joints: Array, steps: int = 1, *, at_once: bool = False) -> None:
        """Send the arm's joints somewhere in so many steps, and end what `drive_by` began.

        They are an axis's position [m], if it stands on one, then seven angles [rad]. Between two
        commands the servos follow a ramp: a jump in every second step would shake the hand, and a
        moving hand's wrist would feel 30 N for each m/s. `at_once`: without the servo's lag, as
        a controller that steps with the physics.
        """
        self._controller, self._gain = None, STEP_GAIN if at_once else ARM_GAIN
        self._ramp = [*np.linspace(self._sent, joints, steps + 1)[1:]]

    def drive_by(self, controller: Controller) -> None:
        """Let a controller command the joints before each step, until `drive`."""
        self._controller, self._ramp = controller, []

    def _drive(self, joints: Array, gain: float) -> None:
        self._sent = joints
        self._bullet.setJointMotorControlArray(
            self.body,
            self._joints,
            self._bullet.POSITION_CONTROL,
            targetPositions=list(joints),
            forces=self._joint_forces,
            positionGains=[gain] * len(self._joints),
            velocityGains=[1.0] * len(self._joints),
        )

    def weaken(self, friction: float, grip: float) -> None:
        """Leave a share of the pads' friction and of the grip force."""
        self.grip_force = grip * self._gripper.grip_force
        pads = friction * self._gripper.pad_friction
        for finger in self._fingers:
            self._bullet.changeDynamics(self.body, finger, lateralFriction=pads)

    def drive_fingers(self, opening: float, touch_gap: float = TOUCH_GAP) -> None:
        """Send each finger to a distance from the middle [m], as far as it goes.

        Closing, they stop on what they grip, slow where the pads are within `touch_gap` [m].
        """
        self._target = min(self._most, max(0.0, opening))
        self._touch_gap = touch_gap

    def _move_fingers(self) -> None:
        if self._target == self._opening:
            if self._grips:
                self._keep_force()
            return
        closing = self._target < self._opening
        self._grips = closing and self.finger_load >= self.grip_force
        if self._grips:
            self._target, self._correction = self._opening, 0.0
        near = closing and 2 * self._opening < self._touch_gap
        step = (FINGER_TOUCH_SPEED if near else FINGER_SPEED) * self._time_step
        self._opening += max(-step, min(step, self._target - self._opening))
        self._drive_fingers()

    def _keep_force(self) -> None:
        loads = self.finger_loads()
        excess = sum(loads) / 2 - self.grip_force
        correction = self._correction + GRIP_GAIN * excess * self._time_step
        self._correction = max(-GRIP_CORRECTION_M, min(GRIP_CORRECTION_M, correction))
        self._drive_fingers()

    def _drive_fingers(self) -> None:
        self._bullet.setJointMotorControlArray(
            self.body,
            self._fingers,
            self._bullet.POSITION_CONTROL,
            targetPositions=[self._opening + self._correction] * 2,
            forces=[FINGER_MOTOR_FORCE] * 2,
            positionGains=[0.5] * 2,
            velocityGains=[1.0] * 2,
        )

    @property
    def finger_load(self) -> float:
        """Measured closing force of the weaker finger [N]."""
        return min(self.finger_loads())

    def finger_loads(self) -> list[float]:
        """Measured closing force of each finger [N]."""
        return [-s[3] for s in self._bullet.getJointStates(self.body, self._fingers)]

    def _sense(self) -> None:
        self._move_fingers()
        reading = self.read_wrist()
        share = min(1.0, self._time_step / FORCE_TIME_CONSTANT)
        self._force += share * (reading - self._force)
        if self._ramp:
            self._drive(self._ramp.pop(0), self._gain)
        elif self._controller is not None:
            felt = self.world_from_hand.rotation @ reading
            self._drive(self._controller(felt, self._time_step), STEP_GAIN)

    def read_wrist(self) -> Array:
        """Read the force at the wrist in the last step, hand frame (3,) [N], not filtered."""
        force = np.array(self._bullet.getJointState(self.body, self._wrist)[2][:3])
        if self.force_noise:
            force += self.force_noise * self._random.standard_normal(3)
        return force

    @property
    def hand_mass(self) -> float:
        """What the wrist carries [kg]."""
        parts = (self._wrist, *self._fingers)
        return sum(self._bullet.getDynamicsInfo(self.body, part)[0] for part in parts)

    @property
    def wrist_force(self) -> Array:
        """Force at the wrist, low-passed, hand frame, (3,) [N]; holds the hand's weight."""
        return self._force.copy()

    def boxes(self) -> tuple[Array, Array]:
        """Return the lower and upper corners of boxes around its solid links, each (n, 3) [m].

        PyBullet's boxes are of the last forward kinematics: without that of now, they would follow
        from who else has read a pose since the last step, such as a publisher.
        """
        self._link_pose(self._wrist)
        boxes = np.array([self._bullet.getAABB(self.body, link) for link in self._solid])
        return boxes[:, 0], boxes[:, 1]

    @property
    def joints(self) -> Array:
        """Measured joints of the arm, (joints,), as for `drive`."""
        return np.array([s[0] for s in self._bullet.getJointStates(self.body, self._joints)])

    @property
    def joint_state(self) -> tuple[list[float], list[float]]:
        """Measured positions and velocities of all joints, in the order of `joint_names`."""
        states = self._bullet.getJointStates(self.body, self._joints + self._fingers)
        return [s[0] for s in states], [s[1] for s in states]

    @property
    def finger_gap(self) -> float:
        """Measured distance between the pads [m]."""
        return sum(s[0] for s in self._bullet.getJointStates(self.body, self._fingers))

    @property
    def tool(self) -> ToolPose:
        """The measured tool pose, by forward kinematics of the measured joints."""
        return self.arm.tool_of(self.joints)

    @property
    def world_from_base(self) -> Pose:
        """The arm's base as measured: an axis carries it."""
        if self._base is None:
            return self.arm.world_from_base
        return self._link_pose(self._base)

    @property
    def world_from_hand(self) -> Pose:
        """The hand frame as measured."""
        return self._link_pose(self._wrist)

    def _link_pose(self, link: int) -> Pose:
        """Return where a link is now, by forward kinematics of the whole body."""
        # Link frames of a body are about the centre of mass; [4:6] is the frame of the description.
        state = self._bullet.getLinkState(self.body, link, computeForwardKinematics=True)
        return Pose(np.array(state[4]), np.array(state[5]))

    @property
    def world_from_camera(self) -> Pose:
        """The wrist camera's optical frame: x right, y down the picture, z along the view."""
        return self.world_from_hand @ Pose(np.array(CAMERA_MOUNT), np.array([0.0, 0.0, 0.0, 1.0]))


# As a device of the skills' port


class _Plant(Protocol):
    """Where robots are; it builds them for every wire."""

    steps_per_tick: int

    @property
    def robots(self) -> Mapping[str, Robot]:
        """By name."""


class _PartOfRobot:
    """What finds its robot in the plant, which rebuilds it for every wire."""

    def __init__(self, plant: _Plant, name: str) -> None:
        """Name the robot."""
        self._plant, self._name = plant, name

    @property
    def _robot(self) -> Robot:
        return self._plant.robots[self._name]


class SimulatedArm(_PartOfRobot):
    """The arm of a robot in the plant."""

    def __init__(self, plant: _Plant, design: RobotDesign) -> None:
        """Take the robot of a design."""
        super().__init__(plant, design.name)
        self._arm = design.arm

    @property
    def tool(self) -> ToolPose:
        """The measured tool pose."""
        return self._robot.tool

    @property
    def force(self) -> Array:
        """The measured force of the wrist on the hand, low-passed, world frame, (3,) [N]."""
        robot = self._robot
        return robot.world_from_hand.rotation @ robot.wrist_force

    @property
    def hand_mass(self) -> float:
        """What the wrist carries [kg]."""
        return self._robot.hand_mass

    def go(self, tool: ToolPose) -> None:
        """Be at a tool pose after a tick; raises AbilityError UNREACHABLE."""
        self.go_joints(self._arm.joints_for(tool))

    def go_joints(self, joints: Array) -> None:
        """Be in a posture after a tick, (joints,)."""
        self._robot.drive(joints, self._plant.steps_per_tick)

    def press(self, loop: ForceLoop) -> None:
        """Move under force control at each step of the physics, until another command."""
        self._robot.drive_by(loop.step)


class SimulatedGripper(_PartOfRobot):
    """The fingers of a robot in the plant."""

    @property
    def gap(self) -> float:
        """The measured distance between the pads [m]."""
        return self._robot.finger_gap

    @property
    def load(self) -> float:
        """The measured closing force of the weaker finger [N]."""
        return self._robot.finger_load

    def open_to(self, opening: float) -> None:
        """Send each finger to a distance from the middle [m]."""
        self._robot.drive_fingers(opening)

    def close_on(self, thickness: float, slow_before: float) -> None:
        """Close until the fingers stop on what they grip, about so thick, slowly before it [m]."""
        self._robot.drive_fingers(0.0, max(TOUCH_GAP, thickness + slow_before))


@dataclass(frozen=True)
class SimulatedCamera:
    """A camera of the plant, by what it sees from and what it sees."""

    see_from: Callable[[], View]
    see: Callable[[], Picture]

    @property
    def view(self) -> View:
        """Where it is now."""
        return self.see_from()

    def take(self) -> Picture:
        """Take a picture."""
        return self.see()
