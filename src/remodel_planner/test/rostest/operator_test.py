#!/usr/bin/env python3
"""An operator requests, at the console, a wire whose opening must be cleared by hand before."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import rospy
import rostest
import yaml
from order_client import DESIGN
from playwright.sync_api import expect
from remodel_msgs.msg import UseCaseState
from remodel_msgs.srv import GetGroundTruth, InjectFault

from remodel_console.testing.browser_test import WEBGL_WITHOUT_GPU, BrowserTest
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_tasks.edge.use_case_files import use_case_folder

OUTPUT = Path(sys.argv[1])
DATABASE = f"sqlite:///{OUTPUT}/production.sqlite"
WORK_MS = 1_200_000.0  # in which the cell tries a wire, on a machine that is busy


class OperatorTest(BrowserTest):
    graphics = WEBGL_WITHOUT_GPU

    @classmethod
    def prepare(cls):
        """Import an order, and have an operator asked at once about an end that jams."""
        (OUTPUT / "use_cases").mkdir(parents=True)
        cls.addClassCleanup(shutil.rmtree, OUTPUT, ignore_errors=True)
        line = ["remodel", "import", DESIGN, "--order", "house"]
        subprocess.run([*line, "--database", DATABASE], check=True, timeout=180)
        use_case = yaml.safe_load((use_case_folder() / "cabinet.yaml").read_text())
        use_case["recovery"]["responses"]["insertion_jammed"] = [{"do": "ask_operator"}]
        (OUTPUT / "use_cases" / "cabinet.yaml").write_text(yaml.safe_dump(use_case))
        rospy.wait_for_service("cell/inject_fault", 180.0)

    def openings(self, name):
        """Return component/terminal of a wire's ends a and b."""
        wires = ProductionDatabase(DATABASE).order("house").wires
        wire = next(wire for wire in wires if wire.name == name)
        return {"a": f"{wire.a.component}/{wire.a.terminal}",
                "b": f"{wire.b.component}/{wire.b.terminal}"}  # fmt: skip

    def disturb(self, kind, openings):
        for opening in openings.values():
            done = rospy.ServiceProxy("cell/inject_fault", InjectFault)(kind, opening, [])
            self.assertTrue(done.success, done.message)

    def test_a_failed_wire_is_recovered_and_its_run_replayed(self):
        page, behavior = self.page, self.open_page("/runtime")
        expect(page.locator(".notice")).to_have_count(0, timeout=WORK_MS)
        self.choose(page, "Order", "house")
        page.get_by_label("Number of tasks").fill("1")
        self.press(page, "Start the order")
        expect(page.locator("tr.task.running")).to_have_count(1, timeout=WORK_MS)
        wire = rospy.wait_for_message("remodel/use_case/state", UseCaseState, WORK_MS / 1e3).task
        openings = self.openings(wire)
        self.disturb("socket_blocked", openings)
        self.watch(behavior, wire)

        question = page.locator(".request")
        expect(question).to_contain_text("Insertion jammed:", timeout=WORK_MS)
        text = question.inner_text()
        end = next(letter for letter, opening in openings.items() if opening in text)
        for name in ("From above", "From the hand", "The cell"):
            expect(page.get_by_role("img", name=name)).to_be_visible()
        self.take_picture(page, "overview")
        self.take_picture(
            self.open_tablet_in_the_dark("/overview", ".cell-view"), "overview-dark-1024"
        )
        self.disturb("socket_cleared", openings)
        page.get_by_role("button", name="I have fixed it").click()
        expect(question).to_have_count(0)
        expect(page.locator(".ending")).to_contain_text(
            "all tasks of the cell are done", timeout=WORK_MS
        )
        expect(page.locator("tr.task.done")).to_have_count(1)
        expect(page.locator(".figures")).to_contain_text("Insertion jammed")
        scene = page.get_by_role("img", name="The cell")
        expect(scene).not_to_have_attribute("src", scene.get_attribute("src"))  # it is live
        self.take_picture(page, "overview-done")
        self.replay(wire, f"Insert {end}")

    def watch(self, page, wire):
        """See on another page what the engine does."""
        title = page.locator(".headline .title")
        expect(title).to_contain_text(f"Place Wire {wire}", timeout=WORK_MS)
        expect(page.locator(".where")).to_contain_text("Insert", timeout=WORK_MS)
        expect(page.locator(".state")).to_have_text("running unattended")
        expect(page.locator("li.node.active").first).to_be_visible()
        self.take_picture(page, "runtime")

    def replay(self, wire, state):
        """See where the run has failed, with which forces, and why it took its course."""
        page = self.page
        page.get_by_role("link", name="Replay this run").click()
        expect(page.locator(".clock")).to_contain_text("entry 1 of")
        page.wait_for_load_state("networkidle")  # its scripts listen to keys from now on
        for text in (f"The cell planned: {wire}", "Insertion jammed", "The cell asks you"):
            page.keyboard.press("n")
            expect(page.locator(".entry-words")).to_contain_text(text)
        expect(page.locator(".where")).to_contain_text(state)
        expect(page.get_by_role("img", name="Last camera picture")).to_be_visible()
        expect(page.get_by_role("img", name="peak force [N]")).to_be_visible()
        expect(page.locator("li.node.active").first).to_be_visible()
        stage = page.locator(".canvas-stage").bounding_box()

        def is_in_view():
            x, y = self.where(page, state)
            return 0 < x - stage["x"] < stage["width"] and 0 < y - stage["y"] < stage["height"]

        self.wait_until(is_in_view, "the drawing to show the active state")
        self.take_picture(page, "replay")
        self.press(page, "Start from here")
        dialog = page.get_by_role("dialog")
        expect(dialog).to_contain_text("The state gets the values that it found in this run")
        expect(dialog.get_by_label("socket_pose").first).to_have_value(re.compile("'position': "))
        expect(dialog.locator(".differences")).to_contain_text("The robot stands elsewhere")
        self.start_on_an_empty_panel(dialog)

    def start_on_an_empty_panel(self, dialog):
        """Have the panel rebuilt first; then there is no wire that could be inserted."""
        page, truth = self.page, rospy.ServiceProxy("cell/ground_truth", GetGroundTruth)
        self.assertEqual([wire.placed for wire in truth().wires], [True])
        is_rebuilt = dialog.get_by_role("checkbox", name="Rebuild the panel first")
        is_rebuilt.click()
        expect(is_rebuilt).to_be_checked()
        dialog.get_by_role("button", name="Start", exact=True).click()
        expect(page).to_have_url(re.compile("/runtime$"), timeout=WORK_MS)
        self.assertEqual(truth().wires, [])
        expect(page.locator(".log")).to_contain_text("InsertCable", timeout=WORK_MS)
        expect(page.locator(".ending")).to_contain_text("The last run ended", timeout=WORK_MS)
        self.assertEqual(truth().wires, [])
        commands = [json.loads(line) for line in self.record.read_text().splitlines()]
        states = [(c["command"].partition(" '")[0], c["state"]) for c in commands]
        self.assertIn(("reset the simulated cell", "done"), states)


if __name__ == "__main__":
    rospy.init_node("test_operator")
    rostest.rosrun("remodel_planner", "test_operator", OperatorTest)
