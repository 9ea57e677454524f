#!/usr/bin/env python3
"""Time to draw 1,000 states, none in a container, in the editor.

Prints, for each of several pages, the time from the arrival of the chart's parts in the browser
until what is in view is painted, and until the whole drawing is there. The target is 1 s on an
idle machine.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_console/test/rostest"))
from drawing_large_test import DATASET, FLAT, DrawingLargeTest

LIMIT_S = 1.0  # for all, on an idle machine


class Drawing(DrawingLargeTest):
    """The browser tests' set-up, without an engine."""

    has_engine = False

    def draw(self) -> tuple[float, float]:
        """Return when a new page has painted what is in view, and all of the chart [s]."""
        self.page = self.open_page()
        self.open("Flat")
        self.wait_until(lambda: self.page.evaluate(DATASET, "completeMs"))
        view, whole = (self.page.evaluate(DATASET, name) for name in ("drawnMs", "completeMs"))
        return float(view) / 1000, float(whole) / 1000


def main() -> None:
    """Measure once."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pages", type=int, default=5)
    parser.add_argument("--figures", type=Path, help="file of lines of JSON for the docs")
    options = parser.parse_args()
    drawing = Drawing("draw")
    try:
        Drawing.setUpClass()
        drawing.setUp()
        times = [drawing.draw() for _ in range(options.pages)]
    finally:
        drawing.doCleanups()
        Drawing.doClassCleanups()
    load = os.getloadavg()[0]
    figures = [{"what": "load of the machine after", "value": load, "unit": ""}]
    limits = (("in view", None), ("all", LIMIT_S))
    for (what, most), found in zip(limits, zip(*times, strict=True), strict=True):
        words = ", ".join(f"{one:.2f}" for one in found)
        sys.stdout.write(f"{FLAT} states, {what}: median {median(found):.2f} s ({words})\n")
        name = f"{FLAT} states, {what}, median of {len(found)} pages"
        figures.insert(-1, {"what": name, "value": median(found), "unit": "s", "most": most})
    sys.stdout.write(f"load of the machine: {load:.1f} on {os.cpu_count()} cores\n")
    if options.figures:
        options.figures.write_text("".join(f"{json.dumps(one)}\n" for one in figures))


if __name__ == "__main__":
    main()
