#!/usr/bin/env python3
"""Time to draw 1,000 states, none in a container, in the editor.

Prints for each of several pages the time from the arrival of the chart's parts in the browser to
the painted drawing. The target is 1 s on an idle machine.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_console/test/rostest"))
from drawing_test import DATASET, FLAT, DrawingTest


class Drawing(DrawingTest):
    """The browser tests' set-up, without an engine."""

    has_engine = False

    def draw(self) -> float:
        """Return how long a new page takes to draw the chart [s]."""
        self.page = self.open_page()
        self.open("Flat")
        self.drawn(f"Step {FLAT - 1}").wait_for(state="attached")
        self.wait_until(lambda: self.page.evaluate(DATASET, "drawnMs"))
        return float(self.page.evaluate(DATASET, "drawnMs")) / 1000


def main() -> None:
    """Measure once."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pages", type=int, default=5)
    options = parser.parse_args()
    drawing = Drawing("draw")
    try:
        Drawing.setUpClass()
        drawing.setUp()
        times = sorted(drawing.draw() for _ in range(options.pages))
    finally:
        drawing.doCleanups()
        Drawing.doClassCleanups()
    words = ", ".join(f"{one:.2f}" for one in times)
    sys.stdout.write(f"{FLAT} states drawn within {times[len(times) // 2]:.2f} s: {words}\n")


if __name__ == "__main__":
    main()
