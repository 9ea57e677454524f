"""What the tests of what waits for a person share: an engine, a mirror and a relay of questions."""

import sys
from pathlib import Path

from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from behavior_test_case import BehaviorTestCase

HIDE = """() => {
  Object.defineProperty(document, 'hidden', { value: true, configurable: true });
  document.dispatchEvent(new Event('visibilitychange'));
}"""
SHOW = HIDE.replace("value: true", "value: false")


class InboxCase(BehaviorTestCase):
    """Begins each test on runtime control, with an idle engine."""

    first_page = "/runtime"

    @classmethod
    def prepare(cls):
        super().prepare()
        cls.start("relay", "flexbe_input", "behavior_input")

    def setUp(self):
        super().setUp()
        expect(self.page.locator(".state")).to_have_text("idle")
