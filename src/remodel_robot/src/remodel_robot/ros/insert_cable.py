"""InsertCable by a Cartesian impedance controller: franka_ros', or one of ros_control.

The equilibrium pose moves into the opening, and the push ends at the force limit. The end is in
the gripper already. `rosrun remodel_robot insert_cable --help` lists the parameters.
"""

from __future__ import annotations

import copy
import time
from dataclasses import fields

import rospy
from geometry_msgs.msg import PoseStamped, WrenchStamped
from remodel_msgs.msg import ErrorCode, InsertCableGoal
from tf.transformations import quaternion_matrix

from remodel_robot.core.push import Push, PushRules
from remodel_states.ability_server import AbilityServer, Done
from remodel_states.core.ability_error import AbilityError
from remodel_states.core.codes import Code
from remodel_states.serving.running_goal import RunningGoal

# [s] ROS time between two poses.
PERIOD_S = 0.02

WRENCH = "franka_state_controller/F_ext"
EQUILIBRIUM_POSE = "cartesian_impedance_example_controller/equilibrium_pose"

REMEDIES = {
    Code.INSERTION_MISALIGNED: "the tip met the face; extract, locate again, insert again",
    Code.INSERTION_JAMMED: "the end is stuck in the opening; extract it",
    Code.INSERTION_NO_CONTACT: "nothing was met; check that the gripper holds the end",
}


class InsertCable(AbilityServer):
    """Serves InsertCable."""

    def __init__(self) -> None:
        """Connect to the controller, and start to serve.

        Raises:
            ValueError: if a parameter is out of range.
        """
        names = [each.name for each in fields(PushRules)]
        given = {name: rospy.get_param(f"~{name}") for name in names if rospy.has_param(f"~{name}")}
        self._rules = PushRules(**given)
        self._axis = rospy.get_param("~axis", "z")
        if self._axis not in ("x", "y", "z"):
            raise ValueError(f"axis is {self._axis!r}; allowed: x, y, z")
        self._tip_m = rospy.get_param("~tip_m", 0.20)
        self._silent_s = rospy.get_param("~silent_s", 0.25)
        self._heard_s = float("-inf")
        self._force_n = 0.0
        self._pose = rospy.Publisher(
            rospy.get_param("~equilibrium_pose", EQUILIBRIUM_POSE), PoseStamped, queue_size=1
        )
        wrench = rospy.get_param("~wrench", WRENCH)
        self._wrench = rospy.Subscriber(wrench, WrenchStamped, self._on_wrench, tcp_nodelay=True)
        super().__init__()  # last: from here on goals arrive

    def check(self, goal: InsertCableGoal) -> None:
        """Refuse a goal without a force limit, or while the arm is silent."""
        if not goal.force_limit > 0.0:
            raise AbilityError(
                ErrorCode.INVALID_GOAL, f"force_limit is {goal.force_limit:g}; allowed: above 0 N"
            )
        self._require_wrench("start the controllers")

    def perform(self, running: RunningGoal) -> Done:
        """Push, and hold where the push ended."""
        goal, begun_s = running.goal, time.monotonic()
        push = Push(self._rules, goal.force_limit)
        while self._heard_s < begun_s:  # a force that was measured before says nothing
            self._require_wrench("nothing has moved")
            running.wait(PERIOD_S)
        try:
            while not push.has_ended:
                self._require_wrench("the push has stopped")
                push.advance(PERIOD_S, self._force_n)
                self._publish(goal.socket_pose, push.depth_m)
                running.report("pushing", push.percentage)
                running.wait(PERIOD_S)  # raises when cancelled or out of time
        finally:
            self._publish(goal.socket_pose, push.depth_m)  # hold
        found = {"depth": push.depth_m, "peak_force": push.peak_n}
        if push.problem is not Code.NONE:
            raise AbilityError(push.problem, f"{push}: {REMEDIES[push.problem]}", found)
        return Done(f"seated: {push}", found)

    def _publish(self, opening: PoseStamped, depth_m: float) -> None:
        self._pose.publish(flange_pose(opening, depth_m - self._tip_m))

    def _require_wrench(self, advice: str) -> None:
        silent_s = time.monotonic() - self._heard_s
        if silent_s > self._silent_s:
            since = f"for {silent_s:.1f} s" if silent_s < float("inf") else "yet"
            text = f"no wrench on {self._wrench.resolved_name} {since}; {advice}"
            raise AbilityError(ErrorCode.MOTION_FAULT, text)

    def _on_wrench(self, message: WrenchStamped) -> None:
        self._force_n = getattr(message.wrench.force, self._axis)
        self._heard_s = time.monotonic()


def flange_pose(opening: PoseStamped, ahead_m: float) -> PoseStamped:
    """Return the opening's pose, moved along its x axis, which points into it [m]."""
    pose, q = copy.deepcopy(opening), opening.pose.orientation
    x, y, z = quaternion_matrix([q.x, q.y, q.z, q.w])[:3, 0] * ahead_m
    pose.pose.position.x += x
    pose.pose.position.y += y
    pose.pose.position.z += z
    return pose
