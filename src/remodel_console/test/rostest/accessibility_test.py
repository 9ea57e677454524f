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

from remodel_console.core.access import Account, Role
from remodel_console.edge.users_file import hash_of, write_accounts
from remodel_console.testing.browser_test import free_port

LIST = b"Wire,From,To,Section mm2,Shelf\nW1,K1:1,X1:1,1,a\nW2,K1:2,X1:2,1,b\nW3,K1:3,X1:3,400,c\n"
CONTRADICTION = """format: remodel-preferences-1
require:
  - {name: up, route: W1, before: W2}
  - {name: down, route: W2, before: W1}
"""
AXE = Path(__file__).parents[1] / "axe" / "axe.min.js"
RUN = """async () => (await axe.run(document, { resultTypes: ['violations'] })).violations.flatMap(
  (rule) => rule.nodes.map((node) => `${rule.id}: ${node.target.join(' ')}: `
    + (node.any[0] ?? node.all[0] ?? node.none[0])?.message))"""
TAB_IS_IN_VIEW = """() => {
  const box = document.querySelector('.bar .tab.here').getBoundingClientRect();
  return box.left >= 0 && box.right <= innerWidth;
}"""
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
            broken += self.overflow(page, address)
            phone = self.open_page(address, width=390, height=844)
            phone.wait_for_function(TAB_IS_IN_VIEW)
            phone.close()
        broken += self.broken_on_the_order_desk()
        broken += self.broken_on_the_way_in()
        self.supervisor.ask()
        page = self.open_page("/overview")
        broken += self.broken(page, "question", ".request", "light")
        self.press(page, "Dark or light")
        broken += self.broken(page, "question", "body.body--dark", "dark")
        page.set_viewport_size({"width": 390, "height": 844})
        broken += self.broken(page, "question", ".show-page", "phone")
        broken += self.overflow(page, "question")
        page.set_viewport_size({"width": 1280, "height": 800})
        self.press(page, "Keys (?)")
        broken += self.broken(page, "keys", ".q-dialog dl.keys", "dark")
        self.assertEqual([], broken, "\n".join(broken))

    def broken_on_the_order_desk(self):
        """Look at an order with a plan, at one without, at a refused file, and at the dialogs."""
        broken, page = [], self.open_page("/order_desk")
        broken += self.broken(page, "empty desk", ".drop-zone", "light")
        file = page.locator(".drop-zone input")
        file.set_input_files({"name": "loom.csv", "mimeType": "", "buffer": LIST})
        broken += self.broken(page, "order_desk", ".plan-words", "light")
        self.press(page, "Edit all as YAML")
        page.get_by_role("dialog").get_by_label("YAML", exact=True).fill(CONTRADICTION)
        broken += self.broken(page, "preferences", ".q-dialog .yaml", "light")
        self.press(page.get_by_role("dialog"), "Save")
        self.press(page, "Plan again")
        expect(page.locator(".conflicting li")).to_have_count(2)
        self.press(page, "Dark or light")
        broken += self.broken(page, "conflict", "body.body--dark", "dark")
        self.press(page, "Add an entry")
        broken += self.broken(page, "entry", ".q-dialog .fields", "dark")
        self.press(page.get_by_role("dialog"), "Cancel")
        expect(page.get_by_role("dialog")).to_have_count(0)
        page.set_viewport_size({"width": 390, "height": 844})
        broken += self.broken(page, "conflict", "body", "phone")
        broken += self.overflow(page, "conflict")
        file.set_input_files({"name": "own.csv", "mimeType": "", "buffer": b"aaa;bbb\n1;2\n"})
        expect(page.locator(".draft.here")).to_contain_text("own.csv")
        broken += self.broken(page, "refused", ".desk-area .ending.bad", "dark")
        broken += self.overflow(page, "refused")
        return broken

    def broken_on_the_way_in(self):
        """Look at the page on which users sign in."""
        users, port = self.folder / "users.json", free_port()
        write_accounts(users, {"ann": Account(Role.OPERATOR, hash_of("drive horse"))})
        nowhere = f"http://127.0.0.1:{free_port()}"  # else its node would end the other console
        self.start_console_at("closed", port, "--users", str(users), ROS_MASTER_URI=nowhere)
        page = self.open_page("/overview", port=port)
        found = [f"sign in: {one}" for one in self.rules_broken(page)]
        page.emulate_media(color_scheme="dark")
        found += [f"sign in, dark: {one}" for one in self.rules_broken(page)]
        self.take_picture(page, "axe-sign-in-dark")
        self.end("closed")
        return found

    def overflow(self, page, where):
        wider = page.evaluate(OVERFLOW)
        return [f"{where}: wider than a phone by {wider} pixels"] if wider > 0 else []

    def broken(self, page, where, shown, theme):
        """Return the rules that a page breaks, each with its element."""
        expect(page.locator(shown).first).to_be_attached()
        expect(page.locator(".presence.there", has_text="ROS")).to_be_attached()
        page.wait_for_function(
            "() => document.getAnimations().every((one) => one.playState !== 'running')"
        )
        self.take_picture(page, f"axe-{where.strip('/').partition('?')[0]}-{theme}")
        return [f"{where} ({theme}): {one}" for one in self.rules_broken(page)]

    @staticmethod
    def rules_broken(page):
        page.evaluate(AXE.read_text())
        return page.evaluate(RUN)


if __name__ == "__main__":
    rospy.init_node("test_accessibility")
    rostest.rosrun("remodel_console", "test_accessibility", AccessibilityTest)
