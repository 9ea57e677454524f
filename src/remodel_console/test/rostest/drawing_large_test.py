#!/usr/bin/env python3
"""A drawing of 1,000 states in the editor, in a real browser."""

import sys
from pathlib import Path
from typing import ClassVar

import rospy
import rostest

sys.path.insert(0, str(Path(__file__).parent))
from drawing_case import DrawingCase

from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart, Outcome, Param, State, Transition

FLAT = 1000  # states; `make bench-drawing` measures how soon they are drawn
DATASET = "(name) => document.querySelector('.canvas-frame').dataset[name]"
DRAWN = """() => {
  const { cy } = document.querySelector('.canvas-frame').drawing;
  return { nodes: cy.nodes().length, edges: cy.edges().length };
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


if __name__ == "__main__":
    rospy.init_node("test_drawing_large")
    rostest.rosrun("remodel_console", "test_drawing_large", DrawingLargeTest)
