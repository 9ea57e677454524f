#!/usr/bin/env python3
"""Load of the console: 200 states at 50 transitions a second.

Prints how fast the engine is without the console and with it, how late a page lights what is
active, how the memory of the console's node grows, and how late several pages are. With
`--unpainted`: how late a state arrives at the web sockets of pages that paint nothing.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import rospy
from flexbe_msgs.msg import BEStatus
from playwright.sync_api import Page
from std_msgs.msg import Empty, String

sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_console/test/rostest"))
from console_case import ConsoleCase
from console_test import OBSERVE
from large_chart import large_chart

from flexbe_synthesizer.core.chart.chart_writer import write_chart
from remodel_console.testing.browser_test import free_port

VISIT_S = 0.02
# What a page may lag behind at most: one alone, and each of several.
LIMIT_S, LIMIT_OF_MANY_S = 0.1, 0.3
SLOWER = 0.05  # by which the engine may be slower with the console
WARM_S = 10.0  # before the memory of the node is measured
WAIT_S = 30.0
SOCKET_PAGES = Path(__file__).with_name("socket_pages.py")
# Time [ms] and path of each state that a page has shown.
Seen = list[tuple[float, str]]
AHEAD_MS = 500.0  # by which a page may learn of a state before this process does, which may be busy


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
        self.figures: list[dict[str, object]] = []
        rospy.Subscriber("flexbe/behavior_update", String, self.take, tcp_nodelay=True)

    def keep(self, what: str, value: float, unit: str, most: float | None = None) -> None:
        """Keep a figure for the docs."""
        self.figures.append({"what": what, "value": value, "unit": unit, "most": most})

    def keep_lags(self, many: str, seen: list[Seen], duration_s: float, limit_s: float) -> None:
        """Print how late pages have shown what was active, and keep the figures."""
        lags = sorted(lag for page in seen for lag in lags_s(page, self.entered))
        report(f"{many} for {duration_s:.0f} s: {lag_words(lags, limit_s)}")
        if lags:
            self.keep(f"lag of {many}, median", at(lags, 0.5), "s")
            self.keep(f"lag of {many}, 99 % within", at(lags, 0.99), "s")
            self.keep(f"lag of {many}, worst of {duration_s:.0f} s", lags[-1], "s", limit_s)

    def take(self, message: String) -> None:
        """Count a transition."""
        self.count += 1
        self.entered.setdefault(message.data.strip("/"), []).append(1000 * time.time())

    def wait_until(self, is_so: Callable[[], bool]) -> None:
        """Wait for a condition; no page is there yet."""
        wait_until(is_so)

    def measure(self, duration_s: float, page_count: int) -> None:
        """Print the figures."""
        short_s = max(10.0, duration_s / 10)
        self.kill("console")
        alone = self.rate_without_console(short_s)
        self.start_console()
        super().setUp()
        with_console = self.rate_and_lag(duration_s)
        report(
            f"engine: {alone:.2f} transitions/s without the console, {with_console:.2f} with it "
            f"and a page: {with_console / alone - 1:+.1%} (limit {-SLOWER:.0%})"
        )
        self.keep(
            "engine slowed down by console and page", 100 * (1 - with_console / alone), "%", 5
        )
        self.many_pages(short_s, page_count)
        self.stop(self.page)

    def rate_without_console(self, duration_s: float) -> float:
        """Return the engine's speed [transitions/s] with nothing but the mirror."""
        with self.running_elsewhere():
            return self.rate(duration_s)

    @contextmanager
    def running_elsewhere(self) -> Iterator[None]:
        """Run the behavior without a page."""
        preempt = rospy.Publisher("flexbe/command/preempt", Empty, queue_size=1)
        status = []
        rospy.Subscriber("flexbe/status", BEStatus, lambda m: status.append(m.code))
        self.start_elsewhere("Load")
        yield
        preempt.publish()
        wait_until(lambda: BEStatus.FINISHED in status)

    def rate(self, duration_s: float) -> float:
        """Return the transitions per second from the next one on."""
        count = self.count
        wait_until(lambda: self.count > count)
        count, begin_s = self.count, time.monotonic()
        time.sleep(duration_s)
        return (self.count - count) / (time.monotonic() - begin_s)

    def rate_and_lag(self, duration_s: float) -> float:
        """Run the behavior from a page, print what was seen, and return the engine's speed."""
        self.load(self.page, "Load")
        self.page.locator("li.node").first.wait_for()
        self.press(self.page, "Start")
        self.page.evaluate(OBSERVE)
        node = console_pid(self.port)
        self.page.wait_for_timeout(1000 * min(WARM_S, duration_s / 3))
        self.entered.clear()
        count, begin_s, begin_cpu_s = self.count, time.monotonic(), cpu_s(node)
        memory = []
        while time.monotonic() - begin_s < duration_s:
            self.page.wait_for_timeout(1000)
            memory.append(resident_mib(node))
        took_s = time.monotonic() - begin_s
        rate = (self.count - count) / took_s
        self.keep_lags("one page", lit([self.page]), took_s, LIMIT_S)
        share = (cpu_s(node) - begin_cpu_s) / took_s
        self.keep("memory that the node gains meanwhile", memory[-1] - memory[0], "MiB")
        self.keep("processor of the node, one page", 100 * share, "% of a core")
        report(
            f"{rate:.0f} transitions/s; memory of the node: {memory[0]:.1f} MiB, after "
            f"{took_s:.0f} s {memory[-1]:.1f} MiB, at most {max(memory):.1f} MiB; "
            f"{share:.0%} of a core",
        )
        return rate

    def many_pages(self, duration_s: float, page_count: int) -> None:
        """Open more pages, and print how late they are, and that they all live."""
        pages = [self.page, *(self.open_page() for _ in range(page_count - 1))]
        for page in pages:
            page.locator("li.node").first.wait_for()
            page.evaluate(OBSERVE)
        self.entered.clear()
        node = console_pid(self.port)
        begin_s, begin_cpu_s = time.monotonic(), cpu_s(node)
        while time.monotonic() - begin_s < duration_s:
            self.page.wait_for_timeout(1000)
        share = (cpu_s(node) - begin_cpu_s) / (time.monotonic() - begin_s)
        alive = sum(bool(page.evaluate("() => window.lit && window.lit.length")) for page in pages)
        self.keep_lags(f"{page_count} pages", lit(pages), duration_s, LIMIT_OF_MANY_S)
        self.keep(f"processor of the node, {page_count} pages", 100 * share, "% of a core")
        report(
            f"{alive} of {page_count} pages live; node: {share:.0%} of a core; the pages are all "
            "painted here",
        )
        for page in pages[1:]:
            page.close()

    def measure_unpainted(self, duration_s: float, page_count: int) -> None:
        """Print how late pages are that paint nothing: the share of the console itself."""
        address = f"http://127.0.0.1:{self.port}"
        line = [sys.executable, str(SOCKET_PAGES), address, str(page_count), str(duration_s)]
        with self.running_elsewhere():
            for count in (1, page_count):
                line[3] = str(count)
                node = console_pid(self.port)
                with subprocess.Popen(line, stdout=subprocess.PIPE, text=True) as pages:
                    self.addCleanup(pages.kill)
                    pages.stdout.readline()
                    self.entered.clear()
                    begin_cpu_s = cpu_s(node)
                    seen = json.loads(pages.stdout.readline())
                share = (cpu_s(node) - begin_cpu_s) / duration_s
                many = f"{count} pages" if count > 1 else "one page"
                limit_s = LIMIT_OF_MANY_S if count > 1 else LIMIT_S
                self.keep_lags(f"{many}, unpainted", seen, duration_s, limit_s)
                self.keep(f"processor of the node, {many}, unpainted", 100 * share, "% of a core")


