"""What the cell publishes for people, without physics: a robot, its joints and wires."""

import math
import threading

import rospy
from geometry_msgs.msg import Point, Pose, Quaternion, TransformStamped, Vector3
from sensor_msgs.msg import JointState
from std_msgs.msg import ColorRGBA
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from remodel_work.edge.robot_description import robot_description
from remodel_work.robot.arm import PANDA_AT_ORIGIN

PERIOD_S = 0.05
# How a page shows the cell: eight links and the hand; the fingers are boxes.
MESHES = 9
MIDDLE_OF_W4 = "() => document.querySelector('.cell-view').screenPointOf('W4')"
POSTURE = (0.0, 0.3, 0.0, -2.0, 0.0, 2.3, 0.8)


class FakeCell:
    """Moves the first joint and the wire W4 20 times a second; W1 lies still."""

    def __init__(self):
        """Begin to publish."""
        robot = {"description": robot_description(PANDA_AT_ORIGIN), "prefix": ""}
        rospy.set_param("cell/robots", {"robot_1": robot})
        base = TransformStamped(child_frame_id="panda_link0")
        base.header.frame_id = "world"
        base.transform.rotation.w = 1.0
        self._frames = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        self._frames.publish(TFMessage([base]))
        self.joints = rospy.Publisher("/joint_states", JointState, queue_size=1)
        self.markers = rospy.Publisher("cell/markers", MarkerArray, queue_size=1)
        self._end = threading.Event()
        threading.Thread(target=self._run, daemon=True).start()

    def close(self):
        """Publish no more, and be gone."""
        self._end.set()
        rospy.delete_param("cell/robots")
        for publisher in (self._frames, self.joints, self.markers):
            publisher.unregister()

    @property
    def is_followed(self):
        """Return whether a page makes the cell send anything."""
        return self.markers.get_num_connections() > 0 or self.joints.get_num_connections() > 0

    def _run(self):
        time_s = 0.0
        while not self._end.wait(PERIOD_S):
            time_s += PERIOD_S
            names = [f"panda_joint{number}" for number in range(1, 8)]
            angles = [0.5 * math.sin(time_s), *POSTURE[1:]]
            self.joints.publish(JointState(name=names, position=angles))
            box = marker("component/X1", Marker.CUBE, (0.9, 0.9, 0.9), Vector3(0.1, 0.2, 0.05))
            box.pose = Pose(Point(0.5, 0.2, 0.025), Quaternion(w=1.0))
            lying = wire("W1", (0.8, 0.1, 0.1), 0.0)
            moving = wire("W4", (0.1, 0.2, 0.9), 0.05 + 0.02 * math.sin(3 * time_s))
            self.markers.publish(MarkerArray([box, lying, moving]))


def marker(name, kind, rgb, scale):
    return Marker(ns=name, type=kind, action=Marker.ADD, color=ColorRGBA(*rgb, 1.0), scale=scale)


def wire(name, rgb, bend):
    made = marker(f"wire/{name}", Marker.LINE_STRIP, rgb, Vector3(x=0.003))
    y = -0.15 if name == "W1" else 0.0
    made.points = [
        Point(0.35 + 0.02 * step, y, 0.01 + bend * math.sin(math.pi * step / 20))
        for step in range(21)
    ]
    return made
