#!/usr/bin/env python3
"""Overview in a real browser, against a supervisor and cameras that are fake."""

import json
import os
import re
import signal
import sys
from pathlib import Path

import rospy
import rostest
from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from behavior_test_case import BehaviorTestCase
from fake_supervisor import FakeCameras, FakeRecords, FakeSupervisor


class OverviewTest(BehaviorTestCase):
    has_engine = False

    def setUp(self):
        super().setUp()
        expect(self.page.locator(".presence.there", has_text="ROS")).to_be_visible()

    def test_an_order_runs_asks_and_is_commanded(self):
        page = self.page
        away = page.locator(".notice", has_text="The supervisor is not running")
        expect(away).to_be_visible()
        expect(page.locator(".notice", has_text="The cell is not running")).to_be_visible()
        expect(page.locator(".notice", has_text="The engine is not running")).to_be_visible()
        expect(page.locator(".start-card")).to_contain_text("Nothing runs here")
        expect(page.locator(".ending")).to_have_text("The supervisor is not running.")
        expect(page.get_by_role("button", name="Start the order")).to_have_count(0)
        supervisor, cameras = FakeSupervisor(), FakeCameras()
        expect(away).to_have_count(0)
        expect(page.locator(".ending")).to_be_hidden()
        self.see_what_the_cell_is()

        supervisor.close("cell 1 is owned by another station: bench 2")
        expect(page.locator(".ending")).to_contain_text(
            "cell 1 is owned by another station: bench 2"
        )
        supervisor.close("")
        expect(page.locator(".ending")).to_be_hidden()

        self.type_order("nowhere")
        self.press(page, "Start the order")
        expect(page.get_by_text("there is no order 'nowhere'")).to_be_visible()
        self.press(page, "OK")
        self.type_order("cabinet 7")
        page.get_by_label("Number of tasks").fill("6")
        page.get_by_text("The panel is empty").click()
        self.press(page, "Start the order")
        expect(page.locator(".order-head .title")).to_have_text("cabinet 7")
        self.assertEqual(supervisor.asked[-1], ("run", "cabinet 7", 6, True))
        expect(page.locator(".order-head")).to_contain_text(
            "2 of 6 tasks done, 1 skipped, 2 wires by hand; 4 min of work so far, about 2 min left"
        )
        expect(page.locator("tr.task.set_aside")).to_contain_text("W3")
        expect(page.locator(".levels")).to_contain_text("Ability: InsertCable")
        stop = page.get_by_role("button", name="Stop", exact=True)
        place = stop.bounding_box()
        supervisor.ask()
        expect(page.locator(".failures")).to_contain_text("W4: Insertion jammed")
        self.assertEqual(stop.bounding_box(), place, "Stop moves away from who presses it")
        expect(page.locator(".request")).to_contain_text("10 min left to answer")
        expect(page.locator(".failures")).to_contain_text(
            "The cell tries again, because it has failed once."
        )
        expect(page.locator(".figures")).to_contain_text("33%")
        expect(page.locator(".figures")).to_contain_text("Grasp missed")

        self.wait_until(cameras.is_followed)
        cameras.look()
        for name in ("From above", "From the hand", "The cell"):
            expect(page.get_by_role("img", name=name)).to_be_visible()
        self.open_tablet_in_the_dark("/overview", ".request")

        page.locator(".q-header .q-btn", has_text="Your name").click()
        page.get_by_label("Name").fill("Ada")
        self.press(page, "Save")
        page.get_by_role("button", name="I have fixed it").click()
        expect(page.locator(".request")).to_have_count(0)
        self.assertEqual(supervisor.asked[-1], ("answer", 1, "fixed", "Ada"))
        row = page.locator("tr.task", has_text="W4")
        row.evaluate("row => row.dataset.mark = 'the same row'")
        self.press(page, "Skip W5")
        self.wait_until(lambda: supervisor.asked[-1] == ("skip", "W5", "Ada"))
        self.press(page, "Retry W3")
        self.wait_until(lambda: supervisor.asked[-1] == ("retry", "W3", "Ada"))
        expect(page.locator("tr.task").last).to_contain_text("W3")
        names = page.locator("tr.task .name").all_inner_texts()
        self.assertEqual([name[:2] for name in names], ["W1", "W2", "W5", "W4", "W6", "W3"])
        expect(row).to_have_attribute("data-mark", "the same row")  # no click on it is lost
        self.hold_and_resume(supervisor)
        self.lose(supervisor)
        self.press(page, "Stop")
        self.press(page, "Stop the run")
        expect(page.locator(".ending")).to_contain_text(
            "Order 'cabinet 7', run 12: stopped by an operator"
        )
        expect(page.locator(".ending")).to_contain_text(
            "2 of 6 tasks done, 2 skipped, 2 interrupted, 2 wires by hand."
        )
        self.tick_off(supervisor)
        commands = [json.loads(line) for line in self.record.read_text().splitlines()]
        given = [(c["who"], c["command"], c["state"]) for c in commands]
        self.assertIn(("Ada", "answer question 1 about W4: I have fixed it", "done"), given)
        self.assertIn(("operator", "run order 'nowhere'", "failed"), given)
        self.assertIn(("Ada", "wire W7 of SN-0042 is placed by hand", "done"), given)

    def see_what_the_cell_is(self):
        """Ability servers count if their nodes answer, which a stopped process does not."""
        page = self.page
        self.start("abilities", "remodel_states", "fake_abilities")
        expect(page.locator(".presence.there", has_text="Cell: fake")).to_be_visible()
        os.killpg(self.processes["abilities"].pid, signal.SIGSTOP)
        silent = page.locator(".notice", has_text="The cell does not answer")
        expect(silent).to_be_visible()
        expect(page.locator(".presence.gone", has_text="Cell")).to_be_visible()
        self.press(page, "What to do")
        expect(page.get_by_role("dialog")).to_contain_text("Its process is stopped or hangs")
        self.take_picture(page, "overview-status")
        page.keyboard.press("Escape")
        os.killpg(self.processes["abilities"].pid, signal.SIGCONT)
        expect(silent).to_have_count(0)
        self.kill("abilities")
        expect(page.locator(".notice", has_text="The cell is not running")).to_be_visible()

    def type_order(self, name):
        """Type an order's name and go on to the next field.

        Not Enter, which stays in the field: pressed in the same instant as the last letter,
        as only a test can, it comes before the menu, which then covers what is below.
        """
        field = self.page.get_by_role("combobox", name="Order")
        field.fill(name)
        field.press("Tab")

    def hold_and_resume(self, supervisor):
        """Pause while the cell moves, stop it, and resume."""
        page, phase = self.page, self.page.locator(".order .state")
        supervisor.standstill.clear()
        page.keyboard.press("Alt+p")
        expect(phase).to_have_text("pausing…")
        expect(page.locator(".order-head")).to_contain_text("pausing… ")
        self.press(page, "Skip W6")  # the page does not wait for the answer
        expect(page.locator("tr.task.set_aside", has_text="W6")).to_be_visible()
        supervisor.standstill.set()
        expect(phase).to_have_text("paused")
        self.press(page, "Resume")
        expect(phase).to_have_text("running")
        self.press(page, "Protective stop")
        banner = page.locator(".protective")
        expect(banner).to_contain_text("Protective stop, requested by Ada")
        expect(phase).to_have_text("protective stop")
        supervisor.add(controllers=("/safety_plc",))
        expect(banner).to_contain_text("held by the safety controller /safety_plc")
        release = page.get_by_role("button", name="Release the protective stop")
        expect(release).to_be_hidden()
        supervisor.add(controllers=())
        expect(banner).to_contain_text("the run stays paused until Resume")
        self.take_picture(page, "overview-protective-stop")
        release.click()
        expect(banner).to_be_hidden()
        expect(phase).to_have_text("paused")
        self.press(page, "Resume")
        expect(phase).to_have_text("running")

    def lose(self, supervisor):
        """See what was known of the run while its supervisor is gone, and starts again."""
        page = self.page
        supervisor.leave()
        gone = page.locator(".ending")
        since = r"The supervisor is not running. This is the last known state, out of date since \d"
        expect(gone).to_contain_text(re.compile(since))
        expect(page.locator(".start-card")).to_be_hidden()
        expect(page.locator(".order-head")).to_contain_text("cabinet 7")
        expect(page.locator("tr.task", has_text="W1")).to_contain_text("done")
        for name in ("Start the order", "Resume", "Skip W5", "Protective stop"):
            expect(page.get_by_role("button", name=name, exact=True)).to_have_count(0)
        self.take_picture(page, "overview-outdated")
        supervisor.come_back()
        expect(gone).to_have_count(0)
        expect(page.locator(".order .state")).to_have_text("running")

    def tick_off(self, supervisor):
        """Tick a wire by hand off on the computer, and the other on a phone, after a restart."""
        page = self.page
        hand = page.locator(".by-hand")
        expect(hand).to_contain_text("By hand: 2 of 2 to be placed")
        expect(hand).to_contain_text("Q1/2 to X1/PE, GNYE, 16 mm², 482 mm")
        expect(page.locator("tr.task", has_text="W4")).to_contain_text("interrupted")
        hand.get_by_text("W7, marker PE1").click()
        expect(hand).to_contain_text("By hand: 1 of 2 to be placed")
        self.take_picture(page, "overview-by-hand")
        supervisor.state = None  # one that has started again, and knows of no product
        supervisor.close("it reads its database")
        expect(page.locator(".ending.bad")).to_contain_text("it reads its database")
        supervisor.close("")
        expect(hand).to_contain_text("SN-0042, built before. By hand: 1 of 2 to be placed")
        phone = self.open_page("/overview", width=390, height=844)
        expect(phone.locator(".by-hand")).to_contain_text("By hand: 1 of 2 to be placed")
        expect(phone.get_by_role("checkbox", name="W7, marker PE1")).to_be_checked()
        phone.locator(".by-hand").get_by_text("W8").click()
        expect(hand).to_contain_text("By hand: all 2 are placed")
        self.take_picture(phone, "overview-by-hand-phone")

    def see_statistics(self):
        """Compare all runs with those of one order."""
        page = self.open_page("/statistics")
        page.get_by_role("button", name="Reload").click()
        terminals = page.locator("section", has_text="Terminals").locator("tr")
        expect(terminals.last).to_have_text("K1/A18" + "8" + "100%")
        expect(page.get_by_role("img", name="First-pass yield over runs")).to_contain_text("run 13")
        expect(page.get_by_role("img", name="Utilisation over runs")).to_contain_text("run 13")
        wires = page.locator("section", has_text="Time per wire").locator("tr")
        expect(wires.nth(1)).to_have_text("W278 s")
        self.take_picture(page, "statistics")
        self.choose(page, "Order", "cabinet 8")
        expect(terminals.last).to_have_text("K1/A14" + "4" + "100%")
        yields = page.get_by_role("img", name="First-pass yield over runs")
        expect(yields).not_to_contain_text("run 12")
        self.open_tablet_in_the_dark("/statistics", ".statistics")

    def runs_are_compared(self, page):
        """Compare with a run without the failure, and go to where they part."""
        self.choose(page, "Compare with", "13  cabinet 7")
        first = page.locator(".compare-table tr.first")
        expect(first).to_contain_text("W1: Insertion jammed: 22 N at 6 mm of 14 mm")
        expect(first).to_contain_text("no such step")
        expect(page.locator(".compare-head")).to_contain_text("2 of 9 steps differ.")
        page.get_by_role("button", name="Go to the first difference").click()
        expect(page.locator(".clock")).to_contain_text("entry 18 of 23")
        self.take_picture(page, "replay-compare")
        page.locator(".compare").get_by_role("button", name="W1: Greet").click()
        expect(page.locator(".clock")).to_contain_text("entry 3 of 23")
        self.press(page, "Next reason (N)")
        self.press(page, "Next reason (N)")
        self.choose(page, "Compare with", "no run")
        expect(page.locator(".compare")).to_be_hidden()

    def press_while_the_list_is_loaded_again(self, page, records, name):
        """Press a run's button, have the same list loaded twice, and release the button."""
        page.get_by_role("button", name=name).hover()
        page.mouse.down()
        for _ in range(2):
            listed = records.listed
            page.get_by_role("button", name="Reload").dispatch_event("click")
            self.wait_until(lambda listed=listed: records.listed > listed, "another list of runs")
        page.mouse.up()

    def test_a_person_arranges_the_page_and_the_browser_keeps_it(self):
        page = self.page
        levels = page.locator(".part", has_text="Activity of each level")
        failures = page.locator(".part", has=page.get_by_text("Failures", exact=True))
        line = page.get_by_role("separator", name="Width of the activity")

        def top(part):
            return part.bounding_box()["y"]

        def width():
            return page.locator("aside.panel").bounding_box()["width"]

        self.assertLess(top(levels), top(failures))
        delivered = width()
        for _ in range(5):
            line.press("ArrowLeft")
        self.wait_until(lambda: width() == delivered + 80)
        self.press(page, "Layout")
        page.get_by_role("button", name="Failures up").click()
        self.wait_until(lambda: top(failures) < top(levels))
        page.get_by_role("checkbox", name="Figures").click()
        page.wait_for_function("() => document.cookie.includes('-Figures')")
        page.reload()
        expect(failures).to_be_visible()
        self.assertLess(top(failures), top(levels))
        self.assertEqual(width(), delivered + 80)
        expect(page.locator(".part", has=page.locator(".figures"))).to_be_hidden()
        self.press(page, "Layout")
        expect(page.get_by_role("checkbox", name="Figures")).not_to_be_checked()
        self.press(page, "As it was delivered")
        self.wait_until(lambda: top(levels) < top(failures) and width() == delivered)

    def test_the_record_of_a_run_is_scrubbed_through(self):
        records = FakeRecords()
        page = self.page = self.open_page("/replay")
        page.get_by_role("button", name="Reload").click()
        self.press_while_the_list_is_loaded_again(page, records, "12 cabinet 7")
        expect(page.locator(".clock")).to_have_text("0.0 s of 16.0 s, entry 1 of 23")
        page.keyboard.press("n")
        expect(page.locator(".entry-words")).to_have_text(
            "failure: Insertion jammed: 22 N at 6 mm of 14 mm"
        )
        expect(page.locator("li.node.active[data-path='Search/Look closer']").first).to_be_visible()
        expect(page.locator("li.node.passed[data-path='Greet']").first).to_be_visible()
        expect(page.get_by_role("img", name="Last camera picture")).to_be_visible()
        page.get_by_role("button", name="Next reason (N)").click()
        expect(page.locator(".failures")).to_contain_text(
            "The cell replans the rest; the task comes later, because two new parts have jammed."
        )
        self.runs_are_compared(page)
        self.open_tablet_in_the_dark("/replay?run=12", ".clock")
        page.get_by_role("button", name="Previous entry (,)").click()
        expect(page.locator(".clock")).to_contain_text("entry 18 of 23")
        track = page.locator(".track")
        track.click(position={"x": track.bounding_box()["width"] - 1, "y": 20})
        expect(page.locator(".clock")).to_contain_text("entry 23 of 23")
        expect(page.locator(".failures")).to_contain_text("Ada: skips W2")
        track.click(position={"x": 1, "y": 20})
        expect(page.locator(".clock")).to_contain_text("entry 1 of 23")
        self.choose(page, "Speed", "20 x")
        page.get_by_role("button", name="Play (P)").click()
        expect(page.locator(".clock")).to_contain_text("entry 23 of 23")
        self.see_statistics()


if __name__ == "__main__":
    rospy.init_node("test_overview")
    rostest.rosrun("remodel_console", "test_overview", OverviewTest)
