#!/usr/bin/env python3
"""What waits for a person is seen and answered on every page, in a real browser."""

import json
import re
import sys
from pathlib import Path

import rospy
import rostest
from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from inbox_case import InboxCase


class InboxTest(InboxCase):
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
        # The button has the focus, and a blank would press it, until this one takes its place.
        leave = self.page.get_by_role("button", name="Leave step mode", exact=True)
        expect(leave).to_be_visible()
        card = self.page.locator(".request")
        for _ in range(3):
            expect(card).to_contain_text(re.compile("(Enter|Leave) '(North|South)'"))
            asked = card.inner_text()
            self.assertNotIn("_attempts", asked)  # which the chart does not have
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


if __name__ == "__main__":
    rospy.init_node("test_inbox")
    rostest.rosrun("remodel_console", "test_inbox", InboxTest)