def lag_words(lags: list[float], limit_s: float) -> str:
    """Return how late pages have lit what was active; lags in their order [s]."""
    if not lags:
        return "no page has lit anything"
    return (
        f"lag median {at(lags, 0.5):.3f} s, 99 % within {at(lags, 0.99):.3f} s, "
        f"worst {lags[-1]:.3f} s (limit {limit_s} s); {sum(lag > limit_s for lag in lags)} of "
        f"{len(lags)} above it"
    )


def report(*lines: str) -> None:
    """Print lines at once."""
    sys.stdout.write("".join(f"{line}\n" for line in lines))
    sys.stdout.flush()


def wait_until(is_so: Callable[[], bool]) -> None:
    """Wait for a condition, with a limit."""
    end_s = time.monotonic() + WAIT_S
    while not is_so():
        if time.monotonic() > end_s:
            raise TimeoutError("waited too long for the engine")
        time.sleep(0.02)


def lit(pages: list[Page]) -> list[Seen]:
    """Return what pages have lit."""
    return [page.evaluate("() => window.lit") for page in pages]


def lags_s(seen: Seen, entered: dict[str, list[float]]) -> list[float]:
    """Return how late each state was shown that a page has shown [s]."""
    lags = []
    for seen_ms, path in seen:
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


def cpu_s(pid: int) -> float:
    """Return the processor time that a process has taken [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def resident_mib(pid: int) -> float:
    """Return the resident memory of a process."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20


def main() -> None:
    """Measure once, on a roscore of its own."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=300.0)
    parser.add_argument("--pages", type=int, default=10)
    parser.add_argument("--unpainted", action="store_true", help="measure the console itself only")
    parser.add_argument("--figures", type=Path, help="file of lines of JSON for the docs")
    options = parser.parse_args()
    port = free_port()
    os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
    core = subprocess.Popen(["roscore", "-p", str(port)], stdout=subprocess.DEVNULL)
    load = Load("measure")
    load_before = os.getloadavg()[0]
    report(f"load of the machine before: {load_before:.1f} on {os.cpu_count()} cores")
    try:
        rospy.init_node("load")
        Load.setUpClass()
        load.setUp()
        measure = load.measure_unpainted if options.unpainted else load.measure
        measure(options.seconds, options.pages)
        load.keep("load of the machine before", load_before, "")
        if options.figures:
            options.figures.write_text("".join(f"{json.dumps(one)}\n" for one in load.figures))
    finally:
        load.doCleanups()
        Load.doClassCleanups()
        core.terminate()
        core.wait(20)


if __name__ == "__main__":
    main()
