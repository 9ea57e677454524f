#!/usr/bin/env python3
"""A cell needs three services; its abilities may be served by several nodes, each by one."""

import unittest

import rosgraph
import rospy
import rostest

from remodel_planner.commands.runs.order_report import wires_in_cell
from remodel_production.core.production import Order
from remodel_states.edge.exported_tables import read_abilities
from remodel_supervision.ros.peers.cell import Cell

LIMIT_S = 60.0


def servers():
    """Map the topic of each ability to the nodes that serve it."""
    _, subscribers, _ = rosgraph.Master("/test").getSystemState()
    found = {topic: nodes for topic, nodes in subscribers if topic.endswith("/goal")}
    return {topic.split("/")[-2]: nodes for topic, nodes in found.items()}


class CellServicesTest(unittest.TestCase):
    """Against the fake cell, which has no ground truth here."""

    def test_a_cell_needs_no_ground_truth(self):
        cell = Cell()
        cell.wait(LIMIT_S)
        self.assertIsNone(cell.placed("W1"))

    def test_the_report_says_that_a_cell_without_ground_truth_is_not_read_back(self):
        Cell().wait(LIMIT_S)
        found, unread = wires_in_cell(Order("house", "", "", (), wires=()))
        self.assertEqual(found, {})
        self.assertIn("the cell gave no ground truth, as no real cell does", unread)

    def test_each_ability_is_served_by_one_node(self):
        names = {name.lower() for name in read_abilities()}
        while set(servers()) < names and not rospy.is_shutdown():  # the time limit ends it
            rospy.rostime.wallsleep(0.1)
        found = servers()
        self.assertEqual(found.pop("insertcable"), ["/own_robot"])
        self.assertEqual(found, {name: ["/cell"] for name in names - {"insertcable"}})


if __name__ == "__main__":
    rospy.init_node("test_cell_services")
    rostest.rosrun("remodel_planner", "cell_services", CellServicesTest)
