"""How long arms go on moving after a server took a cancel, by the stamps of its own messages.

A busy machine delays the messages between a test and the cell, which says nothing about the arm.
"""

import rospy
from actionlib_msgs.msg import GoalStatus, GoalStatusArray
from sensor_msgs.msg import JointState

STANDSTILL_RAD_S = 0.01


class StopWatch:
    """Follows one ability and the joints of all arms, from its making on."""

    def __init__(self, ability):
        self._cancelled_s = None
        self._speeds = []  # stamp [s], speed of the fastest joint [rad/s]
        self._subscribers = (
            rospy.Subscriber(
                f"remodel_abilities/{ability.lower()}/status", GoalStatusArray, self._on_status
            ),
            rospy.Subscriber("/joint_states", JointState, self._on_joints),
        )

    def took_s(self):
        """Return the ROS time [s] from the cancel to the standstill; None before that."""
        if self._cancelled_s is None:
            return None
        still = [
            at_s - self._cancelled_s
            for at_s, speed in tuple(self._speeds)
            if at_s >= self._cancelled_s and speed < STANDSTILL_RAD_S
        ]
        return still[0] if still else None

    def close(self):
        """Stop following."""
        for subscriber in self._subscribers:
            subscriber.unregister()

    def _on_status(self, message):
        is_cancelled = any(one.status == GoalStatus.PREEMPTING for one in message.status_list)
        if is_cancelled and self._cancelled_s is None:
            self._cancelled_s = message.header.stamp.to_sec()

    def _on_joints(self, message):
        joints = zip(message.name, message.velocity, strict=True)
        speed = max(abs(speed) for name, speed in joints if "panda_joint" in name)
        self._speeds.append((message.header.stamp.to_sec(), speed))
