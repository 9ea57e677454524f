"""What the simulated cell publishes of its robots: joint states, forces and frames."""

from __future__ import annotations

import numpy as np
import rospy
from geometry_msgs.msg import Vector3, WrenchStamped
from sensor_msgs.msg import JointState
from tf2_ros import TransformBroadcaster

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.ros.sim_clock import SimClock
from remodel_vision.ros.frames import FixedFrames, optical_frame, transform
from remodel_work.cell.cell_design import RobotDesign
from remodel_work.edge.robot_description import HAND, RAIL, foot_link, robot_description
from remodel_work.geometry import PANEL, WORLD, Pose
from remodel_work.robot.fingers import CAMERA_MOUNT
from remodel_work.robot.kinematics import Kinematics

# Joint states, forces and frames are published this often [s of simulated time].
STATE_PERIOD_S = 0.04


class RobotState:
    """Publishes joint states, the forces at the wrists, and frames."""

    def __init__(self, plant: SimulatedPlant, clock: SimClock, fixed: FixedFrames) -> None:
        """Publish the frames that never move, once."""
        self._plant = plant
        self._clock = clock
        self._published_s = 0.0
        robots = {robot.name: _described(robot) for robot in plant.design.robots}
        rospy.set_param("cell/robots", robots)
        self._joints = rospy.Publisher("/joint_states", JointState, queue_size=5)
        self._wrenches = {
            robot.name: rospy.Publisher(
                f"cell/{robot.camera.name}/wrench", WrenchStamped, queue_size=5
            )
            for robot in plant.design.robots
        }
        self._moving = TransformBroadcaster()
        above = zip(plant.design.overhead_names, plant.design.overheads, strict=True)
        fixed({optical_frame(name): view.world_from_camera for name, view in above})
        fixed({PANEL: plant.panel.world_from_panel})
        lens = Pose(np.array(CAMERA_MOUNT), np.array([0.0, 0.0, 0.0, 1.0]))
        for robot in plant.design.robots:
            fixed({robot.prefix + _foot(robot.arm): robot.arm.world_from_base})
            fixed({optical_frame(robot.camera.name): lens}, parent=robot.prefix + HAND)

    def __call__(self) -> None:
        """Publish when it is time."""
        if self._clock.now_s - self._published_s < STATE_PERIOD_S:
            return
        self._published_s = self._clock.now_s
        message = JointState()
        message.header.stamp = self._clock.now
        for design in self._plant.design.robots:
            robot, hand = self._plant.robots[design.name], design.prefix + HAND
            positions, velocities = robot.joint_state
            message.name += [design.prefix + name for name in robot.joint_names]
            message.position += positions
            message.velocity += velocities
            wrench = WrenchStamped()
            wrench.header.frame_id, wrench.header.stamp = hand, self._clock.now
            wrench.wrench.force = Vector3(*robot.wrist_force)
            self._wrenches[design.name].publish(wrench)
            moving = {hand: robot.world_from_hand}
            if design.arm.axis is not None:
                moving[design.prefix + foot_link(design.arm)] = robot.world_from_base
            self._moving.sendTransform(
                [transform(WORLD, frame, pose, self._clock.now) for frame, pose in moving.items()]
            )
        self._joints.publish(message)


def _described(robot: RobotDesign) -> dict[str, str]:
    """Return what a viewer draws a robot by: its URDF, and what precedes its names elsewhere."""
    return {"description": robot_description(robot.arm), "prefix": robot.prefix}


def _foot(arm: Kinematics) -> str:
    """Return the link of a robot that is bolted down."""
    return foot_link(arm) if arm.axis is None else RAIL
