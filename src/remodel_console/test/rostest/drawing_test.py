#!/usr/bin/env python3
"""The drawing of the editor in a real browser: built by dragging, moved, copied, searched, run."""

import contextlib
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import rospy
import rostest
from playwright.sync_api import Error, expect

sys.path.insert(0, str(Path(__file__).parent))
from drawing_case import DrawingCase

from flexbe_synthesizer.core.chart.model import Transition

MOST_CLICKS, MOST_FIELDS = 8, 2
CENTRE = """(path) => {
  const { x, y } = document.querySelector('.canvas-frame').drawing.byPath.get(path).position();
  return [x, y];
}"""
COLOUR = """(event) => {
  const edges = document.querySelector('.canvas-frame').drawing.cy.edges();
  return edges.filter((edge) => edge.data('label').startsWith(event)).first().style('line-color');
}"""
ARROWS = "() => document.querySelector('.canvas-frame').drawing.cy.edges(':visible').length"
FLOWS = """() => document.querySelector('.canvas-frame').drawing.cy.edges('.flow')
  .filter((edge) => edge.visible()).map((edge) => edge.data('label'))"""


class DrawingTest(DrawingCase):
    def drag_from_library(self, name):
        entry = self.page.locator(".library").get_by_role("button", name=name, exact=True)
        entry.drag_to(self.page.locator(".canvas-stage"), target_position={"x": 120, "y": 300})

    def drag_outcome(self, state, event, target):
        """Drag an outcome of a state to where it leads."""
        handle = self.page.get_by_label(f"Outcome {event} of {state}", exact=True)

        def is_there():
            self.page.mouse.move(*self.where(self.page, state))
            with contextlib.suppress(Error):  # drawn again just now
                handle.hover(timeout=2000)
                return True
            return False

        self.wait_until(is_there, event)
        self.page.mouse.down()
        self.page.mouse.move(*self.where(self.page, target), steps=4)
        self.page.mouse.up()
        edge = f".canvas-outline li.edge[data-source='{state}'][data-target='{target}']"
        expect(self.page.locator(edge)).to_have_count(1)

    def xml_contains(self, text):
        self.page.get_by_role("tab", name="XML").click()
        expect(self.page.locator(".cm-content")).to_contain_text(text)

    def test_two_states_and_a_connection_run_after_8_clicks_and_2_fields(self):
        page, clicks, fields = self.page, 0, 0
        self.press(page, "New")
        clicks += 1
        page.get_by_role("dialog").get_by_label("Name").fill("Two Steps")
        fields += 1
        page.keyboard.press("Enter")
        expect(page.locator(".tools")).to_contain_text("Two Steps: not saved yet")
        self.drag_from_library("Wait")
        clicks += 1
        wait_time = page.locator(".properties").get_by_label("wait_time", exact=True)
        expect(wait_time).to_be_focused()
        page.keyboard.type("0.1")
        fields += 1
        page.keyboard.press("Enter")
        self.wait_until(lambda: not wait_time.evaluate("(one) => one === document.activeElement"))
        expect(page.get_by_label("Outcome done of Wait", exact=True)).to_be_visible()
        page.keyboard.press("Control+c")
        page.keyboard.press("Control+v")
        expect(page.locator(".properties").get_by_label("Name", exact=True)).to_have_value("Wait 2")
        self.drawn("Wait 2").wait_for(state="attached")
        self.drag_outcome("Wait 2", "done", "finished")
        clicks += 1
        self.drag_outcome("Wait", "done", "Wait 2")
        clicks += 1
        expect(page.locator(".problems")).to_contain_text("No errors.")
        self.take_picture(page, "editor-dragged")
        self.press(page, "Run")
        clicks += 1
        self.press(page, "Start")
        clicks += 1
        expect(page.locator(".ending")).to_have_text("The last run ended with 'finished'.")
        self.assertLessEqual((clicks, fields), (MOST_CLICKS, MOST_FIELDS))
        first, second = self.chart("two_steps").nodes
        self.assertEqual(first.transitions, (Transition("done", "Wait 2"),))
        self.assertEqual(second.params[0].value, 0.1)

    def test_where_a_state_is_put_is_kept_in_the_chart(self):
        page = self.page
        self.open("Patrol")
        x, y = self.where(page, "South")
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 120, y + 60, steps=5)
        page.mouse.up()
        expect(page.locator(".tools")).to_contain_text("Patrol: not saved yet")
        self.xml_contains("ext:at=")
        page.get_by_role("tab", name="Changes").click()
        expect(page.locator(".changes .added").first).to_contain_text("ext:at=")
        expect(page.locator(".changes .removed").first).not_to_contain_text("ext:at=")
        self.take_picture(page, "editor-changes")
        placed = page.evaluate(CENTRE, "South")
        page.reload()
        expect(page.locator(".tools")).to_contain_text("Patrol: not saved yet")
        self.where(page, "South")
        self.assertEqual(page.evaluate(CENTRE, "North")[0] < placed[0], True)
        self.press(page, "Arrange")
        expect(page.locator(".tools")).to_contain_text("Patrol: saved")

    def test_several_states_are_copied_with_what_connects_them_and_deleted(self):
        page = self.page
        self.open("Patrol")
        self.pick_both("North", "South")
        page.keyboard.press("Control+c")
        page.keyboard.press("Control+v")
        expect(self.drawn("South 2")).to_have_class("node selected")
        edge = ".canvas-outline li.edge[data-source='North 2'][data-target='South 2']"
        expect(page.locator(edge)).to_have_count(1)
        page.keyboard.press("Delete")
        expect(self.drawn("South 2")).to_have_count(0)
        expect(self.drawn("North 2")).to_have_count(0)
        page.keyboard.press("Control+z")
        expect(self.drawn("North 2")).to_have_count(1)
        page.keyboard.press("Control+y")
        expect(self.drawn("North 2")).to_have_count(0)

    def test_a_behavior_is_described_grouped_and_saved_under_another_name(self):
        page = self.page
        self.open("Errand")
        description = page.get_by_label("Description", exact=True)
        description.fill("Says good day, and looks twice.")
        description.blur()
        self.xml_contains("Says good day, and looks twice.")
        page.get_by_role("tab", name="Properties").click()
        for label, text in (("Author", "Ada"), ("Tags", "demo, wires")):
            field = page.locator(".properties").get_by_label(label, exact=True)
            field.fill(text)
            field.press("Enter")
            self.xml_contains(f'ext:{label.lower()}="{text}"')
            page.get_by_role("tab", name="Properties").click()
        self.pick_both("Greet", "Search")
        page.keyboard.press("Control+g")
        self.drawn("Group/Search/Look").wait_for(state="attached")
        expect(page.locator(".problems")).to_contain_text("No errors.")
        self.take_picture(page, "editor-group")
        self.press(page, "Save as")
        name = page.get_by_role("dialog").get_by_label("Name")
        name.fill("Patrol")
        page.keyboard.press("Enter")
        expect(page.locator(".q-notification")).to_contain_text("'Patrol' already")
        name.fill("Second Errand")
        page.keyboard.press("Enter")
        expect(page.locator(".tools")).to_contain_text("Second Errand: saved")
        copy, first = self.chart("second_errand"), self.chart("errand")
        self.assertEqual(copy.name, "Second Errand")
        self.assertEqual(copy.description, "Says good day, and looks twice.")
        self.assertEqual((copy.author, copy.tags), ("Ada", "demo, wires"))
        manifest = (self.package / "manifest" / "second_errand.xml").read_text()
        self.assertIn("<tagstring>demo, wires</tagstring>", manifest)
        self.assertEqual([node.id for node in copy.nodes], ["Group", "Report"])
        self.assertEqual([node.id for node in copy.nodes[0].body.nodes], ["Greet", "Search"])
        self.assertEqual([port.name for port in copy.nodes[0].body.inputs], ["greeting"])
        self.assertEqual([node.id for node in first.nodes], ["Greet", "Search", "Report"])
        self.assertIn("cautious operator", first.description)

    def test_states_are_found_by_id_type_and_parameter(self):
        self.open("Errand")
        self.page.keyboard.press("Control+f")
        find = self.page.get_by_label("Find in the chart")
        expect(find).to_be_focused()
        for word, paths in (
            ("look", ("Search/Look", "Search/Look closer")),
            ("done.", ("Report",)),
        ):
            find.fill(word)
            for path in paths:
                find.press("Enter")
                expect(self.drawn(path)).to_have_class("node selected")
        find.fill("LogKeyState")
        expect(self.page.locator(".matches")).to_have_text("1 found")
        find.fill("nowhere")
        expect(self.page.locator(".matches")).to_have_text("nothing found")

    def test_data_flow_and_autonomy_are_drawn(self):
        page = self.page
        self.open("Errand")
        self.where(page, "Greet")
        self.assertEqual(page.evaluate(FLOWS), [])
        expect(page.locator(".canvas-outline li.flow")).to_have_text(
            "the inputs: greeting is read by Greet"
        )
        self.press(page, "Data flow")
        self.wait_until(lambda: page.evaluate(FLOWS) == ["greeting"], "the data flow")
        self.take_picture(page, "editor-data-flow")
        asked, free = page.evaluate(COLOUR, "done · high"), page.evaluate(COLOUR, "found")
        self.assertNotEqual(asked, free)

    def test_a_problem_is_shown_at_its_state_and_corrected_by_a_click(self):
        page = self.page
        self.open("Patrol")
        source = (self.package / "charts" / "patrol.xml").read_text()
        self.write_xml(source.replace('target="South"', 'target="Sout"'))
        expect(page.locator(".problems")).to_contain_text("1 error")
        expect(self.drawn("North")).not_to_have_attribute("data-problems", "0")
        expect(page.locator("li.node[data-kind=missing]")).to_have_count(1)
        self.take_picture(page, "editor-problems")
        self.press(page, "Connect 'done' to 'South'")
        expect(page.locator(".problems")).to_contain_text("No errors.")
        expect(self.drawn("North")).to_have_attribute("data-problems", "0")

    def test_the_drawing_is_downloaded_as_a_picture(self):
        self.open("Errand")
        self.where(self.page, "Greet")
        found = {}
        for kind in ("png", "svg"):
            with self.page.expect_download() as download:
                self.press(self.page, f"Download the picture as {kind.upper()}")
            self.assertEqual(download.value.suggested_filename, f"Errand.{kind}")
            found[kind] = Path(download.value.path()).read_bytes()
        self.assertEqual(found["png"][:4], b"\x89PNG")
        svg = ElementTree.fromstring(found["svg"])
        words = [text.text for text in svg.iter("{http://www.w3.org/2000/svg}text")]
        for shown in ("Greet", "LogKeyState", "Search", "Look closer", "failed", "done · high"):
            self.assertIn(shown, words)
        self.assertNotIn("greeting", words, "the data flow is not shown")
        arrows = list(svg.iter("{http://www.w3.org/2000/svg}polygon"))
        self.assertEqual(len(arrows), self.page.evaluate(ARROWS))


if __name__ == "__main__":
    rospy.init_node("test_drawing")
    rostest.rosrun("remodel_console", "test_drawing", DrawingTest)
