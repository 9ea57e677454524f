#!/usr/bin/env python3
"""An order is prepared at the console's order desk, and the supervisor carries it out."""

import http.client
import re

import rospy
import rostest
from order_client import OrderClient
from order_desk_case import OUTPUT, WORK_MS, OrderDeskCase
from playwright.sync_api import expect
from remodel_msgs.msg import UseCaseState

from remodel_supervision.core.runs.events import TaskBegun

CABLE = """Wire,Cable,Core,From,To,Section mm2,Colour,Length mm
,C1,1,K1:1,X1:1,1,BU,600
W1,,,K1:2,X1:2,1,BK,600
,C1,2,K1:3,X1:3,1,BN,600
"""


class OrderDeskTest(OrderDeskCase):
    def test_the_cores_of_a_cable_are_one_task_until_they_are_placed(self):
        page = self.page
        self.drop("cable.csv", CABLE)
        area = page.locator(".desk-area")
        expect(area.locator(".count", has_text="robot")).to_contain_text("2")
        expect(area.locator(".count", has_text="a cable of 2 cores")).to_contain_text("1")
        fits = "Cell two_arms_cabinet: 3 wires for robots, 0 by hand; the board fits"
        expect(area).to_contain_text(fits)
        expect(area.locator(".plan-words")).to_contain_text("2 tasks in")
        page.get_by_text("Tasks in their order").click()
        planned = self.planned()
        cores = [f"C1: {both}" for both in ("C1.1, C1.2", "C1.2, C1.1")]
        self.assertIn(sorted(planned), [sorted([each, "W1"]) for each in cores])
        self.take_picture(page, "cable-plan")
        page.get_by_label("Name of the order").fill("cable")
        self.press(page, "Start the order")
        page.wait_for_url("**/overview", timeout=WORK_MS)
        expect(page.locator(".ending")).to_contain_text("Order 'cable'", timeout=WORK_MS)
        now = rospy.wait_for_message("remodel/use_case/state", UseCaseState, timeout=180)
        self.assertEqual((now.sums.tasks, now.sums.done), (2, 2))
        cable = page.locator(".tasks tr.cable")
        expect(cable).to_contain_text("cable, 2 of 2 cores done")
        below = [cable.locator(f"xpath=following-sibling::tr[{place}]") for place in (1, 2)]
        for row in below:
            expect(row).to_have_class(re.compile(r"\bcore\b"))
        self.assertEqual(
            {core for row in below for core in ("C1.1", "C1.2") if core in row.inner_text()},
            {"C1.1", "C1.2"},
        )
        self.assertEqual(page.locator(".tasks tr.core").count(), 2)
        self.take_picture(page, "cable")
        orders = OrderClient(OUTPUT)
        events = orders.events(max(orders.runs()))
        begun = [each.task for each in events if isinstance(each, TaskBegun)]
        self.assertEqual(abs(begun.index("C1.2") - begun.index("C1.1")), 1)
        self.assertEqual(len(orders.run_state(max(orders.runs())).whole_tasks), 2)

    def test_what_is_no_design_is_refused(self):
        self.drop("bomb.qet", '<!DOCTYPE a [<!ENTITY b "c">]><project>&b;</project>')
        expect(self.page.locator(".desk-area .ending.bad")).to_contain_text("DOCTYPE")
        drafts = self.page.locator(".draft").count()
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=180)
        body = bytes(100_000_001)
        connection.request("POST", "/order_desk/file?name=huge.csv", body)
        answer = connection.getresponse()
        self.assertEqual(answer.status, 413)
        self.assertIn("huge.csv: is larger than 100 MB", answer.read().decode())
        connection.request(
            "POST", "/order_desk/file?name=..%2F..%2Fa.csv", b"x", {"Origin": "http://evil"}
        )
        self.assertEqual(connection.getresponse().status, 403)
        connection.close()
        self.page.reload()
        expect(self.page.locator(".draft")).to_have_count(drafts)


if __name__ == "__main__":
    rospy.init_node("test_order_desk")
    rostest.rosrun("remodel_planner", "test_order_desk", OrderDeskTest)
