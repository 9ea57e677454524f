"""What the tests of Place Connector share: the behavior on the engine, in the physical cell."""

import threading
import time
import unittest

import actionlib
import rospy
from flexbe_msgs.msg import BehaviorExecutionAction, BehaviorExecutionGoal
from remodel_msgs.msg import AbilityRecord
from remodel_msgs.srv import FeedWire, GetGroundTruth, InjectFault
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

WALL_LIMIT_S = 500.0
COMPONENT, TERMINAL, WIRE, CHANNEL = "X1", "1", "W1", "A"


class PlaceConnectorCase(unittest.TestCase):
    """Begins each test with one wire fed to an empty panel."""

    @classmethod
    def setUpClass(cls):
        cls.client = actionlib.SimpleActionClient(
            "flexbe/execute_behavior", BehaviorExecutionAction
        )
        cls.reset = rospy.ServiceProxy("cell/reset", Trigger)
        cls.feed = rospy.ServiceProxy("cell/feed_wire", FeedWire)
        cls.inject = rospy.ServiceProxy("cell/inject_fault", InjectFault)
        cls.truth = rospy.ServiceProxy("cell/ground_truth", GetGroundTruth)
        cls.reset.wait_for_service()
        cls.preempt = rospy.Publisher("/flexbe/commands/preempt", Empty, queue_size=1)
        assert cls.client.wait_for_server(rospy.Duration(180))

    def setUp(self):
        self.records = []
        self.on_record = None
        self.subscriber = rospy.Subscriber("remodel/ability_records", AbilityRecord, self._record)
        self.assertTrue(self.reset().success)
        response = self.feed(wire_id=WIRE, channel_id=CHANNEL)
        self.assertTrue(response.success, response.message)

    def tearDown(self):
        self.subscriber.unregister()

    def _record(self, record):
        self.records.append(record)
        if self.on_record:
            self.on_record(record)

    def start(self):
        self.done = threading.Event()
        self.client.send_goal(
            BehaviorExecutionGoal(behavior_name="Place Connector"),
            done_cb=lambda *_: self.done.set(),
        )

    def finish(self):
        self.assertTrue(self.done.wait(WALL_LIMIT_S), "the behavior did not end")
        return self.client.get_result().outcome

    def assert_abilities(self, *expected):
        """Check the records (ability, outcome); the last may arrive after the behavior's end."""
        limit = time.monotonic() + WALL_LIMIT_S
        while len(self.records) < len(expected) and time.monotonic() < limit:
            time.sleep(0.01)
        found = [(record.ability, record.outcome) for record in self.records]
        self.assertEqual(found, list(expected))

    def a_is_placed(self):
        (truth,) = [truth for truth in self.truth().wires if truth.wire_id == WIRE]
        return truth.a_at == f"{COMPONENT}/{TERMINAL}" and truth.a_fixed
