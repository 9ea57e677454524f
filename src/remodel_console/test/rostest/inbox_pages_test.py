#!/usr/bin/env python3
"""What waits for a person draws attention on every page, in a real browser."""

import sys
from pathlib import Path

import rospy
import rostest
from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from fake_supervisor import FakeSupervisor
from inbox_case import HIDE, SHOW, InboxCase

PAGES = (
    *("/overview", "/runtime", "/editor", "/replay", "/configuration", "/statistics"),
    "/order_desk",
)
COUNT_SOUNDS = """() => {
  window.tones = 0;
  const start = OscillatorNode.prototype.start;
  OscillatorNode.prototype.start = function () { window.tones += 1; return start.call(this); };
  window.notes = [];
  window.Notification = class {
    static permission = 'granted';
    static requestPermission() {}
    constructor(title, { body }) { window.notes.push(body); }
  };
}"""


class InboxPagesTest(InboxCase):
    def test_every_page_draws_attention(self):
        pages = [self.open_page(address) for address in PAGES]
        supervisor = FakeSupervisor()
        for page in pages:
            expect(page.locator(".presence.there", has_text="ROS")).to_be_visible()
            page.evaluate(COUNT_SOUNDS)
        hidden = pages[2]
        hidden.evaluate(HIDE)
        self.press(pages[0], "Notifications")
        pages[0].get_by_text("Show a notification").click()
        pages[0].get_by_text("Play a sound").click()
        pages[0].keyboard.press("Escape")
        supervisor.run("cabinet 7")
        expect(pages[0].locator(".order-head .title")).to_have_text("cabinet 7")
        supervisor.ask()
        for page in pages:
            expect(page.locator(".inbox-badge")).to_have_text("1 waiting")
            page.wait_for_function("() => document.title.startsWith('(1)')")
        expect(hidden.locator(".request")).to_have_count(0)  # not in view: nothing else is shown
        hidden.evaluate(SHOW)
        expect(hidden.locator(".request")).to_contain_text("The wire jams in K1/A2")
        self.assertEqual(pages[0].evaluate("() => window.tones"), 1)
        self.assertIn("The wire jams in K1/A2", pages[0].evaluate("() => window.notes[0]"))
        self.assertEqual(pages[1].evaluate("() => window.notes.length"), 0)
        pages[3].keyboard.press("Tab")
        expect(pages[3].locator(":focus")).to_have_text("To what waits for you")
        pages[3].keyboard.press("Enter")
        pages[3].keyboard.press("Tab")
        expect(pages[3].locator(":focus")).to_contain_text("Try again")
        self.see_a_phone()
        pages[4].get_by_role("button", name="Skip the task").click()
        expect(pages[1].locator(".request")).to_have_count(0)
        self.assertEqual(supervisor.asked[-1], ("answer", 1, "skip", "operator"))
        for page in pages:
            page.wait_for_function("() => !document.title.startsWith('(')")

    def see_a_phone(self):
        """A phone shows the card alone; the page is one press away."""
        phone = self.open_page("/overview", width=390, height=844)
        expect(phone.locator(".request")).to_contain_text("The wire jams")
        expect(phone.locator(".order-head .title")).to_be_hidden()
        self.take_picture(phone, "inbox-phone")
        self.press(phone, "Show the page")
        expect(phone.get_by_role("button", name="Protective stop")).to_be_visible()


if __name__ == "__main__":
    rospy.init_node("test_inbox_pages")
    rostest.rosrun("remodel_console", "test_inbox_pages", InboxPagesTest)
