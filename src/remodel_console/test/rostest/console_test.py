#!/usr/bin/env python3
"""Runtime control in a real browser, against a real engine and mirror."""

import json
import sys
from pathlib import Path

import rospy
import rostest
from geometry_msgs.msg import Vector3
from playwright.sync_api import expect
from std_msgs.msg import String

sys.path.insert(0, str(Path(__file__).parent))
from console_case import ConsoleCase

from remodel_console.core.commands import DONE, FAILED
from remodel_console.ros.calls import ask
from remodel_console.testing.browser_test import LIMIT_S

OBSERVE = """() => {
  const frame = document.querySelector('.canvas-frame');
  window.lit = [];
  new MutationObserver(() => window.lit.push([Date.now(), frame.dataset.active]))
    .observe(frame, { attributes: true, attributeFilter: ['data-active'] });
}"""


class ConsoleTest(ConsoleCase):
    def test_a_behavior_is_started_confirmed_and_ends(self):
        self.load(self.page, "Errand")
        self.choose(self.page, "Autonomy", "Low")
        self.page.get_by_label("greeting").fill("good morning")
        self.press(self.page, "Start")
        expect(self.page.locator(".request")).to_contain_text("Leave 'Report' with 'done'?")
        expect(self.page.locator("li.node.asked[data-path='Report']").first).to_be_visible()
        expect(self.page.locator("li.node.passed[data-path='Search/Look']").first).to_be_visible()
        expect(self.page.locator(".log")).to_contain_text("The errand says good morning.")
        self.log_is_filtered()
        self.page.get_by_text("Userdata").click()
        self.press(self.page, "Read")
        expect(self.page.locator("table.plain")).to_contain_text("good morning")
        self.take_picture(self.page, "runtime-request")
        self.page.keyboard.press("Alt+c")
        expect(self.page.locator(".ending")).to_have_text("The last run ended with 'finished'.")
        commands = [json.loads(line) for line in self.record.read_text().splitlines()]
        given = [(c["who"], c["command"], c["state"]) for c in commands]
        self.assertIn(("operator", "confirm 'done' of /Report", "done"), given)
        self.assertTrue(any("greeting=good morning" in command for _, command, _ in given))

    def log_is_filtered(self):
        """Find lines by severity and by words; what does not fit is not shown, and comes back."""
        lines = self.page.locator(".log .line:visible")
        hint = self.page.locator(".log .line.hint", has_text="The errand says")
        every = lines.count()
        self.press(self.page, "hint")
        expect(hint.first).to_be_hidden()
        expect(self.page.locator(".log .line.info:visible").first).to_be_visible()
        self.press(self.page, "hint")
        self.press(self.page, "info")
        expect(hint.first).to_be_visible()
        expect(self.page.locator(".log .line.info:visible")).to_have_count(0)
        find = self.page.get_by_label("Find in the log")
        find.fill("GOOD morning")
        expect(lines).to_have_count(hint.filter(has_text="good morning").count())
        find.fill("no such line")
        expect(lines).to_have_count(0)
        expect(self.page.locator(".log-tools .soft")).to_contain_text("0 of ")
        find.fill("")
        self.press(self.page, "info")
        self.wait_until(lambda: lines.count() >= every, "all lines")
        with self.page.expect_download() as download:
            self.page.get_by_role("link", name="Export").click()
        self.assertIn("The errand says good morning.", download.value.path().read_text())
        figures = self.page.request.get(f"http://127.0.0.1:{self.port}/metrics").text()
        self.assertIn('remodel_up{part="engine"} 1.0', figures)

    def test_breakpoints_stop_states_also_beside_others_and_values_stand_at_them(self):
        page = self.page
        self.load(page, "Twins")
        self.addCleanup(rospy.set_param, "/flexbe/breakpoints", [])
        for state in ("Both/Second", "Greet"):
            self.pick_drawn(page, state)
            expect(self.state_panel(page).get_by_label("State")).to_have_value(
                state.replace("/", " / ")
            )
            self.press(page, "Breakpoint")
            expect(page.locator(f"li.stopping[data-path='{state}']")).to_have_count(1)
        self.assertEqual(rospy.get_param("/flexbe/breakpoints"), ["/Both/Second", "/Greet"])
        expect(page.locator(".state-hint")).to_contain_text("An unattended run ignores breakpoints")
        page.mouse.click(*self.empty_place(page))
        self.choose(page, "Autonomy", "Full")
        page.get_by_label("greeting").fill("good evening")
        self.press(page, "Start")
        expect(page.locator(".request")).to_contain_text("Leave 'Second' with 'done'?")
        expect(page.locator(".request")).to_have_count(1)
        expect(page.locator(".state-hint")).to_be_hidden()
        other = self.open_page()
        expect(other.locator(".request")).to_contain_text("Leave 'Second' with 'done'?")
        expect(other.locator("li.stopping")).to_have_count(2)
        page.keyboard.press("Alt+c")
        expect(page.locator(".request")).to_contain_text("Leave 'Greet' with 'done'?")
        expect(page.locator(".canvas-values[data-path='Greet']")).to_have_text("datagood evening")
        expect(page.locator(".state-panel table")).to_contain_text("good evening")
        expect(page.locator(".state-panel table th")).to_have_text(["Key", "On entry", "On exit"])
        self.take_picture(page, "runtime-breakpoint")
        self.press(other, "Remove all 2")
        expect(page.locator(".ending")).to_have_text("The last run ended with 'finished'.")
        expect(page.locator(".request")).to_have_count(0)
        expect(page.locator("li.stopping")).to_have_count(0)
        expect(page.locator(".canvas-values")).to_be_hidden()
        self.assertEqual(rospy.get_param("/flexbe/breakpoints"), [])
        commands = [json.loads(line)["command"] for line in self.record.read_text().splitlines()]
        for command in ("set a breakpoint at Both / Second", "remove all breakpoints"):
            self.assertIn(command, commands)

    def test_a_field_of_any_topic_is_plotted_on_all_pages_and_kept(self):
        page = self.page
        publisher = rospy.Publisher("plotted", Vector3, queue_size=1)
        timer = rospy.Timer(rospy.Duration(0.05), lambda _: publisher.publish(Vector3(z=12.5)))
        self.addCleanup(timer.shutdown)
        plots = page.get_by_role("region", name="Plots")
        topic, field = (plots.get_by_role("combobox", name=name) for name in ("Topic", "Field"))
        topic.click()
        expect(page.get_by_role("option").first).to_be_visible()
        topic.fill("/plotted")
        page.get_by_role("option", name="/plotted (geometry_msgs/Vector3)").click()
        expect(field).to_have_value("x")
        self.choose(page, "Field", "z")
        self.press(page, "Plot")
        late = self.open_page()
        for each in (page, late):
            expect(each.locator(".plot-panel .figure")).to_have_text("12.5")
            expect(each.locator(".plot-panel .plot svg")).to_be_visible()
        self.assertEqual(json.loads(self.settings.read_text())["plots"], ["/plotted.z"])
        self.take_picture(page, "runtime-plot")
        # Enter takes what is typed as soon as no option is listed for it.
        field.fill("w")
        expect(page.get_by_role("option")).to_have_count(0)
        field.press("Enter")
        expect(field).to_have_value("w")
        self.press(page, "Plot")
        expect(page.locator(".q-notification")).to_contain_text(
            "geometry_msgs/Vector3 has no number 'w'; its numbers: x, y, z"
        )
        self.press(late, "Remove the plot /plotted.z")
        for each in (page, late):
            expect(each.locator(".plot-panel .plot")).to_have_count(0)
        self.assertEqual(json.loads(self.settings.read_text())["plots"], [])

    def test_attaching_to_what_another_client_has_started(self):
        self.load(self.page, "Errand")
        self.start_elsewhere("Patrol")
        expect(self.page.locator(".attach")).to_contain_text("'Patrol' runs unattended.")
        late = self.open_page()
        expect(late.locator(".attach")).to_contain_text("Load 'Patrol' first: 'Errand' is loaded.")
        expect(late.locator("li.node.active")).not_to_have_count(
            0
        )  # what runs is drawn, not Errand
        self.take_picture(late, "runtime-attach")
        self.press(late, "Load 'Patrol'")
        expect(self.page.locator("li.node.active")).not_to_have_count(0)
        self.press(self.page, "Attach")
        for page in (self.page, late):
            expect(page.get_by_role("button", name="Pause", exact=True)).to_be_visible()
        self.press(late, "Pause")
        expect(self.page.locator(".state")).to_have_text("paused")
        self.page.reload()
        expect(self.page.locator(".state")).to_have_text("paused")
        expect(self.page.locator("li.node.active")).not_to_have_count(0)
        self.press(self.page, "Continue")
        expect(late.locator(".state")).to_have_text("running")
        self.lock(late)
        expect(self.page.locator(".held")).to_be_visible()
        self.press(self.page, "Unlock")
        expect(late.locator(".held")).to_have_count(0)
        self.press(late, "Repeat")
        self.stop(self.page)
        expect(late.locator(".ending")).to_have_text("The last run was stopped.")

    def test_what_runs_goes_on_in_the_version_that_was_saved_meanwhile(self):
        self.load(self.page, "Patrol")
        self.choose(self.page, "Autonomy", "Low")
        self.press(self.page, "Start")
        expect(self.page.get_by_role("button", name="Lock", exact=True)).to_be_visible()
        stop = self.page.get_by_role("button", name="Stop", exact=True)
        place = stop.bounding_box()
        self.lock(self.page)
        self.assertEqual(stop.bounding_box(), place, "Stop moves away from who presses it")
        held = self.page.locator(".held").inner_text()
        editor = self.open_page("/editor")
        self.choose(editor, "Open", "Patrol")
        self.pick_drawn(editor, "North")
        field = editor.locator(".properties").get_by_label("wait_time", exact=True)
        field.fill("0.33")
        field.press("Enter")
        expect(editor.locator(".tools")).to_contain_text("not saved yet")
        self.press(editor, "Save")
        expect(self.page.get_by_text("Another version of 'Patrol' is saved.")).to_be_visible()
        self.press(self.page, "Switch")
        expect(self.page.get_by_text("Another version of 'Patrol' is saved.")).to_have_count(0)
        expect(self.page.locator(".held")).to_have_text(held)
        self.press(self.page, "Unlock")
        expect(self.page.locator(".held")).to_have_count(0)
        expect(self.page.locator("li.node.active")).not_to_have_count(0)
        field.fill("0.34")
        field.press("Enter")
        self.press(editor, "Save")
        expect(self.page.get_by_text("Another version of 'Patrol' is saved.")).to_be_visible()
        for command in ("switch", "unlock"):
            answer = ask(command, "", LIMIT_S)
            self.assertEqual(answer.state, DONE, answer)
        self.assertEqual(ask("switch", "", LIMIT_S).state, FAILED)
        self.stop(self.page)
        self.assertIn("switch to the saved version of 'Patrol'", self.record.read_text())

    def test_an_outcome_is_forced(self):
        self.load(self.page, "Errand")
        self.choose(self.page, "Autonomy", "Low")
        self.press(self.page, "Start")
        # The buttons belong to the active state, which the page may learn after the question.
        expect(self.page.get_by_text("Leave 'Report' with", exact=True)).to_be_visible()
        self.page.locator(".outcomes").get_by_role("button", name="done", exact=True).click()
        expect(self.page.locator(".ending")).to_have_text("The last run ended with 'finished'.")
        self.assertIn("force 'done' of /Report", self.record.read_text())

    def test_each_transition_is_lit(self):
        """`make bench-console` measures how soon."""
        self.load(self.page, "Patrol")
        self.page.evaluate(OBSERVE)
        entered = []
        subscriber = rospy.Subscriber(
            "flexbe/behavior_update",
            String,
            lambda m: entered.append(m.data.rpartition("/")[2]),
            tcp_nodelay=True,
        )
        self.addCleanup(subscriber.unregister)
        self.press(self.page, "Start")

        def lit():
            return [
                path for path in self.page.evaluate("() => window.lit.map(([, at]) => at)") if path
            ]

        self.wait_until(lambda: len(entered) >= 16 and len(lit()) >= 8, "transitions")
        self.assertEqual(set(lit()), {"North", "South"})
        self.assertLessEqual(set(lit()), set(entered))

    def test_a_console_that_restarts_finds_what_waits_for_an_operator(self):
        self.load(self.page, "Errand")
        self.choose(self.page, "Autonomy", "Low")
        self.press(self.page, "Start")
        expect(self.page.locator(".request")).to_be_visible()
        self.page.evaluate("() => { window.isOld = true; }")
        self.kill("console")
        self.start_console()
        self.page.wait_for_function("() => !window.isOld")
        expect(self.page.get_by_role("combobox", name="Autonomy")).to_have_value("Low")
        expect(self.page.locator(".log")).to_contain_text("The errand says hello.")
        expect(self.page.locator(".request")).to_contain_text("Leave 'Report' with 'done'?")
        self.page.keyboard.press("Alt+c")
        expect(self.page.locator(".ending")).to_have_text("The last run ended with 'finished'.")


if __name__ == "__main__":
    rospy.init_node("test_console")
    rostest.rosrun("remodel_console", "test_console", ConsoleTest)
