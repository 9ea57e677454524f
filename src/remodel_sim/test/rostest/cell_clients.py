"""What the ROS tests of running cells share: clients of abilities and services."""

import subprocess
import time
import unittest

import actionlib
import rospy
from remodel_msgs import msg, srv
from std_srvs.srv import Trigger

WALL_LIMIT_S = 500.0
STOP_LIMIT_S = 0.2

# A goal of PlacePin for two arms.
PINS = dict(
    robot_1_name="robot_1",
    robot_2_name="robot_2",
    path_space=0.10,
    connector_space=0.512,
    centered=True,
    rotate=True,
    show_in_TF=True,
)


def wait_until(condition, limit_s=WALL_LIMIT_S):
    """Wait for a condition by the wall's clock; returns whether it came true."""
    end = time.monotonic() + limit_s
    while not condition():
        if time.monotonic() > end:
            return False
        time.sleep(0.005)
    return True


class Client:
    """Sends goals to one ability and waits by the wall's clock."""

    def __init__(self, name):
        self.name = name
        topic = f"remodel_abilities/{name.lower()}"
        self.client = actionlib.SimpleActionClient(topic, getattr(msg, f"{name}Action"))
        self.feedback = []
        self.sent = 0
        # Not the client's own, which drops feedback that the result has overtaken.
        kind = getattr(msg, f"{name}ActionFeedback")
        rospy.Subscriber(f"{topic}/feedback", kind, self._on_feedback)
        assert wait_until(lambda: self.client.wait_for_server(rospy.Duration(0.1)))

    def send(self, **fields):
        self.sent += 1
        goal = getattr(msg, f"{self.name}Goal")(id=self.goal_id, timeout=120.0)
        for key, value in fields.items():
            setattr(goal, key, value)
        self.feedback = []
        self.client.send_goal(goal)

    @property
    def goal_id(self):
        return f"test-{self.name}-{self.sent}"

    def _on_feedback(self, message):
        if message.feedback.id == self.goal_id:
            self.feedback.append(message.feedback)

    def whole_progress(self):
        """Return the percentages of a goal that succeeded, up to the last one."""

        def shares():
            return [each.completed_percentage for each in self.feedback]

        assert wait_until(lambda: 100.0 in shares()), shares()
        return shares()

    def ended(self):
        # The goal's status may arrive before its result; this is when the result is there.
        return self.client.simple_state == actionlib.SimpleGoalState.DONE

    def wait(self):
        assert wait_until(self.ended), f"{self.name} did not end"
        return self.client.get_result()

    def do(self, **fields):
        self.send(**fields)
        return self.wait()


def call(name, service_class, /, **fields):
    """Call a service of the cell; return its response, which must not report a failure."""
    rospy.wait_for_service(f"cell/{name}", WALL_LIMIT_S)
    response = rospy.ServiceProxy(f"cell/{name}", service_class)(**fields)
    assert getattr(response, "success", True), response
    return response


class CellTestCase(unittest.TestCase):
    """Begins each test with wire W1 fed to an otherwise empty panel.

    Attributes:
        abilities: names of those that the tests use.
        on: their clients by name.
    """

    abilities = ()

    @classmethod
    def setUpClass(cls):
        cls.on = {name: Client(name) for name in cls.abilities}

    def setUp(self):
        call("reset", Trigger)
        call("feed_wire", srv.FeedWire, wire_id="W1", channel_id="A")

    def check_conformance(self, ability, goal):
        """Check a server against the contract of all abilities; return what was reported."""
        topic = f"remodel_abilities/{ability.lower()}"
        line = ["rosrun", "remodel_states", "conformance", topic, ability, "--goal", goal]
        done = subprocess.run(line, capture_output=True, text=True, timeout=WALL_LIMIT_S)
        report = done.stdout + done.stderr
        self.assertEqual(done.returncode, 0, report)
        return report


class OneWireCase(CellTestCase):
    """Works on end a of wire W1 at terminal X1/1."""

    def locate(self, component="X1", terminal="1"):
        result = self.on["LocateGearboxComponent"].do(component_id=component, terminal_id=terminal)
        self.assertTrue(result.success, result.error_message)
        return result.socket_pose

    def insertion(self, socket):
        return dict(
            robot_name="robot_1",
            cable_id="W1",
            cable_end="a",
            component_id="X1",
            terminal_id="1",
            socket_pose=socket,
            force_limit=8.0,
        )

    def at_terminal(self):
        return dict(robot_name="robot_1", cable_id="W1", component_id="X1", terminal_id="1")
