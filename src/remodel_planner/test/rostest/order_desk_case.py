"""What the tests of the order desk share: a page of it, and what is dropped there."""

import json
import shutil
import sys
from pathlib import Path

from playwright.sync_api import expect

from remodel_console.testing.browser_test import BrowserTest

OUTPUT = Path(sys.argv[1])
DATABASE = f"sqlite:///{OUTPUT}/production.sqlite"
WORK_MS = 120_000.0  # in which the planner and the cell do their work, on a machine that is busy
DROP = """([name, text]) => {
  const dropped = new DataTransfer();
  dropped.items.add(new File([text], name));
  document.querySelector('.drop-zone').dispatchEvent(
    new DragEvent('drop', { dataTransfer: dropped, bubbles: true, cancelable: true }));
}"""


class OrderDeskCase(BrowserTest):
    """Begins each test on the order desk, beside a supervisor that takes orders."""

    first_page = "/order_desk"

    @classmethod
    def prepare(cls):
        OUTPUT.mkdir(parents=True)
        cls.addClassCleanup(shutil.rmtree, OUTPUT, ignore_errors=True)

    def setUp(self):
        super().setUp()
        expect(self.page.locator(".presence.there", has_text="ROS")).to_be_visible()
        expect(self.page.locator(".notice", has_text="supervisor")).to_have_count(0)

    def drop(self, name, text):
        """Drop a file on the page, and wait until it is planned or refused."""
        self.page.evaluate(DROP, [name, text])
        shown = self.page.locator(".plan-words, .desk-area .ending.bad")
        expect(shown.first).to_be_visible(timeout=WORK_MS)
        expect(self.page.locator(".doing")).to_be_hidden(timeout=WORK_MS)

    def recorded(self):
        lines = self.record.read_text().splitlines()
        return [(each["command"], each["state"]) for each in map(json.loads, lines)]

    def planned(self):
        """Return the tasks in the order of the plan that is shown."""
        return self.page.locator("details td:nth-child(2)").all_inner_texts()
