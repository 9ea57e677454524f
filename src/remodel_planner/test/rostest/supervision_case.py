"""What the tests of killed processes share: an order over a fake cell, faults and questions."""

import shutil
import sys
import unittest
from pathlib import Path

import rospy
from order_client import LIMIT_S, OrderClient, import_order, planner, wait_until
from remodel_msgs.msg import UseCaseState
from remodel_msgs.srv import AnswerQuestion, InjectFault

OUTPUT = Path(sys.argv[1])


def call(name, kind, **request):
    """Call a service of the supervisor."""
    rospy.wait_for_service(f"remodel/use_case/{name}", LIMIT_S)
    return rospy.ServiceProxy(f"remodel/use_case/{name}", kind)(**request)


class SupervisionCase(unittest.TestCase):
    """Runs tasks of an order, in a cell whose faults an operator is asked about."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_supervision")
        OUTPUT.mkdir(exist_ok=True)
        cls.addClassCleanup(shutil.rmtree, OUTPUT, ignore_errors=True)
        import_order(f"sqlite:///{OUTPUT}/production.sqlite")
        cls.orders = OrderClient(OUTPUT)

    def planner(self, *line):
        """Run a command of the planner to its end."""
        return planner(*line, database=self.orders.database)

    def inject(self, kind):
        """Cause a fault that an operator is asked about, once the panel is loaded."""
        wait_until(lambda: self.orders.state.task, "a task is under way")
        rospy.wait_for_service("cell/inject_fault", LIMIT_S)
        caused = rospy.ServiceProxy("cell/inject_fault", InjectFault)(kind, "ask_operator", [])
        self.assertTrue(caused.success, caused.message)

    def asked(self):
        """Return the question that an operator is asked."""
        self.orders.wait_for_phase(UseCaseState.ASKING)
        return self.orders.state.question

    def answer(self, question, choice):
        given = call("answer", AnswerQuestion, question=question.number, choice=choice, by="ann")
        self.assertTrue(given.success, given.message)
