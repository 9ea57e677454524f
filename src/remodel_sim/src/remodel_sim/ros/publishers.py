"""What the cell publishes: states, pictures of films, and markers."""

from __future__ import annotations

import time

import numpy as np
import rospy
from geometry_msgs.msg import Point, Quaternion, Vector3, WrenchStamped
from geometry_msgs.msg import Pose as PoseMsg
from sensor_msgs.msg import JointState
from std_msgs.msg import ColorRGBA
from tf2_ros import TransformBroadcaster
from visualization_msgs.msg import Marker, MarkerArray

from remodel_sim.core.faults import FilmError
from remodel_sim.edge.film import Film
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.ros.sim_clock import SimClock
from remodel_states.core.wires import Rgb, rgbs_of
from remodel_vision.ros.image_message import FixedFrames, optical_frame, transform
from remodel_work.cell.cell_design import RobotDesign
from remodel_work.component_shape import HOUSING
from remodel_work.edge.robot_description import HAND, RAIL, foot_link, robot_description
from remodel_work.geometry import PANEL, WORLD, Pose
from remodel_work.panel import Component, PanelWire
from remodel_work.robot.arm import Kinematics
from remodel_work.robot.fingers import CAMERA_MOUNT

# Between two pictures [s of simulated time]; the film shows ten a second, so it runs at four times
# the cell's pace.
FILM_PERIOD_S = 0.4


class Filming:
    """Takes the pictures; a cancel waits for one at most, some 0.1 s."""

    def __init__(self, plant: SimulatedPlant, clock: SimClock, film: Film, camera: str) -> None:
        """Film with a camera of the cell."""
        self._plant = plant
        self._clock = clock
        self._film = film
        self._camera = camera
        self._taken_s = 0.0
        self._stopped = False

    def __call__(self) -> None:
        """Take a picture when it is time."""
        if self._stopped or self._clock.now_s - self._taken_s < FILM_PERIOD_S:
            return
        self._taken_s = self._clock.now_s
        try:
            self._film.add(self._plant.film(self._camera))
        except FilmError as error:
            rospy.logerr("%s; no more pictures are taken", error)
            self._stopped = True

    def close(self) -> None:
        """End the film."""
        try:
            self._film.close()
        except FilmError as error:
            rospy.logerr("%s", error)


# [s] How often the wire under way is published, by the clock of the people who watch: a cell that
# is faster than that must not be slowed down by showing more than they can see.
MARKERS_PERIOD_S = 0.05
# [s] of simulated time: how often everything is published at least.
WHOLE_PERIOD_S = 1.0


class Markers:
    """Publishes components as boxes and wires as lines."""

    def __init__(self, plant: SimulatedPlant, clock: SimClock) -> None:
        """Advertise the topic."""
        self._plant = plant
        self._clock = clock
        self._published_s = self._whole_s = 0.0
        self._shown: object = None
        self._publisher = rospy.Publisher("cell/markers", MarkerArray, queue_size=2)

    def __call__(self) -> None:
        """Publish when it is time and there is a subscriber."""
        wall_s = time.monotonic()
        if wall_s - self._published_s < MARKERS_PERIOD_S:
            return
        self._published_s = wall_s
        viewers = self._publisher.get_num_connections()
        if not viewers:
            return
        plant = self._plant
        live = plant.live.wire.id if plant.live else ""
        shown = (viewers, live, id(plant.panel), frozenset(plant.parked))
        if shown == self._shown and self._clock.now_s - self._whole_s < WHOLE_PERIOD_S:
            if plant.live is not None:
                line = self._line(plant.live.wire, plant.live.cable.nodes())
                self._publisher.publish(MarkerArray([line]))
            return
        self._shown, self._whole_s = shown, self._clock.now_s
        markers = [Marker(action=Marker.DELETEALL)]
        markers += [self._box(component) for component in plant.panel.components]
        markers += [
            self._line(plant.panel.wire(wire_id), parked.nodes)
            for wire_id, parked in plant.parked.items()
        ]
        if plant.live is not None:
            markers.append(self._line(plant.live.wire, plant.live.cable.nodes()))
        self._publisher.publish(MarkerArray(markers))

    def _marker(self, namespace: str, name: str, kind: int, rgb: Rgb) -> Marker:
        marker = Marker(ns=f"{namespace}/{name}", type=kind, action=Marker.ADD)
        marker.header.frame_id, marker.header.stamp = WORLD, self._clock.now
        marker.pose.orientation.w = 1.0
        marker.color = ColorRGBA(*rgb, 1.0)
        return marker

    def _box(self, component: Component) -> Marker:
        marker = self._marker("component", component.id, Marker.CUBE, HOUSING)
        pose = self._plant.world_from_component(component.id)
        x, y, z = pose.position
        marker.pose = PoseMsg(Point(x, y, z + component.size[2] / 2), Quaternion(*pose.quaternion))
        marker.scale = Vector3(*component.size)
        return marker

    def _line(self, wire: PanelWire, nodes: np.ndarray) -> Marker:
        marker = self._marker("wire", wire.id, Marker.LINE_STRIP, rgbs_of(wire.colour)[0])
        marker.scale.x = wire.diameter
        marker.points = [Point(*node) for node in nodes]
        return marker


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
