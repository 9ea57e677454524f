#!/usr/bin/env python3
"""What following the cell in three dimensions costs the cell.

Wires a cabinet in the simulated cell, and subscribes to what the console records and draws during
every other slice of simulated time. Prints the simulated time for each second of the cell's
processor time, with and without; the target is a loss below 2 %. Processor time, in place of the
clock, leaves out what else the machine does.
"""

from __future__ import annotations

import argparse
import os
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import xmlrpc.client
from pathlib import Path

import rosgraph
import rospy
from rosgraph_msgs.msg import Clock

from flexbe_core.ros.master import join
from remodel_console.testing.browser_test import free_port

DESIGN = "/usr/share/qelectrotech/examples/tableau_domestique.qet"
TOPICS = ("cell/markers", "/joint_states", "/tf_static")
SLICE_S = 2.0  # of simulated time
START_S = 120.0
TICK_S = 1 / os.sysconf("SC_CLK_TCK")


def main() -> None:
    """Measure once."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--wires", type=int, default=6)
    parser.add_argument("launch", nargs="*", help="arguments of order.launch, such as cell:=NAME")
    options = parser.parse_args()
    folder = Path(tempfile.mkdtemp())
    nodes = None
    try:
        port = free_port()
        packages = os.environ["ROS_PACKAGE_PATH"]
        os.environ |= {
            "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
            "ROS_IP": "127.0.0.1",
            "ROS_LOG_DIR": str(folder / "log"),
            "ROS_PACKAGE_PATH": f"{folder}/remodel_order_behaviors:{packages}",
        }
        database = f"sqlite:///{folder}/production.sqlite"
        os.environ["REMODEL_DATABASE"] = database
        (folder / "charts").mkdir()
        planner = ["rosrun", "remodel_planner", "planner"]
        subprocess.run([*planner, "import", DESIGN, "--order", "demo"], check=True)
        launch = ["roslaunch", "-p", str(port), "remodel_planner", "order.launch"]
        with (folder / "nodes.log").open("wb") as log:
            nodes = subprocess.Popen(
                [*launch, f"output:={folder}", f"database:={database}", *options.launch],
                stdout=log,
                stderr=log,
            )
        wires = ["--wires", str(options.wires), "--output", str(folder)]
        order = subprocess.Popen([*planner, "run_order", "demo", "--wait", "120", *wires])
        report(*measure(order))
    finally:
        if nodes is not None:
            nodes.send_signal(signal.SIGTERM)
            nodes.wait(60)
        shutil.rmtree(folder, ignore_errors=True)


def measure(order: subprocess.Popen[bytes]) -> tuple[list[float], list[float]]:
    """Return the speeds [simulated s / s of processor] without and with subscribers."""
    join("scene_cost")
    begun_s = rospy.wait_for_message("/clock", Clock, START_S).clock.to_sec()
    cell = node_pid("/cell")
    speeds: tuple[list[float], list[float]] = ([], [])
    subscribers: list[rospy.Subscriber] = []
    is_followed, used_s = False, processor_s(cell)
    while order.poll() is None:
        now_s = rospy.wait_for_message("/clock", Clock, START_S).clock.to_sec()
        if now_s - begun_s < SLICE_S:
            continue
        now_used_s = processor_s(cell)
        speeds[is_followed].append((now_s - begun_s) / max(TICK_S, now_used_s - used_s))
        is_followed = not is_followed
        for subscriber in subscribers:
            subscriber.unregister()
        kinds = TOPICS if is_followed else ()
        subscribers = [rospy.Subscriber(topic, rospy.AnyMsg, queue_size=1) for topic in kinds]
        begun_s, used_s = now_s, processor_s(cell)
    return speeds


def node_pid(name: str) -> int:
    """Return the process of a node."""
    uri = rosgraph.Master("scene_cost").lookupNode(name)
    return int(xmlrpc.client.ServerProxy(uri).getPid("scene_cost")[2])


def processor_s(pid: int) -> float:
    """Return the processor time that a process has used [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) * TICK_S


def report(alone: list[float], followed: list[float]) -> None:
    """Print the medians, and the loss with its standard error."""
    without, with_ = statistics.median(alone), statistics.median(followed)
    spread = [statistics.stdev(one) / len(one) ** 0.5 for one in (alone, followed)]
    error = 1.25 * (spread[0] ** 2 + spread[1] ** 2) ** 0.5 / without  # 1.25: of a median
    sys.stdout.write(
        f"simulated time for each second of the cell's processor time: {without:.3f} s alone, "
        f"{with_:.3f} s followed: {with_ / without - 1:+.1%} +- {error:.1%} "
        f"({len(alone)} and {len(followed)} slices of {SLICE_S:.0f} s)\n"
    )


if __name__ == "__main__":
    main()
