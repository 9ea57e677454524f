#!/usr/bin/env python3
"""Time the engine node from outside, on a roscore of its own: what operators and servers notice.

Figures are medians. The floor of goals is a plain actionlib client in place of the engine.
"""

from __future__ import annotations

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
from flexbe_msgs.msg import BehaviorSelection, BEStatus
from std_msgs.msg import Empty, Float64, Int32, String, UInt8
from transitions import Row, machine

from flexbe_core import BehaviorLibrary
from flexbe_core.engine.supervision import UNSUPERVISED
from flexbe_widget.ros.request_server import start_request

HERE = Path(__file__).parent
LIMIT_S = 30.0


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


def free_port() -> int:
    """Return a free port."""
    with socket.socket() as probe:
        probe.bind(("", 0))
        return probe.getsockname()[1]


class Bench:
    """The engine's surroundings: an action server, a publisher, an operator.

    Attributes:
        delay: how long [s] the server takes for a goal.
        latencies: [s] from each published result to the goal that follows.
    """

    def __init__(self) -> None:
        self.library = BehaviorLibrary()
        self.delay: Callable[[], float] = lambda: 0.0
        self.latencies: list[float] = []
        self.answered = 0.0
        self.goals = 0
        self.cancelled = 0.0
        self.status: queue.SimpleQueue[tuple[float, BEStatus]] = queue.SimpleQueue()
        self.marks: queue.SimpleQueue[float] = queue.SimpleQueue()
        self.start = self.publisher("flexbe/start_behavior", BehaviorSelection)
        self.preempt = self.publisher("flexbe/command/preempt", Empty)
        self.message = self.publisher("bench/message", String)
        self.message.impl.set_queue_size(None)  # written at once: the queue is not the engine's
        rospy.Subscriber("flexbe/status", BEStatus, self._on_status, tcp_nodelay=True)
        rospy.Subscriber("bench/marks", Float64, lambda m: self.marks.put(m.data), tcp_nodelay=True)
        self.server = actionlib.ActionServer(
            "bench/action", TestAction, self._on_goal, self._on_cancel, auto_start=False
        )
        self.server.start()

    @staticmethod
    def publisher(topic: str, message_type: type) -> rospy.Publisher:
        """Return a publisher."""
        return rospy.Publisher(topic, message_type, queue_size=10, tcp_nodelay=True)

    def run(self, name: str, level: int = UNSUPERVISED, **parameters: object) -> float:
        """Start a behavior and return when [s, wall] it was asked for."""
        request = start_request(
            self.library, name, [(k, str(v)) for k, v in parameters.items()], (), level
        )
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


def warm_up(bench: Bench) -> None:
    """Run once, so that the engine has imported everything and its connections are made."""
    bench.run("Bench Chain")
    bench.until(BEStatus.FINISHED)
    while bench.marks.empty():
        bench.run("Bench Chain")
        bench.until(BEStatus.FINISHED)
        time.sleep(0.2)
    while not bench.marks.empty():
        bench.marks.get()


def goal_latency(bench: Bench, delay: Callable[[], float], count: int, by_engine: bool) -> float:
    """Return the median from a published result to the next goal [s]."""
    bench.delay, bench.latencies, bench.answered = delay, [], 0.0
    if by_engine:
        bench.run("Bench Goals", count=count)
        bench.until(BEStatus.FINISHED)
    else:
        with process(sys.executable, __file__, str(count)) as client:
            client.wait(LIMIT_S)
    return statistics.median(bench.latencies)


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
    bench.run("Bench Messages", count=count)
    bench.marks.get(timeout=LIMIT_S)
    while not bench.message.get_num_connections():
        time.sleep(0.01)
    latencies = []
    for _ in range(count - 1):
        time.sleep(random.uniform(0.02, 0.12))
        sent = time.time()
        bench.message.publish("x")
        latencies.append(bench.marks.get(timeout=LIMIT_S) - sent)
    bench.message.publish("x")
    bench.until(BEStatus.FINISHED)
    return statistics.median(latencies)


def overshoot(bench: Bench, count: int) -> float:
    """Return the median of how late a wait of 130 ms is over [s]."""
    bench.run("Bench Waits", count=count)
    bench.until(BEStatus.FINISHED)
    return statistics.median(bench.marks.get(timeout=LIMIT_S) for _ in range(count - 1))


def preempt_latencies(bench: Bench, count: int) -> tuple[float, float]:
    """Return the medians from a published preempt to the cancel and to FINISHED [s]."""
    bench.delay = lambda: float("inf")
    to_cancel, to_end = [], []
    for _ in range(count):
        goals = bench.goals
        bench.run("Bench Goals", count=1)
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
        asked = bench.run("Bench Chain", states=states)
        latencies.append(bench.marks.get(timeout=LIMIT_S) - asked)
        bench.marks.get(timeout=LIMIT_S)
        bench.until(BEStatus.FINISHED)
    return statistics.median(latencies)


def supervised_transition(bench: Bench, transitions: int) -> float:
    """Return the mean time of a transition that a mirror follows [s]."""
    for topic, message_type in (
        ("flexbe/mirror/outcome", UInt8),
        ("flexbe/debug/current_state", String),
    ):
        rospy.Subscriber(topic, message_type, lambda m: None)
    rospy.Publisher("flexbe/request_mirror_structure", Int32, queue_size=1)
    time.sleep(0.5)
    bench.run("Bench Chain", level=3, states=transitions - 2)
    begin = bench.marks.get(timeout=LIMIT_S)
    end = bench.until(BEStatus.FINISHED)
    bench.marks.get(timeout=LIMIT_S)
    return (end - begin) / transitions


