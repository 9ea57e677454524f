#!/usr/bin/env python3
"""Load of the console: 200 states at 50 transitions a second, with several pages open.

Prints how late the pages light what is active, and how the memory of the console's node grows.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path

import rospy
from playwright.sync_api import Page
from std_msgs.msg import String

sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_console/test/rostest"))
from browser_test_case import free_port
from console_test import OBSERVE, ConsoleTest

from flexbe_synthesizer.core.codec import write_chart
from flexbe_synthesizer.core.model import Chart, Container, Outcome, Param, State, Transition

BOXES, STATES = 10, 20
VISIT_S = 0.02
LIMIT_S = 0.25  # what a page may lag behind at most
AHEAD_MS = 50.0  # by which a page may learn of a state before this process does


def box(number: int) -> Container:
    """Return a container of states in a row."""
    ids = [f"S{number}_{place}" for place in range(STATES)]
    nodes = tuple(
        State(
            one,
            "WaitState",
            (Transition("done", following),),
            params=(Param("wait_time", VISIT_S),),
        )
        for one, following in zip(ids, (*ids[1:], "through"), strict=True)
    )
    body = Chart(f"Box {number}", ids[0], (Outcome("through"),), nodes)
    following = f"Box {(number + 1) % BOXES}"
    led = (Transition("through", following),)
    if number:
        return Container(f"Box {number}", "container", led, body=body)
    led = (*led, Transition("exhausted", "finished"))
    return Container("Box 0", "container", led, attempts=100000, body=body)


class Load(ConsoleTest):
    """The browser tests' set-up, with a large behavior."""

    @classmethod
    def setUpClass(cls) -> None:
        """Add the large behavior to the charts."""
        chart = Chart("Load", "Box 0", (Outcome("finished"),), tuple(map(box, range(BOXES))))
        cls.more_charts = {"load.xml": write_chart(chart)}
        super(ConsoleTest, cls).setUpClass()

    def measure(self, duration_s: float, page_count: int) -> None:
        """Run the behavior, and print what was seen."""
        entered: dict[str, list[float]] = {}
        rospy.Subscriber(
            "flexbe/behavior_update",
            String,
            lambda m: entered.setdefault(m.data.strip("/"), []).append(1000 * time.time()),
            tcp_nodelay=True,
        )
        self.load(self.page, "Load")
        pages = [self.page, *(self.open_page() for _ in range(page_count - 1))]
        for page in pages:
            page.locator("g.node").first.wait_for()
            page.evaluate(OBSERVE)
        self.press(self.page, "Start")
        node = console_pid(self.port)
        before, begin = resident_mib(node), time.monotonic()
        peak = before
        while time.monotonic() - begin < duration_s:
            self.page.wait_for_timeout(1000)
            peak = max(peak, resident_mib(node))
        lags = sorted(lag for page in pages for lag in lags_s(page, entered))
        count = sum(map(len, entered.values()))
        self.stop(self.page)
        sys.stdout.write(
            f"{count / duration_s:.0f} transitions/s for {duration_s:.0f} s, {page_count} pages\n"
            f"lag of the pages: median {at(lags, 0.5):.3f} s, 99 % within {at(lags, 0.99):.3f} s, "
            f"worst {lags[-1]:.3f} s (limit {LIMIT_S} s)\n"
            f"memory of the node: {before:.0f} MiB at the start, at most {peak:.0f} MiB\n"
        )


def lags_s(page: Page, entered: dict[str, list[float]]) -> list[float]:
    """Return how late each state was lit that a page has shown [s]."""
    lags = []
    for seen_ms, path in page.evaluate("() => window.lit"):
        times = [at for at in entered.get(path, ()) if at <= seen_ms + AHEAD_MS]
        if times:
            lags.append(max(0.0, seen_ms - times[-1]) / 1000)
    return lags


def at(ordered: list[float], share: float) -> float:
    """Return the value that a share of all is not above."""
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def console_pid(port: int) -> int:
    """Return the process that was started with a port."""
    found = subprocess.run(
        ["pgrep", "-f", f"console --port {port}"], capture_output=True, text=True, check=True
    )
    return max(map(int, found.stdout.split()))


def resident_mib(pid: int) -> float:
    """Return the resident memory of a process."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def main() -> None:
    """Measure once, on a roscore of its own."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--pages", type=int, default=1)
    options = parser.parse_args()
    port = free_port()
    os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
    core = subprocess.Popen(["roscore", "-p", str(port)], stdout=subprocess.DEVNULL)
    load = Load("measure")
    try:
        rospy.init_node("load")
        Load.setUpClass()
        load.setUp()
        load.measure(options.seconds, options.pages)
    finally:
        load.doCleanups()
        Load.doClassCleanups()
        core.terminate()
        core.wait(20)


if __name__ == "__main__":
    main()
