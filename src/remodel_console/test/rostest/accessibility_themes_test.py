#!/usr/bin/env python3
"""All pages and dialogs, in both themes and on a phone, keep the rules of axe-core; in Chromium."""

import sys
from pathlib import Path

import rospy
import rostest
from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from accessibility_case import PAGES, AccessibilityCase

from remodel_console.core.commands import Account, Role
from remodel_console.edge.users_file import hash_of, write_accounts
from remodel_console.testing.browser_test import free_port

PLANNED_MS = 240_000
LIST = (
    b"Wire,From,To,Section mm2,Length mm,Shelf\n"
    b"W1,K1:1,X1:1,1,500,a\nW2,K1:2,X1:2,1,500,b\nW3,K1:3,X1:3,400,500,c\n"
)
CONTRADICTION = """format: remodel-preferences-1
require:
  - {name: up, route: W1, before: W2}
  - {name: down, route: W2, before: W1}
"""
TAB_IS_IN_VIEW = """() => {
  const box = document.querySelector('.bar .tab.here').getBoundingClientRect();
  return box.left >= 0 && box.right <= innerWidth;
}"""
OVERFLOW = "() => document.documentElement.scrollWidth - document.documentElement.clientWidth"


class AccessibilityThemesTest(AccessibilityCase):
    def test_no_rule_is_broken_in_light_dark_and_on_a_phone(self):
        broken = []
        for address, shown in PAGES.items():
            page = self.open_full(address)
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
        page.keyboard.press("Escape")
        self.press(page, "Layout")
        broken += self.broken(page, "layout", ".q-dialog .layout-row", "dark")
        self.assertEqual([], broken, "\n".join(broken))

    def broken_on_the_order_desk(self):
        """Look at an order with a plan, at one without, at a refused file, and at the dialogs."""
        broken, page = [], self.open_page("/order_desk")
        broken += self.broken(page, "empty desk", ".drop-zone", "light")
        file = page.locator(".drop-zone input")
        file.set_input_files({"name": "loom.csv", "mimeType": "", "buffer": LIST})
        # The planner's commands yield to everything else on the machine.
        expect(page.locator(".plan-words").first).to_be_attached(timeout=PLANNED_MS)
        broken += self.broken(page, "order_desk", ".plan-words", "light")
        self.press(page, "Edit all as YAML")
        page.get_by_role("dialog").get_by_label("YAML", exact=True).fill(CONTRADICTION)
        broken += self.broken(page, "preferences", ".q-dialog .yaml", "light")
        self.press(page.get_by_role("dialog"), "Save")
        self.press(page, "Plan again")
        expect(page.locator(".conflicting li")).to_have_count(2, timeout=PLANNED_MS)
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
        expect(page.locator(".desk-area .ending.bad")).to_be_attached(timeout=PLANNED_MS)
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


if __name__ == "__main__":
    rospy.init_node("test_accessibility_themes")
    rostest.rosrun("remodel_console", "test_accessibility_themes", AccessibilityThemesTest)
