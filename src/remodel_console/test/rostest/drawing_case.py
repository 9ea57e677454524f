"""What the tests of the editor's drawing share: what is drawn, and hands on it."""

import contextlib
import re
import sys
from pathlib import Path

from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from editor_case import EditorCase


class DrawingCase(EditorCase):
    """Begins each test in the editor."""

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
