#!/usr/bin/env python3
"""The editor with several pages, after a restart, and with 200 states."""

import sys
from pathlib import Path
from typing import ClassVar

import rospy
import rostest
from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from editor_case import EditorCase
from large_chart import BOXES, STATES, large_chart

from flexbe_synthesizer.core.chart.chart_writer import write_chart
from remodel_console.core.commands import DONE
from remodel_console.ros.calls import ask
from remodel_console.testing.browser_test import LIMIT_S

SCALE = "() => document.querySelector('.canvas-frame').drawing.scale()"
READABLE = 0.6  # [screen pixels per unit of the drawing] of the largest drawings, in canvas.js


class EditorSessionsTest(EditorCase):
    more_charts: ClassVar = {"large.xml": write_chart(large_chart("Large", 0.02))}

    def test_each_page_has_a_session_of_its_own_which_a_reload_continues(self):
        self.open("Patrol")
        other = self.open_page("/editor", width=1024, height=768)
        self.choose(other, "Open", "Errand")
        expect(other.locator(".properties .title", has_text="Errand")).to_be_visible()
        self.take_picture(other, "editor-1024")
        self.assertEqual(ask("load Errand", "", LIMIT_S).state, DONE)
        self.pick("South")
        self.fill("wait_time", "0.9")
        expect(self.page.locator(".tools")).to_contain_text("Patrol: not saved yet")
        expect(other.locator(".tools")).to_contain_text("Errand: saved")
        self.page.reload()
        expect(self.page.locator(".tools")).to_contain_text("Patrol: not saved yet")
        self.page.goto(f"http://127.0.0.1:{self.port}/overview")
        later = self.open_page("/editor")
        later.locator(".left-unsaved", has_text="Patrol").get_by_role("link").last.click()
        expect(later.locator(".tools")).to_contain_text("Patrol: not saved yet")

    def test_two_pages_of_one_chart_know_of_each_other_and_neither_undoes_the_other(self):
        self.open("Survey")
        other = self.open_page("/editor")
        self.choose(other, "Open", "Survey")
        for page in (self.page, other):
            expect(page.locator(".tools")).to_contain_text("Also open by operator")
        self.type_description(self.page, "The first one.")
        self.press(self.page, "Save")
        expect(self.page.locator(".tools")).to_contain_text("Survey: saved")
        self.type_description(other, "The second one.")
        self.press(other, "Save")
        dialog = other.get_by_role("dialog")
        expect(dialog).to_contain_text("was changed elsewhere")
        expect(dialog.locator(".removed", has_text="The first one.")).to_be_visible()
        expect(dialog.locator(".added", has_text="The second one.")).to_be_visible()
        self.take_picture(other, "editor-conflict")
        self.press(dialog, "Save as")
        other.get_by_label("Name", exact=True).fill("Survey 2")
        self.press(other.get_by_role("dialog").last, "Save")
        expect(other.locator(".tools")).to_contain_text("Survey 2: saved")
        expect(self.page.locator(".tools")).not_to_contain_text("Also open")

    def type_description(self, page, text):
        field = page.get_by_label("Description")
        field.fill(text)
        field.blur()
        expect(page.locator(".tools")).to_contain_text("not saved yet")

    def test_what_is_configured_counts_at_once_and_outlives_a_restart(self):
        self.start(
            "synthesizer", "flexbe_synthesizer", "synthesis_server", f"_output:={self.package}"
        )
        self.open("Errand")
        self.add_container()
        expect(self.page.get_by_text("Use synthesis")).to_be_visible()
        page = self.open_page("/configuration")
        page.get_by_text("Enable synthesis").click()
        expect(self.page.get_by_text("Use synthesis")).to_have_count(0)
        page.get_by_text("Enable synthesis").click()
        page.get_by_label("Action topic").fill("flexbe/synthesize")
        page.get_by_label("System").fill("Panda 1")
        page.get_by_label("Command key").fill("secret")
        page.get_by_label("Command key").press("Enter")
        page.get_by_label("More folders").fill("/etc")
        page.get_by_label("More folders").blur()
        expect(page.get_by_text("/etc lies neither in the home folder")).to_be_visible()
        page.get_by_role("button", name="OK").click()
        page.get_by_label("More folders").fill(str(self.package / "charts"))
        page.get_by_label("More folders").blur()
        expect(page.get_by_text("Saved.", exact=True)).to_be_visible()
        self.take_picture(page, "configuration")
        self.page.get_by_text("Use synthesis").click()
        self.choose(self.page, "Goal", "patrol.xml")
        self.press(self.page, "Synthesize")
        expect(self.page.locator("li.node[data-path='Container/North']").first).to_be_visible()
        self.kill("console")
        self.start_console()
        page = self.open_page("/configuration", width=1024, height=768)
        expect(page.get_by_label("Action topic")).to_have_value("flexbe/synthesize")
        expect(page.get_by_label("System")).to_have_value("Panda 1")
        expect(page.get_by_label("Command key")).to_have_value("secret")
        expect(page.get_by_label("More folders")).to_have_value(str(self.package / "charts"))
        record = self.record.read_text()
        self.assertIn("configure: synthesis_topic = 'flexbe/synthesize'", record)
        self.assertNotIn("secret", record)

    def test_200_states_are_drawn_so_that_they_can_be_read(self):
        page = self.page
        self.open("Large")
        states = page.locator("li.node[data-path*='Box']")
        expect(states).to_have_count(BOXES)
        self.press(page, "Show all")  # once: what is drawn then is readable again
        self.pick_drawn(page, "Box 4")
        expect(states).to_have_count(BOXES - 1 + STATES)  # closed containers; states
        self.assertGreater(page.evaluate(SCALE), 0.99 * READABLE)
        self.pick_drawn(page, "Box 4/S4_7")
        self.take_picture(page, "editor-200-states")


if __name__ == "__main__":
    rospy.init_node("test_editor_sessions")
    rostest.rosrun("remodel_console", "test_editor_sessions", EditorSessionsTest)
