#!/usr/bin/env python3
"""What waits for a person is seen and answered on every page, in a real browser."""

import json
import sys
import time
from pathlib import Path

import rospy
import rostest
from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from behavior_test_case import BehaviorTestCase
from fake_supervisor import FakeSupervisor

PAGES = (
    *("/overview", "/runtime", "/editor", "/replay", "/configuration", "/statistics"),
    "/order_desk",
)
SEEN_S = 0.5  # within which a page shows what waits, where its core is idle
BUSY_S = 20.0  # the same, where other tests use the cores
RECORD_WAITING = """() => {
  window.seen = 0;
  new MutationObserver(() => {
    if (!window.seen && document.title.startsWith('(1)')) window.seen = Date.now();
  }).observe(document.querySelector('title'), { childList: true });
}"""
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
HIDE = """() => {
  Object.defineProperty(document, 'hidden', { value: true, configurable: true });
  document.dispatchEvent(new Event('visibilitychange'));
}"""
SHOW = HIDE.replace("value: true", "value: false")


class InboxTest(BehaviorTestCase):
    first_page = "/runtime"

    @classmethod
    def prepare(cls):
        super().prepare()
        cls.start("relay", "flexbe_input", "behavior_input")

    def setUp(self):
        super().setUp()
        expect(self.page.locator(".state")).to_have_text("idle")

    def begin(self, name, level="Unattended"):
        self.choose(self.page, "Behavior", name)
        expect(self.page.locator(".headline .title")).to_have_text(name)
        self.choose(self.page, "Autonomy", level)
        self.press(self.page, "Start")

    def ended(self, outcome):
        expect(self.page.locator(".ending")).to_have_text(f"The last run ended with '{outcome}'.")

    def recorded(self):
        lines = [json.loads(line) for line in self.record.read_text().splitlines()]
        return [line["command"] for line in lines if line["state"] == "done"]

    def test_a_value_and_a_decision_are_answered_on_any_page(self):
        overview = self.open_page("/overview")
        self.begin("Survey")
        card = overview.locator(".request")
        expect(card).to_contain_text("The behavior needs a value")
        expect(card).to_contain_text("Which pin is bent?")
        card.get_by_label("Value").fill("[7, 'A7'")
        expect(card).to_contain_text("Sends the text")
        card.get_by_label("Value").fill("[7, 'A7']")
        expect(card).to_contain_text("Sends the list [7, 'A7']")
        self.take_picture(overview, "inbox-input")
        self.press(card, "Send the value")
        expect(self.page.locator(".log")).to_contain_text("The bent pin is [7, 'A7'].")
        configuration = self.open_page("/configuration")
        card = configuration.locator(".request")
        expect(card).to_contain_text("Can the pin be bent back?")
        expect(card).to_contain_text("your answer attaches to it")
        expect(self.page.locator(".state")).to_have_text("waiting for you")
        self.values_of_states_that_have_ended()
        self.press(card, "repair")
        self.ended("repaired")
        expect(card).to_have_count(0)
        self.assertIn("enter [7, 'A7'] for 'Which pin is bent?'", self.recorded())
        self.assertIn("decide 'repair' of /Judge", self.recorded())

    def values_of_states_that_have_ended(self):
        """See what a state has left behind, and what one has found that ended at once."""
        page = self.page
        cells = page.locator(".state-panel td")
        self.pick_drawn(page, "Ask")
        expect(cells).to_have_text(["data", "", "[7, 'A7']"])
        expect(page.locator(".canvas-values[data-path='Ask']")).to_have_text("data[7, 'A7']")
        self.pick_drawn(page, "Say")
        expect(cells).to_have_text(["data", "[7, 'A7']", ""])

    def test_a_supervised_decision_and_a_refused_value(self):
        self.begin("Survey", "Full")
        expect(self.page.locator(".state")).to_have_text("waiting for you")
        self.page.get_by_label("Value").fill("A7")
        self.page.get_by_label("Value").press("Enter")
        expect(self.page.locator(".log")).to_contain_text("The bent pin is A7.")
        expect(self.page.locator(".request")).not_to_contain_text("attaches")
        self.press(self.page.locator(".request"), "scrap")
        self.ended("scrapped")
        self.press(self.page, "Start")
        self.press(self.page.locator(".request"), "Enter no value")
        self.ended("scrapped")

    def test_step_mode_asks_before_every_transition(self):
        self.begin("Patrol", "High")
        self.press(self.page, "Step mode")
        card = self.page.locator(".request")
        for _ in range(3):
            expect(card).to_contain_text("Leave '")
            asked = card.inner_text()
            for key in "clps ":  # single keys command nothing
                self.page.keyboard.press(key)
            self.assertEqual(card.inner_text(), asked)
            self.page.keyboard.press("Alt+c")
            self.wait_until(lambda before=asked: card.count() and card.inner_text() != before)
        self.press(self.page, "Leave step mode")
        expect(self.page.locator(".request")).to_have_count(0)
        expect(self.page.get_by_role("combobox", name="Autonomy")).to_have_value("High")
        self.press(self.page, "Stop")
        self.press(self.page.get_by_role("dialog"), "Stop")
        expect(self.page.locator(".ending")).to_have_text("The last run was stopped.")

    def test_every_page_draws_attention(self):
        pages = [self.open_page(address) for address in PAGES]
        supervisor = FakeSupervisor()
        for page in pages:
            expect(page.locator(".presence.there", has_text="ROS")).to_be_visible()
            page.evaluate(COUNT_SOUNDS)
            page.evaluate(RECORD_WAITING)
        hidden = pages[2]
        hidden.evaluate(HIDE)
        self.press(pages[0], "Notifications")
        pages[0].get_by_text("Show a notification").click()
        pages[0].get_by_text("Play a sound").click()
        pages[0].keyboard.press("Escape")
        supervisor.run("cabinet 7")
        expect(pages[0].locator(".order .title")).to_have_text("cabinet 7")
        asked_ms = 1000 * time.time()
        supervisor.ask()
        late_s = []
        for page in pages:
            page.wait_for_function("() => window.seen")
            late_s.append((page.evaluate("() => window.seen") - asked_ms) / 1000)
            expect(page.locator(".inbox-badge")).to_have_text("1 waiting")
        self.assertLess(min(late_s), SEEN_S, late_s)
        self.assertLess(max(late_s), BUSY_S, late_s)
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
        expect(phone.locator(".order .title")).to_be_hidden()
        self.take_picture(phone, "inbox-phone")
        self.press(phone, "Show the page")
        expect(phone.get_by_role("button", name="Protective stop")).to_be_visible()


if __name__ == "__main__":
    rospy.init_node("test_inbox")
    rostest.rosrun("remodel_console", "test_inbox", InboxTest)
