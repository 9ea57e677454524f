"""What the tests of the editor share: a page of it, and hands on its drawing."""

import contextlib
import sys
from pathlib import Path

from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from behavior_test_case import BehaviorTestCase

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from remodel_console.testing.browser_test import LIMIT_S


class EditorCase(BehaviorTestCase):
    """Begins each test in the editor."""

    first_page = "/editor"

    def setUp(self):
        super().setUp()
        expect(self.page.get_by_role("button", name="Save", exact=True)).to_be_visible()

    def chart(self, name):
        return parse_chart((self.package / "charts" / f"{name}.xml").read_bytes())

    def open(self, name):
        """Open a behavior; what another test has left unsaved is lost."""
        self.choose(self.page, "Open", name)
        lose = self.page.get_by_role("button", name="Discard and load")
        title = self.page.locator(".properties .title", has_text=name)
        expect(lose.or_(title)).to_be_visible()
        if lose.is_visible():
            lose.click()
        expect(title).to_be_visible()

    def fill(self, label, text):
        field = self.page.locator(".properties").get_by_label(label, exact=True)
        field.fill(text)
        field.press("Enter")

    def is_selected(self, path, limit_s=LIMIT_S):
        name = self.page.locator(".properties").get_by_label("Name", exact=True)
        with contextlib.suppress(AssertionError):
            expect(name).to_have_value(path.rpartition("/")[2], timeout=1000 * limit_s)
            return True
        return False

    def pick(self, path):
        """Select what is drawn; again if it was redrawn just when it was clicked."""

        def is_picked():
            self.press(self.page, "Show all")
            self.pick_drawn(self.page, path)
            return self.is_selected(path, limit_s=2.0)

        self.wait_until(is_picked, path)

    def add_container(self):
        """Add a container, which is selected then."""
        self.press(self.page, "Container")
        self.assertTrue(self.is_selected("Container"))
