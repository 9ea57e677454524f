#!/usr/bin/env python3
"""What following the cell in three dimensions costs the cell.

Steps the simulated cell with a wire in it, and publishes as its node does. During every other slice
another process subscribes to what the console draws and records. Prints the simulated time for
each second of processor time, with and without subscriber; the target is a loss below 2 %.
Processor time, in place of the clock, leaves out what else the machine does.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from pathlib import Path
from statistics import median, stdev

import rospy

sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_work/test"))
from panels import panel

from flexbe_core.ros.master import join
from remodel_console.testing.browser_test import free_port
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.ros.simulated_cell import FixedFrames, Markers, RobotState, SimClock
from remodel_skills.cell import Cell

SLICE_S = 2.0  # of simulated time
WAIT_S = 30.0
FOLLOWER = """
import sys, rospy
rospy.init_node("follower", disable_signals=True, disable_rostime=True)
followed = []
for line in sys.stdin:
    for one in followed: one.unregister()
    topics = ("cell/markers", "/joint_states", "/tf_static") if line.strip() == "on" else ()
    followed = [rospy.Subscriber(topic, rospy.AnyMsg, queue_size=1) for topic in topics]
"""


def main() -> None:
    """Measure once."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--slices", type=int, default=20, help="of each kind")
    options = parser.parse_args()
    port = free_port()
    os.environ |= {"ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_IP": "127.0.0.1"}
    master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], stdout=subprocess.DEVNULL)
    try:
        join("scene_cost")
        follower = subprocess.Popen(
            [sys.executable, "-c", FOLLOWER], stdin=subprocess.PIPE, text=True
        )
        try:
            report(*measure(follower, options.slices))
        finally:
            follower.kill()
            follower.wait()
    finally:
        rospy.signal_shutdown("measured")
        master.terminate()
        master.wait(WAIT_S)


def measure(follower: subprocess.Popen[str], count: int) -> tuple[list[float], list[float]]:
    """Return the speeds [simulated s / s of processor] without and with a subscriber."""
    cell = Cell(SimulatedPlant(panel(), seed=1))
    cell.feed("W1", "A")
    plant, clock = cell.plant, SimClock()
    markers = Markers(plant, clock)
    publish = (RobotState(plant, clock, FixedFrames(clock)), markers)
    speeds: tuple[list[float], list[float]] = ([], [])
    step_s = plant.world.time_step
    for place in range(2 * count + 2):
        is_followed = place % 2 == 1
        follower.stdin.write("on\n" if is_followed else "off\n")
        follower.stdin.flush()
        end_s = time.monotonic() + WAIT_S
        while (markers._publisher.get_num_connections() > 0) != is_followed:
            if time.monotonic() > end_s:
                raise TimeoutError("the follower does not connect")
            time.sleep(0.01)
        begun_s = time.process_time()
        for _ in range(round(SLICE_S / step_s)):
            plant.step()
            clock.now_s += step_s
            for one in publish:
                one()
        if place > 1:  # the first slices warm up
            speeds[is_followed].append(SLICE_S / (time.process_time() - begun_s))
    cell.close()
    return speeds


def report(alone: list[float], followed: list[float]) -> None:
    """Print the medians, and the loss with its standard error."""
    without, with_ = median(alone), median(followed)
    errors = [stdev(one) / len(one) ** 0.5 for one in (alone, followed)]
    error = 1.25 * (errors[0] ** 2 + errors[1] ** 2) ** 0.5 / without  # 1.25: of a median
    sys.stdout.write(
        f"simulated time for each second of processor time: {without:.2f} s alone, "
        f"{with_:.2f} s followed: {with_ / without - 1:+.1%} +- {error:.1%}\n"
    )


if __name__ == "__main__":
    main()
