#!/usr/bin/env python3
"""What a cell publishes of an arm on a linear axis: its joint, and the frames of rail and base."""

import sys
import unittest

import rospy
import rostest
import tf2_ros
from sensor_msgs.msg import JointState

WAIT_S = 60.0
HOME_M = -0.73  # of the axis, when the hand is at home
BASE_X_M = -0.04


class AxisTest(unittest.TestCase):
    def test_the_axis_is_a_joint_and_carries_the_frame_of_the_base(self):
        state = rospy.wait_for_message("/joint_states", JointState, WAIT_S)
        joints = dict(zip(state.name, state.position, strict=True))
        self.assertEqual(state.name[:2], ["axis", "panda_joint1"])
        self.assertEqual(len(joints), 10)
        self.assertAlmostEqual(joints["axis"], HOME_M, delta=0.02)
        buffer = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(buffer)
        for frame, y in (("axis_rail", 0.0), ("panda_link0", joints["axis"])):
            place = buffer.lookup_transform("world", frame, rospy.Time(0), rospy.Duration(WAIT_S))
            at = place.transform.translation
            self.assertAlmostEqual(at.x, BASE_X_M, delta=1e-3)
            self.assertAlmostEqual(at.y, y, delta=1e-3)
            self.assertAlmostEqual(at.z, 0.0, delta=1e-3)
        listener.unregister()


if __name__ == "__main__":
    rospy.init_node("test_axis")
    rostest.rosrun("remodel_sim", "test_axis", AxisTest, sys.argv)
