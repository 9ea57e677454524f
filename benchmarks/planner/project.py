#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Time the way of a real project: import, layout, plan, explain and draw, each as a command.

Run it with the workspace sourced. Target: under 10 s together for QElectroTech's `industrial.qet`.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
import time
from pathlib import Path

DESIGN = Path("/usr/share/qelectrotech/examples/industrial.qet")
TARGET_S = 10


def main() -> None:
    """Run the commands in a folder of their own, and print their times."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("design", type=Path, nargs="?", default=DESIGN)
    parser.add_argument("--time-limit", default="1", help="[s] of search (default 1)")
    options = parser.parse_args()
    total = 0.0
    with tempfile.TemporaryDirectory() as folder:
        database = ["--database", f"sqlite:///{folder}/production.sqlite"]
        limit = ["--time-limit", options.time_limit]
        order = ["--order", "project", *database]
        for line in (
            ["import", str(options.design.resolve()), *order],
            ["layout", "project", "--output", "board.svg", *database],
            ["plan", *order, "--output", "plan.json", *limit],
            ["explain", "plan.json", *order],
            ["draw", "plan.json", *order, "--output", "plan.svg"],
        ):
            started = time.monotonic()
            command = ["remodel", *line]
            subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL, timeout=300)
            seconds = time.monotonic() - started
            total += seconds
            print(f"{line[0]:8} {seconds:6.2f} s")
    print(f"together {total:6.2f} s (target: {TARGET_S} s)")


if __name__ == "__main__":
    main()
