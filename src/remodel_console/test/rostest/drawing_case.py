"""What the tests of the editor's drawing share: a page of it, and the charts in it."""

import contextlib
import re
import sys
from pathlib import Path

from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from behavior_test_case import BehaviorTestCase

from flexbe_synthesizer.core.chart.chart_reader import parse_chart


class DrawingCase(BehaviorTestCase):
    """Begins each test in the editor."""

    first_page = "/editor"

    def setUp(self):
        super().setUp()
        expect(self.page.get_by_role("button", name="Save", exact=True)).to_be_visible()

    def chart(self, name):
        return parse_chart((self.package / "charts" / f"{name}.xml").read_bytes())

    def open(self, name):
        self.choose(self.page, "Open", name)
        expect(self.page.locator(".properties .title", has_text=name)).to_be_visible()

    def drawn(self, path):
        """Return the entry of what is drawn among the words for it."""
        return self.page.locator(f".canvas-outline [data-path='{path}']").first

    def pick_both(self, first, second):
        """Select two states; again if the chart was redrawn between finding one and clicking it."""
        page, selected = self.page, self.page.locator(".canvas-outline li.selected")

        def are_picked():
            with contextlib.suppress(AssertionError):
                self.pick_drawn(page, first)
                expect(self.drawn(first)).to_have_class(re.compile("selected"), timeout=5000)
                page.keyboard.down("Shift")
                self.pick_drawn(page, second)
                page.keyboard.up("Shift")
                expect(selected).to_have_count(2, timeout=5000)
                return True
            page.keyboard.up("Shift")
            return False

        self.wait_until(are_picked, f"{first} and {second}")
