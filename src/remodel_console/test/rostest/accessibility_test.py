#!/usr/bin/env python3
"""All pages, in both themes and on a phone, keep axe-core's rules; in a real browser."""

import sys
from pathlib import Path

import rospy
import rostest
from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from behavior_test_case import BehaviorTestCase
from fake_supervisor import FakeCameras, FakeRecords, FakeSupervisor

AXE = Path(__file__).parents[1] / "axe" / "axe.min.js"
RUN = """async () => (await axe.run(document, { resultTypes: ['violations'] })).violations.flatMap(
  (rule) => rule.nodes.map((node) => `${rule.id}: ${node.target.join(' ')}: `
    + (node.any[0] ?? node.all[0] ?? node.none[0])?.message))"""
OVERFLOW = "() => document.documentElement.scrollWidth - document.documentElement.clientWidth"
# Address, and what is shown once the page has all its contents.
PAGES = {
    "/overview": "tr.task",
    "/runtime": "li.node",
    "/editor": "li.node",
    "/replay?run=12": ".clock",
    "/statistics": ".statistics td",
    "/configuration": ".matter",
}


class AccessibilityTest(BehaviorTestCase):
    first_page = "/runtime"

    def setUp(self):
        super().setUp()
        self.supervisor, self.cameras, self.records = FakeSupervisor(), FakeCameras(), FakeRecords()
        self.choose(self.page, "Behavior", "Errand")
        expect(self.page.locator("li.node").first).to_be_visible()
        self.supervisor.run("cabinet 7")

    def test_no_rule_is_broken_in_light_dark_and_on_a_phone(self):
        broken = []
        for address, shown in PAGES.items():
            page = self.open_page(address)
            if address == "/editor":
                self.choose(page, "Open", "Errand")
            elif address == "/runtime":
                self.pick_drawn(page, "Report")
                self.press(page, "Breakpoint")
                expect(page.locator(".state-hint")).to_be_visible()
            elif address.startswith("/replay"):
                self.choose(page, "Compare with", "13  cabinet 7")
                expect(page.locator(".compare-table tr.first")).to_be_visible()
            broken += self.broken(page, address, shown, "light")
            page.get_by_role("button", name="Dark or light").click()
            broken += self.broken(page, address, "body.body--dark", "dark")
            page.set_viewport_size({"width": 390, "height": 844})
            broken += self.broken(page, address, "body", "phone")
            if page.evaluate(OVERFLOW) > 0:
                broken.append(f"{address}: wider than a phone by {page.evaluate(OVERFLOW)} pixels")
        self.supervisor.ask()
        page = self.open_page("/overview")
        broken += self.broken(page, "question", ".request", "light")
        self.press(page, "Dark or light")
        broken += self.broken(page, "question", "body.body--dark", "dark")
        self.press(page, "Keys (?)")
        broken += self.broken(page, "keys", ".q-dialog dl.keys", "dark")
        self.assertEqual([], broken, "\n".join(broken))

    def broken(self, page, where, shown, theme):
        """Return the rules that a page breaks, each with its element."""
        expect(page.locator(shown).first).to_be_attached()
        expect(page.locator(".presence.there", has_text="ROS")).to_be_attached()
        page.wait_for_function(
            "() => document.getAnimations().every((one) => one.playState !== 'running')"
        )
        self.take_picture(page, f"axe-{where.strip('/').partition('?')[0]}-{theme}")
        page.evaluate(AXE.read_text())
        return [f"{where} ({theme}): {one}" for one in page.evaluate(RUN)]


if __name__ == "__main__":
    rospy.init_node("test_accessibility")
    rostest.rosrun("remodel_console", "test_accessibility", AccessibilityTest)
