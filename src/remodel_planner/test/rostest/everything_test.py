#!/usr/bin/env python3
"""One press of a button at the console starts all that an order needs, and the sample order."""

import rostest
from playwright.sync_api import expect

from remodel_console.testing.browser_test import BrowserTest

# In which everything starts, or does its work, on a machine that is busy.
WORK_MS = 180_000.0


class EverythingTest(BrowserTest):
    def test_one_press_wires_the_sample_order_and_one_ends_all_again(self):
        page = self.page
        card = page.locator(".start-card")
        expect(card).to_contain_text("Nothing runs here")
        expect(page.locator(".order-head")).to_be_hidden()
        self.take_picture(page, "overview-first")
        self.press(page, "Fake cell")
        expect(card).to_contain_text("Starting")
        self.take_picture(page, "overview-starting")
        expect(page.locator(".ending")).to_contain_text("Order 'sample'", timeout=WORK_MS)
        for words in ("Engine", "Supervisor", "Cell: fake", "Database"):
            expect(page.locator(".presence.there", has_text=words)).to_be_visible()
        expect(page.locator("tr.task.done")).to_have_count(6)
        expect(card).to_contain_text("Order desk")
        self.take_picture(page, "overview-sample")
        self.stop_all()
        # Once more: the order is done again, on an empty panel.
        self.press(page, "Fake cell")
        expect(page.locator(".ending")).to_contain_text("run 2", timeout=WORK_MS)
        expect(page.locator("tr.task.done")).to_have_count(6)
        self.stop_all()

    def stop_all(self):
        page, card = self.page, self.page.locator(".start-card")
        self.press(page, "Stop what was started here")
        self.press(page.get_by_role("dialog"), "Stop them")
        expect(card).to_contain_text("Nothing runs here", timeout=WORK_MS)


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_everything", EverythingTest)
