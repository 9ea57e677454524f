"""What the tests of accessibility share: pages with contents, and the rules of axe-core."""

import sys
from pathlib import Path

from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from behavior_test_case import BehaviorTestCase
from fake_supervisor import FakeCameras, FakeRecords, FakeSupervisor

AXE = Path(__file__).parents[1] / "axe" / "axe.min.js"
RUN = """async () => (await axe.run(document, { resultTypes: ['violations'] })).violations.flatMap(
  (rule) => rule.nodes.map((node) => `${rule.id}: ${node.target.join(' ')}: `
    + (node.any[0] ?? node.all[0] ?? node.none[0])?.message))"""
# Address, and what is shown once the page has all its contents.
PAGES = {
    "/overview": "tr.task",
    "/runtime": "li.node",
    "/editor": "li.node",
    "/replay?run=12": ".clock",
    "/statistics": ".statistics td",
    "/configuration": ".matter",
}


class AccessibilityCase(BehaviorTestCase):
    """Begins each test with a run that is under way."""

    first_page = "/runtime"

    def setUp(self):
        super().setUp()
        self.supervisor, self.cameras, self.records = FakeSupervisor(), FakeCameras(), FakeRecords()
        self.choose(self.page, "Behavior", "Errand")
        expect(self.page.locator("li.node").first).to_be_visible()
        self.supervisor.run("cabinet 7")

    def open_full(self, address):
        """Open a page, and have it show all it can."""
        page = self.open_page(address)
        if address == "/editor":
            self.choose(page, "Open", "Errand")
        elif address == "/runtime":
            self.pick_drawn(page, "Report")
            self.press(page, "Breakpoint")
            expect(page.locator(".state-hint")).to_be_visible()
        elif address.startswith("/replay"):
            expect(page.locator(".clock")).to_be_visible()
            self.choose(page, "Compare with", "13  cabinet 7")
            expect(page.locator(".compare-table tr.first")).to_be_visible()
        return page

    def broken(self, page, where, shown, theme):
        """Return the rules that a page breaks, each with its element."""
        expect(page.locator(shown).first).to_be_attached()
        expect(page.locator(".presence.there", has_text="ROS")).to_be_attached()
        page.wait_for_function(
            "() => document.getAnimations().every((one) => one.playState !== 'running')"
        )
        self.take_picture(page, f"axe-{where.strip('/').partition('?')[0]}-{theme}")
        return [f"{where} ({theme}): {one}" for one in self.rules_broken(page)]

    @staticmethod
    def rules_broken(page):
        page.evaluate(AXE.read_text())
        return page.evaluate(RUN)
