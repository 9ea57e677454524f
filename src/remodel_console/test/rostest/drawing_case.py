"""What the tests of the editor's drawing share: a page of it, and the charts in it."""

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
