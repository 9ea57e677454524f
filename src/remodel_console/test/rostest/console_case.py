"""What the tests of runtime control share: a page of it, an engine and a mirror."""

import contextlib
import sys
from pathlib import Path

import rosgraph
import rospy
from flexbe_msgs.msg import BehaviorSelection
from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from behavior_test_case import BehaviorTestCase

from remodel_console.edge.workspace import Catalogue


class ConsoleCase(BehaviorTestCase):
    """Begins each test on runtime control, with an idle engine."""

    first_page = "/runtime"

    def setUp(self):
        super().setUp()
        self.ready(self.page)

    def tearDown(self):
        """Leave the engine idle for the next test."""
        if self.page.locator(".state.running").count():
            self.stop(self.page)

    def ready(self, page):
        expect(page.locator(".notice", has_text="engine")).to_have_count(0)
        expect(page.locator(".state")).not_to_have_text("no engine")

    def load(self, page, name):
        self.choose(page, "Behavior", name)
        expect(page.locator(".headline .title")).to_have_text(name)
        expect(page.locator("li.node").first).to_be_visible()

    def start_elsewhere(self, name):
        """Start a behavior as a launcher would, unattended."""
        known = Catalogue(self.environment["ROS_PACKAGE_PATH"]).behaviors()
        installed = next(one for one in known if one.name == name)
        publisher = rospy.Publisher("flexbe/start_behavior", BehaviorSelection, queue_size=1)

        def is_heard():
            """Return whether the engine is connected: the console listens, too."""
            known = dict(rosgraph.Master("/test").getSystemState()[1])
            nodes = known.get(publisher.resolved_name, [])
            return bool(nodes) and publisher.get_num_connections() == len(nodes)

        self.wait_until(is_heard)
        publisher.publish(
            BehaviorSelection(
                behavior_id=installed.behavior_id,
                behavior_checksum=installed.source_checksum,
                autonomy_level=255,
            )
        )

    def lock(self, page):
        """Lock the active state; again if it was left before the engine had the command."""
        held = page.locator(".held", has_text="Locked:")

        def is_held():
            page.keyboard.press("Alt+l")
            with contextlib.suppress(AssertionError):
                expect(held).to_be_visible(timeout=2000)
            return held.count()

        self.wait_until(is_held)

    def stop(self, page):
        self.press(page, "Stop")
        page.get_by_role("dialog").get_by_role("button", name="Stop", exact=True).click()
        expect(page.locator(".ending")).to_have_text("The last run was stopped.")

    def state_panel(self, page):
        return page.get_by_role("region", name="State")

    def empty_place(self, page):
        box = page.locator(".canvas-stage").bounding_box()
        return box["x"] + 8, box["y"] + 8
