#!/usr/bin/env python3
"""How soon every page shows that a question waits for a person.

All pages are open when a fake supervisor asks. Prints how late the first and the last page showed
it in their titles. The target is that of an idle machine.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path

import rospy

sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_console/test/rostest"))
from fake_supervisor import FakeSupervisor
from inbox_case import InboxCase
from inbox_pages_test import PAGES

from remodel_console.testing.browser_test import free_port

LIMIT_S = 0.5  # for the first page, on an idle machine
RECORD_WAITING = """() => {
  window.seen = 0;
  new MutationObserver(() => {
    if (!window.seen && document.title.startsWith('(1)')) window.seen = Date.now();
  }).observe(document.querySelector('title'), { childList: true });
}"""


class Attention(InboxCase):
    """The browser tests' set-up."""

    def measure(self) -> list[float]:
        """Ask a question; return how late each page shows it [s]."""
        pages = [self.open_page(address) for address in PAGES]
        supervisor = FakeSupervisor()
        supervisor.run("cabinet 7")
        for page in pages:
            page.locator(".presence.there", has_text="ROS").wait_for()
            page.evaluate(RECORD_WAITING)
        asked_ms = 1000 * time.time()
        supervisor.ask()
        for page in pages:
            page.wait_for_function("() => window.seen")
        return sorted((page.evaluate("() => window.seen") - asked_ms) / 1000 for page in pages)


def main() -> int:
    """Measure once, on a roscore of its own; return 1 if the target is missed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--figures", type=Path, help="file of lines of JSON for the docs")
    options = parser.parse_args()
    port = free_port()
    os.environ["ROS_MASTER_URI"] = f"http://127.0.0.1:{port}"
    core = subprocess.Popen(["roscore", "-p", str(port)], stdout=subprocess.DEVNULL)
    attention = Attention("measure")
    try:
        rospy.init_node("attention")
        Attention.setUpClass()
        attention.setUp()
        late = attention.measure()
    finally:
        attention.doCleanups()
        Attention.doClassCleanups()
        core.terminate()
        core.wait(20)
    first, last = late[0], late[-1]
    sys.stdout.write(f"a question is shown by the first page after {first:.2f} s, ")
    sys.stdout.write(f"by all {len(PAGES)} after {last:.2f} s; target: {LIMIT_S:g} s\n")
    sys.stdout.write(f"load of the machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores\n")
    if options.figures:
        name = "a question, until the first page shows it"
        line = {"what": name, "value": first, "unit": "s", "most": LIMIT_S}
        options.figures.write_text(json.dumps(line) + "\n")
    return int(first > LIMIT_S)


if __name__ == "__main__":
    sys.exit(main())
