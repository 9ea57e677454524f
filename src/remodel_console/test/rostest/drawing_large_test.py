#!/usr/bin/env python3
"""The drawing of the editor in a busy browser, and with 1,000 states."""

import re
import sys
from pathlib import Path
from typing import ClassVar

import rospy
import rostest
from playwright.sync_api import expect

sys.path.insert(0, str(Path(__file__).parent))
from drawing_case import DrawingCase

from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart, Outcome, Param, State, Transition

FLAT = 1000  # states
DATASET = "(name) => document.querySelector('.canvas-frame').dataset[name]"
DRAWN = """() => {
  const { cy } = document.querySelector('.canvas-frame').drawing;
  return { nodes: cy.nodes().length, edges: cy.edges().length };
}"""
# A busy browser paints late; what a list shows comes then, and Quasar has placed it before.
LATE = """() => {
  window.requestAnimationFrame = (deed) => setTimeout(() => deed(performance.now()), 1500);
}"""
# On a busy page the answer to a first click comes between a second one and what that asks for.
BUSY = """() => {
  const { drawing } = document.querySelector('.canvas-frame');
  const { select } = drawing;
  const later = window.setTimeout.bind(window);
  let clicks = 0;
  let answers = 0;
  const once = (isSo, deed) => (isSo() ? deed() : later(() => once(isSo, deed), 20));
  drawing.select = (...all) => once(() => clicks > 1, () => {
    select(...all);
    answers += 1;
  });
  window.setTimeout = (deed, wait, ...more) => {
    if (!String(deed).includes('picked')) return later(deed, wait, ...more);
    clicks += 1;
    const isFirst = clicks === 1;
    return later(() => once(() => isFirst || answers > 0, deed), wait);
  };
}"""
# Pairs of labels of arrows that lie over each other.
COVERED = """() => {
  const edges = document.querySelector('.canvas-frame').drawing.cy.edges('[label]');
  const boxes = edges.map((edge) => [edge.data('label'),
    edge.boundingBox({ includeEdges: false, includeNodes: false, includeOverlays: false })]);
  return boxes.flatMap(([a, one], place) => boxes.slice(place + 1).filter(([, other]) =>
    one.x1 < other.x2 && other.x1 < one.x2 && one.y1 < other.y2 && other.y1 < one.y2)
    .map(([b]) => `${a} ${b}`));
}"""


def flat_chart(count):
    """Return a chart of so many states in a row, each of which can also fail."""
    ids = [f"Step {number}" for number in range(count)]
    nodes = tuple(
        State(
            one,
            "WaitState",
            (Transition("done", following),),
            params=(Param("wait_time", 0.0),),
        )
        for one, following in zip(ids, (*ids[1:], "finished"), strict=True)
    )
    return Chart("Flat", ids[0], (Outcome("finished"),), nodes)


class DrawingLargeTest(DrawingCase):
    more_charts: ClassVar = {"flat.xml": write_chart(flat_chart(FLAT))}

    def test_1000_states_are_drawn(self):
        self.open("Flat")
        self.drawn(f"Step {FLAT - 1}").wait_for(state="attached")
        self.wait_until(lambda: self.page.evaluate(DATASET, "completeMs"))
        first, whole = (float(self.page.evaluate(DATASET, n)) for n in ("drawnMs", "completeMs"))
        self.assertLess(first, whole)
        self.assertEqual(self.page.evaluate(DRAWN), {"nodes": FLAT + 2, "edges": FLAT + 1})
        self.take_picture(self.page, "editor-1000-states")

    def test_a_list_that_a_busy_browser_fills_late_is_seen(self):
        self.page.evaluate(LATE)
        self.open("Errand")

    def test_charts_are_offered_before_the_page_has_heard_from_the_console(self):
        page = self.browser.new_context().new_page()
        self.addCleanup(page.context.close)
        page.route_web_socket(re.compile("socket.io"), lambda silent: None)
        page.goto(f"http://127.0.0.1:{self.port}/editor")
        page.get_by_role("combobox", name="Open").click()
        expect(page.get_by_role("option", name="Errand", exact=True)).to_be_visible()

    def test_no_label_of_an_arrow_covers_another(self):
        self.choose(self.page, "Open", "Survey")
        self.where(self.page, "Judge")
        self.assertEqual(self.page.evaluate(COVERED), [])

    def test_a_state_picked_before_the_answer_to_the_last_pick_stays_selected(self):
        page = self.page
        self.open("Patrol")
        self.where(page, "North")
        page.evaluate(BUSY)
        self.pick_drawn(page, "North")
        page.keyboard.down("Shift")
        self.pick_drawn(page, "South")
        page.keyboard.up("Shift")
        expect(page.locator(".canvas-outline li.selected")).to_have_count(2)


if __name__ == "__main__":
    rospy.init_node("test_drawing_large")
    rostest.rosrun("remodel_console", "test_drawing_large", DrawingLargeTest)
