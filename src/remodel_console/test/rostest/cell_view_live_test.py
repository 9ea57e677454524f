#!/usr/bin/env python3
"""The moving cell in three dimensions on the pages, in a real browser; the cell has no physics."""

import sys
from pathlib import Path

import rospy
import rostest
from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from fake_cell import MESHES, FakeCell
from fake_supervisor import FakeSupervisor
from inbox_case import HIDE, SHOW

from remodel_console.testing.browser_test import WEBGL_WITHOUT_GPU, BrowserTest
from remodel_supervision.core.runs.events import Ending, RunEnded

CHANGES = "() => Number(document.querySelector('.cell-view').dataset.changes)"
# On a wire that lies still: another one would have left the place before the click.
MIDDLE_OF_W1 = "() => document.querySelector('.cell-view').screenPointOf('W1')"
MOVES = 3  # changes, by which it is seen to move


class CellViewLiveTest(BrowserTest):
    first_page = "/overview"
    graphics = WEBGL_WITHOUT_GPU

    @classmethod
    def prepare(cls):
        cls.supervisor = FakeSupervisor()

    def test_the_cell_moves_and_a_wire_is_chosen(self):
        cell, supervisor = FakeCell(), self.supervisor
        self.addCleanup(cell.close)
        page = self.page
        view = page.get_by_role("img", name="The cell")
        expect(view).to_be_visible()
        expect(view).to_have_attribute("data-wires", "W1 W4")
        expect(view).to_have_attribute("data-meshes", str(MESHES))
        before = page.evaluate(CHANGES)
        page.wait_for_function(f"() => ({CHANGES})() >= {before + MOVES}")
        supervisor.run("cabinet 7")
        expect(page.locator(".order-head .title")).to_have_text("cabinet 7")
        facts = page.locator(".wire-facts")
        expect(page.locator("tr.task.running")).to_be_visible()
        page.mouse.click(*page.evaluate(MIDDLE_OF_W1))
        expect(facts).to_contain_text("done, 1 attempt")
        self.choose(page, "Wire", "W4")
        expect(facts).to_contain_text("K1/A2 to X1/2, BK, 1 mm2")
        expect(facts).to_contain_text("running, 1 attempt")
        supervisor.ask()
        expect(facts).to_contain_text("Insertion jammed: 22 N at 6 mm of 14 mm; the cell asks you.")
        self.take_picture(page, "cell")
        runtime = self.open_page("/runtime")
        expect(runtime.get_by_role("img", name="The cell")).to_have_attribute("data-wires", "W1 W4")
        expect(runtime.locator(f".cell-view[data-meshes='{MESHES}']")).to_be_visible()
        self.take_picture(runtime, "cell-runtime")

        self.assertTrue(cell.is_followed)
        supervisor.add(RunEnded(Ending.STOPPED, "stopped by an operator"))  # else it is recorded

        def is_free_in_background():
            for shown in (page, runtime):
                shown.evaluate(HIDE)  # again, if a busy page has connected to the console again
            return not cell.is_followed

        self.wait_until(is_free_in_background, "a page in the background to cost nothing")
        hidden_at = page.evaluate(CHANGES)
        page.evaluate(SHOW)
        self.wait_until(lambda: cell.is_followed)
        page.wait_for_function(f"() => ({CHANGES})() > {hidden_at}")
        page.close()
        self.page = runtime
        self.wait_until(lambda: not cell.is_followed, "a closed page to cost nothing")


if __name__ == "__main__":
    rospy.init_node("test_cell_view_live")
    rostest.rosrun("remodel_console", "test_cell_view_live", CellViewLiveTest)
