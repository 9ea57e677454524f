#!/usr/bin/env python3
"""Each shipped use case, wires that are discarded and begun again, and orders that are refused."""

import rospy
import rostest
import yaml
from order_client import OrderClient, planner
from use_cases_case import DATABASE, DESIGNS, OUTPUT, SHIPPED, UseCasesCase

from remodel_supervision.core.runs.events import Ending
from remodel_tasks.edge.use_case_files import use_case_folder


def far(own):
    """Have a use case name a robot that the cell does not have."""
    own.update(yaml.safe_load(yaml.safe_dump(own).replace("robot_2", "robot_8")))


class UseCasesShippedTest(UseCasesCase):
    def test_each_shipped_use_case_is_tried(self):
        shipped = {file.stem for file in use_case_folder().glob("*.yaml")}
        self.assertEqual(shipped, {*SHIPPED, "branched_harness"})

    def places_a_new_wire(self, order, **fault):
        """Have a fault strike one piece of a wire of an order; return what is printed."""
        self.add_order(order)
        rospy.set_param("fake_cell/faults", [{"cure": "new_part", **fault}])
        self.addCleanup(rospy.delete_param, "fake_cell/faults")
        ran = planner(*self.line(order, "cabinet", 2), database=DATABASE)
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        self.assertIn("2 of 2 wires placed, 1 without a failed operation", ran.stdout)
        self.assertIn("  discarded, 0 insertions, ", ran.stdout)
        self.assertIn(">discarded<", (OUTPUT / f"{order}/report.html").read_text())
        return ran.stdout

    def test_two_robots_release_discard_and_begin_again_with_a_new_wire(self):
        self.places_a_new_wire("slipping", name="slipped")
        orders = OrderClient(OUTPUT)
        self.assertEqual(orders.held, "")
        self.assertEqual(len(orders.account(orders.runs()[0]).fed_again), 1)

    def test_a_wire_that_left_its_ducts_once_both_ends_are_fixed_is_discarded(self):
        fault = {"name": "out_of_duct", "ability": "FixCable", "nth": 2}
        printed = self.places_a_new_wire("lifted", **fault)
        self.assertIn("FixCable, error 310: ", printed)
        self.assertIn("; 1 failed operation; ", printed, "the end is not pushed in again")

    def test_a_wire_whose_first_end_came_out_is_discarded(self):
        fault = {"name": "came_out", "ability": "FixCable", "nth": 2}
        printed = self.places_a_new_wire("drawn", **fault)
        self.assertIn("FixCable, error 311: ", printed)
        self.assertIn("; 1 failed operation; ", printed, "no end is pushed in again")

    def test_harness_formboard_carries_its_order_out(self):
        self.carries_its_order_out("harness_formboard")

    def test_harnesses_whose_connectors_stand_at_several_distances_are_carried_out(self):
        for name, wires in (("seat", 6), ("lamp", 12)):
            self.carries_out(name, "harness_formboard", DESIGNS / f"{name}.yml", wires)

    def test_automotive_formboard_carries_its_order_out(self):
        self.carries_its_order_out("automotive_formboard")

    def test_medical_hoses_carries_its_order_out(self):
        self.carries_its_order_out("medical_hoses")

    def test_an_order_that_the_cell_refuses_leaves_its_panel_alone_and_can_be_run_later(self):
        self.add_own("far", far)
        for name in ("first", "second"):
            self.add_order(name)
        done = planner(*self.line("first", "cabinet", 2), database=DATABASE)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        orders = OrderClient(OUTPUT)
        before = orders.world.read().world
        refused = planner(*self.line("second", "far", 2), database=DATABASE)
        self.assertEqual(refused.returncode, 3, refused.stdout + refused.stderr)
        self.assertIn("name robot 'robot_8'; the cell has robot_1, robot_2", refused.stderr)
        self.assertIn("Nothing has moved. Correct the design or use case far", refused.stderr)
        self.assertEqual(orders.world.read().world, before)
        self.assertEqual(orders.run_state(orders.runs()[0]).ended.ending, Ending.STOPPED)
        later = planner(*self.line("second", "cabinet", 2), database=DATABASE)
        self.assertEqual(later.returncode, 0, later.stdout + later.stderr)
        self.assertIn("product second-0001: 2 tasks", later.stdout)
        self.assertIn("2 without a failed operation", later.stdout)

    def test_cabinet_carries_its_order_out(self):
        self.carries_its_order_out("cabinet")


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_use_cases_shipped", UseCasesShippedTest)
