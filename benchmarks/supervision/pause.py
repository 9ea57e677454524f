#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Pause a running order at random moments, and count what moves: pause.py [--moments N] [--seed N].

The engine, its action server, the synthesizer and the supervisor are the real ones, over a fake
cell in four processes. After each pause is answered, goals of all ability servers and the ledger of
the cell's world are watched: what is sent, runs or is done before the resume counts as moved.
"""

from __future__ import annotations

import argparse
import shutil
import statistics
import sys
import tempfile
from pathlib import Path
from random import Random

import rospy
from stack import add_figures_option, free_port, stack, write_figures

from remodel_supervision.core.runs.events import Ending

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parents[1] / "src/remodel_planner/test/rostest"))

from motion_watch import MotionWatch  # noqa: E402 - beside the tests, which use them too
from order_client import OrderClient  # noqa: E402 - beside the tests, which use them too
from pause_moments import PauseMoments  # noqa: E402 - beside the tests, which use them too

NODES = ("use_case_supervisor", "behavior_action_server", "feeder", "eyes", "hand", "screwdriver")


def main() -> int:
    """Print what moved, and return 1 if something did or an order was harmed."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--moments", type=int, default=50)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--wires", type=int, default=14, help="of each order")
    parser.add_argument("--operation", type=float, default=0.1, help="[s] wall time of one")
    parser.add_argument("--window", type=float, default=0.5, help="[s] that each pause is watched")
    add_figures_option(parser)
    options = parser.parse_args()
    output = Path(tempfile.mkdtemp(prefix="remodel_pause_")) / "run"
    given = {"duration_s": options.operation, "console_port": free_port()}
    harmed: list[str] = []
    with stack(HERE / "chaos.launch", output, **given) as nodes:
        nodes.wait_for(*NODES)
        rospy.init_node("pause", disable_signals=True)
        orders = OrderClient(output)
        moments = PauseMoments(orders, MotionWatch(orders.world), Random(options.seed))
        while moments.paused < options.moments:
            run = orders.start(options.wires)
            while moments.paused < options.moments and moments.pause(run, options.window):
                pass
            ended = orders.wait_for_end(run).ended
            account = orders.account(run)
            if ended is None or ended.ending is not Ending.COMPLETE or account.omitted:
                harmed.append(f"run {run}: {ended}")
            harmed += [f"run {run}: {end} was fixed twice" for end in account.fixed_again]
    shutil.rmtree(output.parent)
    print(
        f"{moments.paused} pauses: {len(moments.moved)} operations moved after the answer; "
        f"answered within {statistics.median(moments.waits_s):.2f} s, at most "
        f"{max(moments.waits_s):.2f} s; {len(harmed)} orders harmed"
    )
    write_figures(
        options.figures,
        (
            {"what": f"{what}, of {moments.paused} pauses", "value": value, "unit": unit, **target}
            for what, value, unit, target in (
                ("operations that moved after the answer", len(moments.moved), "", {"most": 0}),
                ("time to the answer, median", statistics.median(moments.waits_s), "s", {}),
                ("time to the answer, longest", max(moments.waits_s), "s", {}),
                ("orders harmed", len(harmed), "", {"most": 0}),
            )
        ),
    )
    for line in (*map(str, moments.moved), *harmed):
        print(f"  {line}")
    return 1 if moments.moved or harmed else 0


if __name__ == "__main__":
    sys.exit(main())
