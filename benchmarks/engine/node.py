"""Time the engine node from outside, on a roscore of its own: what operators and servers notice.

Figures are medians. The floor of goals is a plain actionlib client in place of the engine, this
file itself: node.py GOALS.
"""

from __future__ import annotations

import argparse
import os
import queue
import random
import socket
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import actionlib
import rosgraph
import rospy
from actionlib.msg import TestAction, TestGoal, TestResult

sys.path.insert(0, str(Path(__file__).parents[1]))
from figures import Figure
from flexbe_msgs.msg import BehaviorSelection, BEStatus
from std_msgs.msg import Empty, Float64, Int32, String, UInt8

from flexbe_core import BehaviorLibrary
from flexbe_core.engine.supervision import UNSUPERVISED
from flexbe_widget.ros.request_server import start_request

LIMIT_S = 30.0
RUNS, WARM_UP_RUNS = 5_000, 500
WATCHED_S = 8.0  # that a waiting engine is watched


@contextmanager
def process(*command: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run a command, and end it with the block."""
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield child
    finally:
        child.terminate()
        try:
            child.wait(5)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()


@contextmanager
def workplace() -> Iterator[None]:
    """Make this process a node on a roscore of its own."""
    with socket.socket() as probe:
        probe.bind(("", 0))
        port = probe.getsockname()[1]
    os.environ["ROS_MASTER_URI"] = f"http://localhost:{port}"
    packages = Path(__file__).parent / "packages"
    os.environ["ROS_PACKAGE_PATH"] = f"{packages}:{os.environ.get('ROS_PACKAGE_PATH', '')}"
    with process("roscore", "-p", str(port)):
        while not rosgraph.is_master_online():
            time.sleep(0.05)
        rospy.init_node("bench", disable_signals=True)
        # A server lists each goal for 5 s after its end, and publishes the list with each change:
        # after hundreds of goals this is all that one would time.
        rospy.set_param("bench/action/status_list_timeout", 0.05)
        yield


class Bench:
    """The engine's surroundings: an action server, a publisher, an operator.

    Attributes:
        delay: how long [s] the server takes for a goal.
        latencies: [s] from each published result to the goal that follows.
        status: when [s, wall] the engine said what.
        marks: when [s, wall] states were entered.
    """

    def __init__(self) -> None:
        self.library = BehaviorLibrary()
        self.delay: Callable[[], float] = lambda: 0.0
        self.latencies: list[float] = []
        self.answered = self.cancelled = 0.0
        self.goals = 0
        self.status: queue.SimpleQueue[tuple[float, BEStatus]] = queue.SimpleQueue()
        self.marks: queue.SimpleQueue[float] = queue.SimpleQueue()
        self.start, self.preempt, self.message = (
            rospy.Publisher(topic, kind, queue_size=10, tcp_nodelay=True)
            for topic, kind in (
                ("flexbe/start_behavior", BehaviorSelection),
                ("flexbe/command/preempt", Empty),
                ("bench/message", String),
            )
        )
        self.message.impl.set_queue_size(None)  # written at once: the queue is not the engine's
        rospy.Subscriber("flexbe/status", BEStatus, self._on_status, tcp_nodelay=True)
        rospy.Subscriber("bench/marks", Float64, lambda m: self.marks.put(m.data), tcp_nodelay=True)
        self._server = actionlib.ActionServer(
            "bench/action", TestAction, self._on_goal, self._on_cancel, auto_start=False
        )
        self._server.start()

    def run(self, kind: str = "chain", count: int = 10, level: int = UNSUPERVISED) -> float:
        """Start the behavior and return when [s, wall] it was asked for."""
        values = [("kind", kind), ("count", str(count))]
        request = start_request(self.library, "Bench", values, (), level)
        while not self.start.get_num_connections():
            time.sleep(0.01)
        asked = time.time()
        self.start.publish(request)
        return asked

    def until(self, code: int) -> float:
        """Return when [s, wall] the engine said this."""
        while True:
            at, status = self.status.get(timeout=LIMIT_S)
            if status.code == code:
                return at
            if status.code in (BEStatus.ERROR, BEStatus.FAILED):
                raise SystemExit("the behavior failed; run the engine by hand to see why")

    def mark(self) -> float:
        """Return the next mark."""
        return self.marks.get(timeout=LIMIT_S)

    def _on_status(self, message: BEStatus) -> None:
        self.status.put((time.time(), message))

    def _on_goal(self, handle: actionlib.ServerGoalHandle) -> None:
        if self.answered:
            self.latencies.append(time.perf_counter() - self.answered)
        handle.set_accepted()
        self.goals += 1
        delay_s = self.delay()
        if delay_s == float("inf"):
            return
        if delay_s:
            time.sleep(delay_s)
        self.answered = time.perf_counter()
        handle.set_succeeded(TestResult())

    def _on_cancel(self, handle: actionlib.ServerGoalHandle) -> None:
        self.cancelled = time.time()
        handle.set_canceled()


def figures() -> Iterator[Figure]:
    """Yield the figures."""
    bench = Bench()
    bare_ms = bare_node_start(5) * 1e3
    yield Figure("floor: start of a bare rospy node", bare_ms, "ms")
    node = subprocess.check_output(
        ["catkin_find", "--first-only", "--libexec", "flexbe_onboard", "start_behavior"], text=True
    ).strip()
    begin = time.time()
    # As in behavior_onboard.launch.
    with process("env", "MALLOC_ARENA_MAX=1", sys.executable, node) as engine:
        ready_ms = (bench.until(BEStatus.READY) - begin) * 1e3
        yield Figure("engine start -> READY", ready_ms, "ms", most=550.0, floor=bare_ms)
        warm_up(bench)
        yield from goals(bench)
        yield _ms("message -> next state entered", message_latency(bench, 60), 0.5)
        to_cancel, to_end = preempt_latencies(bench, 15)
        yield _ms("preempt -> cancel at the server", to_cancel, 2.0)
        yield _ms("preempt -> FINISHED", to_end, 6.0)
        for states, target_ms in ((10, 10.0), (1000, 60.0)):
            what = f"start request -> first on_enter, {states} states"
            yield _ms(what, start_latency(bench, states, 9), target_ms)
        yield _ms("one supervised transition", supervised_transition(bench, 1000), 0.25)
        yield from endurance(bench, engine.pid)


def _ms(what: str, seconds: float, most: float | None = None) -> Figure:
    return Figure(what, seconds * 1e3, "ms", most=most)


def bare_node_start(count: int) -> float:
    """Return the median of what a process takes to become a node, and do nothing else [s]."""
    become_node = "import os, rospy; rospy.init_node('bare', anonymous=True); os._exit(0)"
    times = []
    for _ in range(count):
        begin = time.time()
        subprocess.run([sys.executable, "-c", become_node], check=True, timeout=LIMIT_S)
        times.append(time.time() - begin)
    return statistics.median(times)


def warm_up(bench: Bench) -> None:
    """Run until the engine has imported everything and its connections are made."""
    while bench.marks.empty():
        bench.run()
        bench.until(BEStatus.FINISHED)
        time.sleep(0.2)
    while not bench.marks.empty():
        bench.marks.get()


def goals(bench: Bench) -> Iterator[Figure]:
    """Yield the latencies from a published result to the next goal: the floor's, the engine's."""
    for name, delay, count, target_ms in (
        ("at once", lambda: 0.0, 500, 0.4),
        ("after 20 to 120 ms", lambda: random.uniform(0.02, 0.12), 60, 0.9),
    ):
        what = f"result -> next goal, server answers {name}"
        bench.delay, bench.latencies, bench.answered = delay, [], 0.0
        with process(sys.executable, __file__, str(count)) as client:
            client.wait(LIMIT_S)
        floor_ms = statistics.median(bench.latencies) * 1e3
        yield Figure(f"floor: {what}", floor_ms, "ms")
        bench.latencies, bench.answered = [], 0.0
        bench.run("goals", count=count)
        bench.until(BEStatus.FINISHED)
        engine_ms = statistics.median(bench.latencies) * 1e3
        yield Figure(what, engine_ms, "ms", most=target_ms, floor=floor_ms)


def plain_client(count: int) -> None:
    """Send goals one behind the other with actionlib alone."""
    rospy.init_node("plain_client")
    client = actionlib.ActionClient("bench/action", TestAction)
    client.wait_for_server(rospy.Duration(LIMIT_S))
    done: queue.SimpleQueue[None] = queue.SimpleQueue()

    def on_transition(handle: actionlib.ClientGoalHandle) -> None:
        if handle.get_comm_state() == actionlib.CommState.DONE:
            done.put(None)

    for _ in range(count):
        handle = client.send_goal(TestGoal(), on_transition)
        done.get(timeout=LIMIT_S)
        del handle


def message_latency(bench: Bench, count: int) -> float:
    """Return the median from a published message to the next entry [s]."""
    bench.run("messages", count=count)
    bench.mark()
    while not bench.message.get_num_connections():
        time.sleep(0.01)
    latencies = []
    for _ in range(count - 1):
        time.sleep(random.uniform(0.02, 0.12))
        sent = time.time()
        bench.message.publish("x")
        latencies.append(bench.mark() - sent)
    bench.message.publish("x")
    bench.until(BEStatus.FINISHED)
    return statistics.median(latencies)


def preempt_latencies(bench: Bench, count: int) -> tuple[float, float]:
    """Return the medians from a published preempt to the cancel and to FINISHED [s]."""
    bench.delay = lambda: float("inf")
    to_cancel, to_end = [], []
    for _ in range(count):
        goals = bench.goals
        bench.run("goals", count=1)
        while bench.goals == goals:
            time.sleep(0.001)
        time.sleep(random.uniform(0.02, 0.12))
        asked = time.time()
        bench.preempt.publish()
        to_end.append(bench.until(BEStatus.FINISHED) - asked)
        to_cancel.append(bench.cancelled - asked)
    return statistics.median(to_cancel), statistics.median(to_end)


def start_latency(bench: Bench, states: int, count: int) -> float:
    """Return the median from a start request to the first on_enter [s]."""
    latencies = []
    for _ in range(count):
        asked = bench.run(count=states)
        latencies.append(bench.mark() - asked)
        bench.mark()
        bench.until(BEStatus.FINISHED)
    return statistics.median(latencies)


def supervised_transition(bench: Bench, transitions: int) -> float:
    """Return the mean time of a transition that a mirror follows [s]."""
    for topic, kind in (("flexbe/mirror/outcome", UInt8), ("flexbe/debug/current_state", String)):
        rospy.Subscriber(topic, kind, lambda m: None)
    rospy.Publisher("flexbe/request_mirror_structure", Int32, queue_size=1)
    time.sleep(0.5)
    bench.run(count=transitions - 2, level=3)
    begin = bench.mark()
    end = bench.until(BEStatus.FINISHED)
    bench.mark()
    return (end - begin) / transitions


def endurance(bench: Bench, pid: int) -> Iterator[Figure]:
    """Yield how the engine's memory grows, and what it takes of the processor while it is idle."""
    before = 0.0
    with process("rosrun", "flexbe_mirror", "behavior_mirror_sm"):
        for number in range(RUNS):
            if number == WARM_UP_RUNS:
                before = resident_mb(pid)
            bench.run()
            bench.until(BEStatus.FINISHED)
        grown = resident_mb(pid) - before
    # Python's table of interned names doubles once, by 2 MB; stock FlexBE grows by 2 MB each run.
    what = f"memory grown over {RUNS - WARM_UP_RUNS:,} runs with a mirror"
    yield Figure(what, grown, "MB", most=4.0)
    begun_s = cpu_s(pid)
    time.sleep(WATCHED_S)
    share = 100 * (cpu_s(pid) - begun_s) / WATCHED_S
    yield Figure("idle: processor", share, "%", most=0.2)


def resident_mb(pid: int) -> float:
    """Return the resident memory of a process [MB]."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def cpu_s(pid: int) -> float:
    """Return the processor time that a process has taken [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Send goals one behind the other.")
    parser.add_argument("goals", type=int)
    plain_client(parser.parse_args().goals)
