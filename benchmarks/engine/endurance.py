"""The engine over a long time: memory over many runs and a simulated day, load while it waits."""

from __future__ import annotations

import os
import queue
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import rospy
from flexbe_msgs.msg import BEStatus
from latencies import Bench, engine, process
from rosgraph_msgs.msg import Clock
from transitions import Row

RUNS = 5_000
WARM_UP_RUNS = 500
DAY_S = 24 * 3600
# [s] Simulated time between two messages of the clock, as long as each wait of the behavior.
STEP_S = 10.0
WATCHED_S = 8.0
FOLLOWED_WITHIN_S = 0.02


def rows() -> Iterator[Row]:
    """Yield the figures."""
    with engine() as child:
        bench = Bench()
        bench.until(BEStatus.READY)
        with process("rosrun", "flexbe_mirror", "behavior_mirror_sm"):
            yield from _many_runs(bench, child.pid)
        yield from _waiting(bench, child.pid)
    rospy.set_param("/use_sim_time", True)
    try:
        yield from _a_day()
    finally:
        rospy.delete_param("/use_sim_time")


def _many_runs(bench: Bench, pid: int) -> Iterator[Row]:
    before = 0.0
    for run in range(RUNS):
        if run == WARM_UP_RUNS:
            before = resident_mb(pid)
        bench.run("Bench Chain")
        bench.until(BEStatus.FINISHED)
    grown = resident_mb(pid) - before
    # Python's table of interned names doubles once, by 2 MB; stock FlexBE grows by 2 MB each run.
    yield Row(f"memory grown over {RUNS - WARM_UP_RUNS:,} runs with a mirror", grown, "MB", 4.0)


def _waiting(bench: Bench, pid: int) -> Iterator[Row]:
    idle = load(pid, WATCHED_S)
    yield Row("idle: processor", idle.cpu_percent, "%", 0.2)
    yield Row("idle: wake-ups", idle.wakeups_hz, "1/s", 7.0)
    bench.run("Bench Waits", count=2, wait_s=600.0)
    bench.until(BEStatus.STARTED)
    waiting = load(pid, WATCHED_S)
    bench.preempt.publish()
    bench.until(BEStatus.FINISHED)
    yield Row("in a long wait: processor", waiting.cpu_percent, "%", 0.2)
    yield Row("in a long wait: wake-ups", waiting.wakeups_hz, "1/s", 8.0)


def _a_day() -> Iterator[Row]:
    """Let a behavior wait through a day whose clock goes as fast as it follows."""
    with engine() as child:
        bench = Bench()
        bench.until(BEStatus.READY)
        clock = rospy.Publisher("/clock", Clock, queue_size=10, tcp_nodelay=True)
        while not clock.get_num_connections():
            time.sleep(0.01)
        clock.publish(rospy.Time.from_sec(STEP_S))
        steps = int(DAY_S / STEP_S)
        bench.run("Bench Waits", count=steps, wait_s=STEP_S)
        bench.until(BEStatus.STARTED)
        time.sleep(0.5)  # by now it waits
        before, begin, waits = 0.0, time.monotonic(), 0
        for step in range(1, steps):
            if step == steps // 24:
                before = resident_mb(child.pid)
            clock.publish(rospy.Time.from_sec((step + 1) * STEP_S))
            # A step that comes before the next wait begins ends none.
            with suppress(queue.Empty):
                bench.marks.get(timeout=FOLLOWED_WITHIN_S)
                waits += 1
        grown = resident_mb(child.pid) - before
        took_s = time.monotonic() - begin
        bench.preempt.publish()
        bench.until(BEStatus.FINISHED)
        yield Row("simulated day: memory grown after its first hour", grown, "MB", 1.0)
        yield Row("simulated day: waits", waits, "")
        yield Row("simulated day: wall time", took_s, "s")


# What the engine's process takes: memory, processor time and wake-ups, from outside, by /proc


_PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Load:
    """What a process did in a while.

    Attributes:
        cpu_percent: of one core.
        wakeups_hz: how often one of its threads began to run.
    """

    cpu_percent: float
    wakeups_hz: float


def resident_mb(pid: int) -> float:
    """Return the resident memory [MB]."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * _PAGE_BYTES / 1e6


def load(pid: int, seconds: float) -> Load:
    """Watch a process for a while."""
    cpu_s, wakeups = _cpu_s(pid), _wakeups(pid)
    time.sleep(seconds)
    return Load((_cpu_s(pid) - cpu_s) / seconds * 100, max(0, _wakeups(pid) - wakeups) / seconds)


def _cpu_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS_PER_S


def _wakeups(pid: int) -> int:
    count = 0
    for status in Path(f"/proc/{pid}/task").glob("*/status"):
        for line in status.read_text().splitlines():
            if line.startswith("voluntary_ctxt_switches"):
                count += int(line.split()[1])
    return count
