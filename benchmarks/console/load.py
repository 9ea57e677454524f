#!/usr/bin/env python3
"""Load of the console: 200 states at 50 transitions a second, on a roscore of its own.

load.py [--seconds 300] [--figures FILE]; the workspace must be sourced. Measures how fast the
engine is without the console and with it, how late a page lights what is active, and how the memory
of the console's node grows.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import rospy
from flexbe_msgs.msg import BEStatus
from std_msgs.msg import Empty, String

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_console/test/rostest"))
from console_case import ConsoleCase
from console_test import OBSERVE
from figures import Figure, add_figures_option, report
from large_chart import large_chart

from flexbe_synthesizer.core.chart.chart_writer import write_chart
from remodel_console.testing.browser_test import free_port

VISIT_S = 0.02
# What a page may lag behind at most; by which percentage the engine may be slower with the console.
LIMIT_S, SLOWER = 0.1, 5.0
WARM_S = 10.0  # before the memory of the node is measured
WAIT_S = 30.0
AHEAD_MS = 500.0  # by which a page may learn of a state before this process does, which may be busy
# Time [ms] and path of each state that a page has shown.
Seen = list[tuple[float, str]]


class Load(ConsoleCase):
    """The browser tests' set-up, with a large behavior."""

    @classmethod
    def setUpClass(cls) -> None:
        """Add the large behavior to the charts."""
        cls.more_charts = {"load.xml": write_chart(large_chart("Load", VISIT_S))}
        super().setUpClass()

    def setUp(self) -> None:
        """Listen to what the engine enters."""
        self.entered: dict[str, list[float]] = {}
        self.count = 0
        rospy.Subscriber("flexbe/behavior_update", String, self.take, tcp_nodelay=True)

    def take(self, message: String) -> None:
        """Count a transition."""
        self.count += 1
        self.entered.setdefault(message.data.strip("/"), []).append(1000 * time.time())

    def wait_until(self, is_so: Callable[[], bool]) -> None:
        """Wait for a condition; no page is there yet."""
        wait_until(is_so)

    def measure(self, duration_s: float) -> Iterator[Figure]:
        """Yield the figures."""
        self.kill("console")
        alone = self.rate_without_console(max(10.0, duration_s / 10))
        self.start_console()
        super().setUp()
        self.load(self.page, "Load")
        self.page.locator("li.node").first.wait_for()
        self.press(self.page, "Start")
        self.page.evaluate(OBSERVE)
        self.page.wait_for_timeout(1000 * min(WARM_S, duration_s / 3))
        node, memory = console_pid(self.port), []
        self.entered.clear()
        count, begin_s, begin_cpu_s = self.count, time.monotonic(), cpu_s(node)
        while time.monotonic() - begin_s < duration_s:
            self.page.wait_for_timeout(1000)
            memory.append(resident_mib(node))
        took_s = time.monotonic() - begin_s
        slower = 100 * (1 - (self.count - count) / took_s / alone)
        share = 100 * (cpu_s(node) - begin_cpu_s) / took_s
        lags = sorted(self.lags_of(self.page.evaluate("() => window.lit")))
        if not lags:
            raise SystemExit("the page has lit nothing")
        yield Figure("lag of one page, median", at(lags, 0.5), "s")
        yield Figure("lag of one page, 99 % within", at(lags, 0.99), "s")
        yield Figure(f"lag of one page, worst of {took_s:.0f} s", lags[-1], "s", most=LIMIT_S)
        yield Figure("memory that the node gains meanwhile", memory[-1] - memory[0], "MiB")
        yield Figure("processor of the node, one page", share, "% of a core")
        yield Figure("engine slowed down by console and page", slower, "%", most=SLOWER)
        self.stop(self.page)

    def rate_without_console(self, duration_s: float) -> float:
        """Return the engine's speed [transitions/s] with nothing but the mirror."""
        status = []
        rospy.Subscriber("flexbe/status", BEStatus, lambda message: status.append(message.code))
        preempt = rospy.Publisher("flexbe/command/preempt", Empty, queue_size=1)
        self.start_elsewhere("Load")
        count = self.count
        wait_until(lambda: self.count > count)
        count, begin_s = self.count, time.monotonic()
        time.sleep(duration_s)
        rate = (self.count - count) / (time.monotonic() - begin_s)
        preempt.publish()
        wait_until(lambda: BEStatus.FINISHED in status)
        return rate

    def lags_of(self, seen: Seen) -> Iterator[float]:
        """Yield how late each state was shown that a page has shown [s]."""
        for seen_ms, path in seen:
            times = [at for at in self.entered.get(path, ()) if at <= seen_ms + AHEAD_MS]
            if times:
                yield max(0.0, seen_ms - times[-1]) / 1000


def at(ordered: list[float], share: float) -> float:
    """Return the value that a share of all is not above."""
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def wait_until(is_so: Callable[[], bool]) -> None:
    """Wait for a condition, with a limit."""
    end_s = time.monotonic() + WAIT_S
    while not is_so():
        if time.monotonic() > end_s:
            raise TimeoutError("waited too long for the engine")
        time.sleep(0.02)


def console_pid(port: int) -> int:
    """Return the process that was started with a port."""
    line = ["pgrep", "-f", f"console --port {port}"]
    return max(map(int, subprocess.check_output(line, text=True).split()))


def cpu_s(pid: int) -> float:
    """Return the processor time that a process has taken [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def resident_mib(pid: int) -> float:
    """Return the resident memory of a process."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def main() -> int:
    """Measure once; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=300.0)
    add_figures_option(parser)
    options = parser.parse_args()
    port = free_port()
    os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
    core = subprocess.Popen(["roscore", "-p", str(port)], stdout=subprocess.DEVNULL)
    load = Load("measure")
    before = Figure("load of the machine before", os.getloadavg()[0])
    try:
        rospy.init_node("load")
        Load.setUpClass()
        load.setUp()
        figures = load.measure(options.seconds)
        return 0 if report((*figures, before), options.figures) else 1
    finally:
        load.doCleanups()
        Load.doClassCleanups()
        core.terminate()
        core.wait(20)


if __name__ == "__main__":
    sys.exit(main())