def launcher_latency(bench: Bench, count: int) -> float:
    """Return the median from the start of be_launcher to the first on_enter [s]."""
    launcher = subprocess.check_output(
        ["catkin_find", "--first-only", "--libexec", "flexbe_widget", "be_launcher"], text=True
    ).strip()
    latencies = []
    for _ in range(count):
        begin = time.time()
        with process(sys.executable, launcher, "-b", "Bench Chain") as child:
            latencies.append(bench.marks.get(timeout=LIMIT_S) - begin)
            bench.marks.get(timeout=LIMIT_S)
            child.wait(LIMIT_S)
        bench.until(BEStatus.FINISHED)
    return statistics.median(latencies)


def first_spin(states: int) -> float:
    """Return the time of a transition in the first machine that this process runs by hand [s]."""
    root = machine(states)
    begin = time.perf_counter()
    root.spin()
    return (time.perf_counter() - begin) / (states + 1)


def bare_node_start(count: int) -> float:
    """Return the median of what a process takes to become a node, and do nothing else [s]."""
    become_node = "import os, rospy; rospy.init_node('bare', anonymous=True); os._exit(0)"
    times = []
    for _ in range(count):
        begin = time.time()
        subprocess.run([sys.executable, "-c", become_node], check=True, timeout=LIMIT_S)
        times.append(time.time() - begin)
    return statistics.median(times)


@contextmanager
def workplace() -> Iterator[None]:
    """Make this process a node on a roscore of its own."""
    port = free_port()
    os.environ["ROS_MASTER_URI"] = f"http://localhost:{port}"
    packages = [str(HERE / "packages"), os.environ.get("ROS_PACKAGE_PATH", "")]
    os.environ["ROS_PACKAGE_PATH"] = ":".join(packages)
    with process("roscore", "-p", str(port)):
        while not rosgraph.is_master_online():
            time.sleep(0.05)
        rospy.init_node("bench", disable_signals=True)
        # A server lists each goal for 5 s after its end, and publishes the list with each change:
        # after hundreds of goals this is all that one would time.
        rospy.set_param("bench/action/status_list_timeout", 0.05)
        yield


@contextmanager
def engine() -> Iterator[subprocess.Popen[bytes]]:
    """Run an engine node."""
    node = subprocess.check_output(
        ["catkin_find", "--first-only", "--libexec", "flexbe_onboard", "start_behavior"], text=True
    ).strip()
    # As in behavior_onboard.launch.
    with process("env", "MALLOC_ARENA_MAX=1", sys.executable, node) as child:
        yield child


def rows() -> Iterator[Row]:
    """Yield the figures."""
    bench = Bench()
    # Stock FlexBE: 32 us.
    yield Row("one transition, first spin by hand, 100 states", first_spin(100) * 1e6, "us", 32.0)
    bare_ms = bare_node_start(5) * 1e3
    yield Row("floor: start of a bare rospy node", bare_ms, "ms")
    begin = time.time()
    with engine():
        ready_ms = (bench.until(BEStatus.READY) - begin) * 1e3
        yield Row("engine start -> READY", ready_ms, "ms", 550.0, bare_ms)
        warm_up(bench)
        yield from goal_rows(bench)
        yield ms("message -> next state entered", message_latency(bench, 60), 0.5)
        yield ms("wait of 130 ms: overshoot", overshoot(bench, 20), 1.0)
        to_cancel, to_end = preempt_latencies(bench, 15)
        yield ms("preempt -> cancel at the server", to_cancel, 2.0)
        yield ms("preempt -> FINISHED", to_end, 6.0)
        for states, target_ms in ((10, 10.0), (1000, 60.0)):
            text = f"start request -> first on_enter, {states} states"
            yield ms(text, start_latency(bench, states, 9), target_ms)
        yield ms("one supervised transition", supervised_transition(bench, 1000), 0.25)
        launched_ms = launcher_latency(bench, 7) * 1e3
        yield Row("be_launcher start -> first on_enter", launched_ms, "ms", 550.0, bare_ms)


def goal_rows(bench: Bench) -> Iterator[Row]:
    """Yield the latencies from a result to the next goal, of the floor and of the engine."""
    for name, delay, count, target_ms in (
        ("at once", lambda: 0.0, 500, 0.4),
        ("after 20 to 120 ms", lambda: random.uniform(0.02, 0.12), 60, 0.9),
    ):
        text = f"result -> next goal, server answers {name}"
        floor_s = goal_latency(bench, delay, count, by_engine=False)
        yield ms(f"floor: {text}", floor_s)
        engine_s = goal_latency(bench, delay, count, by_engine=True)
        yield Row(text, engine_s * 1e3, "ms", target_ms, floor_s * 1e3)


def ms(text: str, seconds: float, target_ms: float | None = None) -> Row:
    """Return a figure in [ms]."""
    return Row(text, seconds * 1e3, "ms", target_ms)


if __name__ == "__main__":
    plain_client(int(sys.argv[1]))
