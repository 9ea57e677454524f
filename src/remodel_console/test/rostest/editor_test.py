#!/usr/bin/env python3
"""The editor in a real browser: a behavior is put together, synthesized into, checked and saved."""

import sys
from pathlib import Path

import rospy
import rostest
from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from editor_case import EditorCase

BROKEN = """<statemachine name="Broken" initial="A">
  <datamodel><outcome name="finished"/></datamodel>
  <state id="A" type="WaitStat">
    <transition event="done" target="nowhere"/>
  </state>
</statemachine>
"""


class EditorTest(EditorCase):
    def test_a_behavior_is_built_synthesized_into_and_saved(self):
        page = self.page
        self.press(self.page, "New")
        dialog = page.get_by_role("dialog")
        dialog.get_by_label("Name").fill("Built Here")
        expect(dialog).to_contain_text("charts of the package console_test_behaviors")
        self.press(self.page, "Create")
        expect(page.locator(".tools")).to_contain_text("Built Here: not saved yet")
        page.get_by_label("Find a state").fill("log")
        page.locator(".library").get_by_role("button", name="Log", exact=True).click()
        expect(page.get_by_role("dialog")).to_contain_text("-- text")
        self.press(self.page, "Add Log")
        self.pick("Log")
        self.fill("text", "Built by hand.")
        self.add_container()
        page.get_by_text("Use synthesis").click()
        self.choose(page, "Goal", "errand.xml")
        self.press(self.page, "Synthesize")
        expect(page.locator("li.node[data-path='Container/Search/Look']").first).to_be_visible()
        self.pick("Log")
        self.choose(page, "done", "Container", exact=True)
        self.pick("Container")
        self.choose(page, "finished", "finished", exact=True)
        self.choose(page, "failed", "failed", exact=True)
        expect(page.locator(".problems")).to_contain_text("No errors.")
        self.press(page, "Show all")
        self.take_picture(page, "editor")
        self.press(self.page, "Save")
        expect(page.locator(".tools")).to_contain_text("Built Here: saved")
        chart = self.chart("built_here")
        self.assertEqual([node.id for node in chart.nodes], ["Log", "Container"])
        self.assertEqual(chart.nodes[0].params[0].value, "Built by hand.")
        self.assertTrue(list(self.package.rglob("built_here_sm.py")))

    def test_a_chart_that_cannot_be_used_is_shown_with_its_errors(self):
        (self.package / "charts" / "broken.xml").write_text(BROKEN)
        self.addCleanup((self.package / "charts" / "broken.xml").unlink)
        self.page.reload()
        self.open("Errand")
        self.add_container()
        self.page.get_by_text("Use synthesis").click()
        self.choose(self.page, "Goal", "broken.xml")
        self.press(self.page, "Synthesize")
        dialog = self.page.get_by_role("dialog")
        expect(dialog).to_contain_text("3 errors")
        expect(dialog.locator(".xml-error")).not_to_have_count(0)
        self.take_picture(self.page, "editor-refusal")
        self.press(self.page, "Close")

    def test_the_certificate_of_the_chart_as_it_stands_is_shown(self):
        page = self.page
        self.open("Errand")
        page.get_by_role("tab", name="Certificate").click()
        expect(page.locator(".certificate")).to_contain_text("The time of a run has no bound")
        expect(page.locator(".certificate table").first).to_contain_text("visits")
        expect(page.locator(".properties")).to_be_hidden()
        self.take_picture(page, "editor-certificate")
        self.write_xml(BROKEN)
        expect(page.locator(".problems")).to_contain_text("3 errors")
        page.get_by_role("tab", name="Certificate").click()
        expect(page.get_by_text("A chart with errors has no certificate.")).to_be_visible()

    def test_xml_and_drawing_follow_each_other_and_undo_takes_back(self):
        page = self.page
        self.open("Errand")
        text = self.chart("errand")
        self.assertEqual(text.nodes[0].id, "Greet")
        name = page.locator(".properties").get_by_label("Name", exact=True)
        page.locator(".tools .soft").click()
        for key, selected in (("n", "Greet"), ("n", "Search"), ("n", "Look"), ("b", "Search")):
            page.keyboard.press(key)
            expect(name).to_have_value(selected)
        page.keyboard.press("n")
        expect(name).to_have_value("Look")
        self.fill("wait_time", "0.75")
        page.get_by_role("tab", name="XML").click()
        expect(page.locator(".cm-content")).to_contain_text('value="0.75"')
        source = (self.package / "charts" / "errand.xml").read_text()
        self.write_xml(source.replace("Look closer", "Look again"))
        expect(page.locator("li.node[data-path='Search/Look again']").first).to_be_visible()
        self.write_xml(source.replace('target="Report"', 'target="Repot"'))
        expect(page.locator(".problems")).to_contain_text("Repot")
        expect(page.locator(".cm-content .xml-error")).to_have_count(1)
        expect(page.locator("li.node[data-kind=missing]")).to_be_visible()
        self.press(page, "Show all")
        self.take_picture(page, "editor-xml")
        self.write_xml(source.replace("</statemachine>", ""))
        expect(page.locator(".problems .error")).not_to_have_count(0)
        page.keyboard.press("Delete")  # of the text, not of the state that is selected
        page.keyboard.press("?")
        expect(page.locator(".cm-content")).to_contain_text("?")
        expect(page.get_by_role("dialog")).to_have_count(0)
        page.locator(".tools .soft").click()
        page.keyboard.press("Control+z")
        page.keyboard.press("Control+z")
        expect(page.locator("li.node[data-path='Search/Look closer']").first).to_be_visible()

    def test_values_and_what_ends_a_concurrency_container_are_set(self):
        page = self.page
        self.open("Errand")
        page.get_by_label("Input 2: name").fill("count")
        page.get_by_label("Input 2: any type").fill("int")
        page.get_by_label("Input 2: required").fill("3")
        page.get_by_label("Input 2: required").press("Enter")
        expect(page.get_by_label("Input 3: name")).to_be_visible()
        self.pick("Search/Look")
        self.pick("Search")
        self.choose(page, "Execution", "concurrent")
        page.get_by_role("combobox", name="Condition 1: all of").click()
        for name in ("Look: done", "Look closer: done"):
            page.get_by_role("option", name=name, exact=True).click()
        page.get_by_text("It ends when all events of a condition have happened").click()
        expect(page.get_by_role("option")).to_have_count(0)
        self.choose(page, "Condition 1: ends with", "found")
        expect(page.get_by_role("combobox", name="Condition 2: ends with")).to_be_visible()
        expect(page.locator(".problems")).to_contain_text("No errors.")
        page.get_by_role("tab", name="XML").click()
        expect(page.locator(".cm-content")).to_contain_text('<input name="count" type="int"')
        expect(page.locator(".cm-content")).to_contain_text('<ext:condition outcome="found">')

    def test_deleting_and_renaming_keep_what_belongs_together(self):
        self.open("Patrol")
        self.pick("South")
        self.fill("Name", "Far South")
        expect(self.page.locator("li.node[data-path='Far South']").first).to_be_visible()
        self.pick("Far South")
        self.press(self.page, "Delete")
        expect(self.page.locator("li.node[data-path='Far South']")).to_have_count(0)
        expect(self.page.locator(".problems")).to_contain_text("1 error")
        self.press(self.page, "Undo")
        self.press(self.page, "Undo")
        expect(self.page.locator("li.node[data-path='South']").first).to_be_visible()

    def test_new_asks_before_unsaved_changes_are_lost(self):
        self.open("Patrol")
        self.pick("South")
        self.fill("wait_time", "0.8")
        expect(self.page.locator(".tools")).to_contain_text("Patrol: not saved yet")
        self.press(self.page, "New")
        expect(self.page.get_by_role("dialog")).to_contain_text("'Patrol' has unsaved changes.")
        self.press(self.page, "Cancel")
        expect(self.page.get_by_role("dialog")).to_have_count(0)
        expect(self.page.locator(".tools")).to_contain_text("Patrol: not saved yet")
        self.press(self.page, "Undo")
        expect(self.page.locator(".tools")).to_contain_text("Patrol: saved")
        self.press(self.page, "Redo")
        expect(self.page.locator(".tools")).to_contain_text("Patrol: not saved yet")
        self.press(self.page, "Undo")
        self.press(self.page, "New")
        expect(self.page.get_by_role("dialog").get_by_label("Name")).to_be_visible()

    def test_the_autonomy_of_a_transition_is_set(self):
        self.open("Patrol")
        self.pick("South")
        self.choose(self.page, "Autonomy of done", "High")
        self.page.get_by_role("tab", name="XML").click()
        xml = self.page.locator(".cm-content")
        expect(xml).to_contain_text('target="North" ext:autonomy="high"')
        self.page.get_by_role("tab", name="Properties").click()
        self.choose(self.page, "Autonomy of done", "default")
        expect(self.page.locator(".tools")).to_contain_text("Patrol: saved")


if __name__ == "__main__":
    rospy.init_node("test_editor")
    rostest.rosrun("remodel_console", "test_editor", EditorTest)
