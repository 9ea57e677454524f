#!/usr/bin/env python3
"""The cell in three dimensions on the pages, in a real browser; the cell has no physics."""

import sys
from pathlib import Path

import rospy
import rostest
from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from fake_cell import MESHES, MIDDLE_OF_W4, FakeCell
from fake_supervisor import FakeRecords, FakeSupervisor

from remodel_console.testing.browser_test import WEBGL_WITHOUT_GPU, BrowserTest
from remodel_supervision.core.runs.events import Ending, RunEnded

FRAMES = 20
PLACES = 4  # of a wire, one after the other


class CellViewTest(BrowserTest):
    first_page = "/overview"
    graphics = WEBGL_WITHOUT_GPU

    @classmethod
    def prepare(cls):
        cls.supervisor = FakeSupervisor()

    def test_replay_shows_the_cell_as_it_was(self):
        cell, supervisor = FakeCell(), self.supervisor
        start_s = rospy.get_time()
        supervisor.run("cabinet 7")
        scenes = self.folder / ".ros/remodel_console/scenes"

        def frames():
            return sum(len(file.read_text().splitlines()) for file in scenes.glob("*.jsonl"))

        self.wait_until(lambda: frames() > FRAMES, "a recording")
        supervisor.add(RunEnded(Ending.STOPPED, "stopped by an operator"))
        self.page.close()
        self.page = self.open_page("/configuration")
        self.wait_until(lambda: not cell.is_followed, "a run that has ended to cost nothing")
        cell.close()
        FakeRecords(start_s)
        page = self.page = self.open_page("/replay?run=12")
        view = page.get_by_role("img", name="The cell")
        expect(view).to_have_attribute("data-meshes", str(MESHES))
        slider = page.locator(".track [tabindex='0']")

        def has_wires():  # which the cell may have sent after the first frame was recorded
            slider.press("ArrowRight")
            return view.get_attribute("data-wires") == "W1 W4"

        self.wait_until(has_wires, "the wires")
        heights = {page.evaluate(MIDDLE_OF_W4)[1]}

        def has_moved():
            slider.press("ArrowRight")
            heights.add(page.evaluate(MIDDLE_OF_W4)[1])
            return len(heights) >= PLACES

        self.wait_until(has_moved, "W4 to move")
        facts = page.locator(".wire-facts")
        self.choose(page, "Wire", "W4")
        expect(facts).to_have_text("No task is about this wire.")
        self.choose(page, "Wire", "W1")
        page.get_by_role("button", name="Next reason (N)").click()
        expect(facts).to_contain_text("force [N]: 15.5 at most, 15.5 last")
        expect(facts).to_contain_text("12.0 s: Insertion jammed: 22 N at 6 mm of 14 mm")
        self.take_picture(page, "replay-cell")


if __name__ == "__main__":
    rospy.init_node("test_cell_view")
    rostest.rosrun("remodel_console", "test_cell_view", CellViewTest)
