#!/usr/bin/env python3
"""Measure the engine: transitions without ROS, then the engine node from outside.

run.py [--peer PYTHON] [--figures FILE]; the workspace must be sourced. Transitions are those of
chains and loops of states that do nothing: microseconds of the processor, the least of some
repetitions. Their floor is a loop that calls the three events of such a state. PYTHON has py_trees.
"""

from __future__ import annotations

import argparse
import gc
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path

from sensor_msgs.msg import Image

sys.path.insert(0, str(Path(__file__).parents[1]))
import node
from figures import Figure, add_figures_option, report

from flexbe_core.core import EventState, OperatableStateMachine
from flexbe_core.engine.engine import Engine
from flexbe_core.engine.supervision import UNSUPERVISED
from flexbe_core.engine.user_data import UserData

REPETITIONS = 9
TARGET_US = 2.5  # the best peers in Python: SMACH 2.5 us, py_trees 2.6 us
PY_TREES = """
import time, py_trees
root = py_trees.composites.Sequence("root", memory=True)
root.add_children([py_trees.behaviours.Success(f"s{index}") for index in range(1000)])
times = []
for _ in range(9):
    begin = time.perf_counter()
    root.tick_once()
    times.append(time.perf_counter() - begin)
print(1e6 * min(times) / 1000)
"""


class NothingState(EventState):
    """Do nothing."""

    def __init__(self) -> None:
        super().__init__(outcomes=["done"])

    def on_enter(self, userdata: UserData) -> None:
        """Do nothing."""

    def execute(self, userdata: UserData) -> str:
        """Return at once."""
        return "done"

    def on_exit(self, userdata: UserData) -> None:
        """Do nothing."""


class LoopState(EventState):
    """Count rounds."""

    def __init__(self, rounds: int) -> None:
        super().__init__(outcomes=["again", "done"])
        self._rounds = self._left = rounds

    def execute(self, userdata: UserData) -> str:
        """Count."""
        self._left -= 1
        if self._left > 0:
            return "again"
        self._left = self._rounds
        return "done"


class ImageState(EventState):
    """Copy an image."""

    def __init__(self) -> None:
        super().__init__(outcomes=["done"], input_keys=["image"], output_keys=["copy"])

    def execute(self, userdata: UserData) -> str:
        """Copy it."""
        userdata.copy = userdata.image
        return "done"


def machine(
    states: int, rounds: int = 1, kind: type[EventState] = NothingState
) -> OperatableStateMachine:
    """Return a chain of states, run through so many times."""
    root = OperatableStateMachine(outcomes=["finished"])
    root.autonomy_level = UNSUPERVISED
    labels = [f"s{index}" for index in range(states)]
    with root:
        for label, following in zip(labels, [*labels[1:], "loop"], strict=True):
            OperatableStateMachine.add(label, kind(), {"done": following})
        OperatableStateMachine.add("loop", LoopState(rounds), {"again": "s0", "done": "finished"})
    return root


def run(root: OperatableStateMachine) -> None:
    """Run a machine on a new engine, as a behavior would be."""
    Engine(root).run(0.0, lambda: False)


def least_us(work: Callable[[], object], transitions: int) -> float:
    """Return the least time of the processor that a transition takes [us]."""
    times = []
    for _ in range(REPETITIONS):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return min(times) / transitions * 1e6


def floor(transitions: int) -> None:
    """Call the events of a state."""
    state, userdata = NothingState(), UserData()
    execute = NothingState.execute
    for _ in range(transitions):
        state.on_enter(userdata)
        execute(state, userdata)
        state.on_exit(userdata)


def transitions() -> Iterator[Figure]:
    """Yield the time of a transition, and the memory of a state."""
    floor_us = least_us(lambda: floor(10_000), 10_000)
    yield Figure("floor: three calls", floor_us, "us")
    for states, rounds in ((10, 1), (1_000, 1), (5_000, 1), (10, 1_000), (100, 100), (1, 10_000)):
        root = machine(states, rounds)
        took_us = least_us(lambda root=root: run(root), (states + 1) * rounds)
        what = f"one transition, {states} states x {rounds} rounds"
        yield Figure(what, took_us, "us", most=TARGET_US, floor=floor_us)
    with_image = machine(10, 100, ImageState)
    with_image.userdata.image = Image(data=b"\0" * 900_000)
    took_us = least_us(lambda: run(with_image), 1_100)
    yield Figure("one transition with a 0.9 MB image in userdata", took_us, "us", most=50.0)
    states = 5_000
    gc.collect()
    tracemalloc.start()
    root = machine(states)
    built = tracemalloc.get_traced_memory()[0]
    engine = Engine(root)
    engine.run(0.0, lambda: False)
    reached = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    yield Figure("memory of a state, built", built / states / 1e3, "kB", most=4.0)
    yield Figure("memory of a state, built and reached", reached / states / 1e3, "kB", most=4.0)


def py_trees(python: str) -> Iterator[Figure]:
    """Yield the peer's figure."""
    took_us = float(subprocess.check_output([python, "-c", PY_TREES], text=True))
    yield Figure("peer: py_trees, one behaviour of 1,000 in a sequence", took_us, "us")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--peer", metavar="PYTHON", help="a Python that has py_trees")
    add_figures_option(parser)
    options = parser.parse_args()
    peer = py_trees(options.peer) if options.peer else ()
    with node.workplace():
        report(chain(transitions(), peer, node.figures()), options.figures)


if __name__ == "__main__":
    main()
