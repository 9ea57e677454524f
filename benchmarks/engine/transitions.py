"""Time transitions of the pure engine, without ROS: chains and loops of states that do nothing.

Microseconds per transition, the least of some repetitions. The floor is a loop that calls the three
events of such a state. Figures of all benchmarks of the engine are rows, printed as a table and
kept as lines of JSON.
"""
# ruff: noqa: T201 - a benchmark prints

from __future__ import annotations

import gc
import json
import time
import tracemalloc
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path as File

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from sensor_msgs.msg import Image

from flexbe_core.core import EventState, OperatableStateMachine
from flexbe_core.engine.engine import Engine
from flexbe_core.engine.supervision import UNSUPERVISED
from flexbe_core.engine.user_data import UserData
from flexbe_core.engine.visit import Visit, visit_of

_REPETITIONS = 9

# The best peers in Python: SMACH 2.5 us, py_trees 2.6 us.
TRANSITION_TARGET_US = 2.5


@dataclass(frozen=True)
class Row:
    """One figure.

    Attributes:
        what: what was measured.
        value: the figure.
        unit: its unit.
        target: what it is to be at most; None if it is there to compare with.
        floor: the figure of the same run of a plain program that does only this; None without.
    """

    what: str
    value: float
    unit: str
    target: float | None = None
    floor: float | None = None


def report(row: Row, file: File) -> None:
    """Print a line of the table and add a line to the file."""
    target = "" if row.target is None else f"{row.target:>9.3g}"
    verdict = "" if row.target is None else "met" if row.value <= row.target else "MISSED"
    ratio = "" if not row.floor else f"{row.value / row.floor:>7.1f} x"
    print(
        f"{row.what:<58}{row.value:>10.3f} {row.unit:<7}{target:>9} {verdict:<7}{ratio}", flush=True
    )
    with file.open("a", encoding="utf-8") as lines:
        lines.write(json.dumps(asdict(row)) + "\n")


def report_all(rows: Iterable[Row], file: File) -> None:
    """Report rows as they come."""
    for row in rows:
        report(row, file)


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
    """Read an image and hand it on."""

    def __init__(self) -> None:
        super().__init__(outcomes=["done"], input_keys=["image"], output_keys=["copy"])

    def execute(self, userdata: UserData) -> str:
        """Hand it on."""
        userdata.copy = userdata.image
        return "done"


class PathState(EventState):
    """Read a path."""

    def __init__(self) -> None:
        super().__init__(outcomes=["done"], input_keys=["path"])

    def execute(self, userdata: UserData) -> str:
        """Read it."""
        return "done" if userdata.path else "none"


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


def least(run: Callable[[], object], repetitions: int = _REPETITIONS) -> float:
    """Return the least time of the processor [s] that `run` takes."""
    times = []
    for _ in range(repetitions):
        begin = time.process_time()
        run()
        times.append(time.process_time() - begin)
    return min(times)


def run(root: OperatableStateMachine) -> None:
    """Run a machine on a new engine, as a behavior would be."""
    Engine(root).run(0.0, lambda: False)


def run_observed(root: OperatableStateMachine) -> None:
    """Run a machine whose states' visits are kept, as for a node that shows their values."""
    engine = Engine(root)
    visits: deque[Visit] = deque(maxlen=200)
    engine.observe = lambda leaf, has_left: visits.append(visit_of(leaf, 0.0, has_left))
    engine.run(0.0, lambda: False)


def floor(transitions: int) -> None:
    """Call the events of a state."""
    state, userdata = NothingState(), UserData()
    execute = NothingState.execute
    for _ in range(transitions):
        state.on_enter(userdata)
        execute(state, userdata)
        state.on_exit(userdata)


def rows() -> Iterator[Row]:
    """Yield the figures."""
    floor_us = least(lambda: floor(10_000)) / 10_000 * 1e6
    yield Row("floor: three calls", floor_us, "us")
    for states, rounds in ((10, 1), (1_000, 1), (5_000, 1), (10, 1_000), (100, 100), (1, 10_000)):
        root = machine(states, rounds)
        transitions = (states + 1) * rounds
        seconds = least(lambda root=root: run(root))
        text = f"one transition, {states} states x {rounds} rounds"
        yield Row(text, seconds / transitions * 1e6, "us", TRANSITION_TARGET_US, floor_us)
    root = machine(1_000)
    for number in range(20):
        root.userdata[f"key{number}"] = number
    seconds = least(lambda: run_observed(root)) / 1_001
    yield Row("one transition, observed, 20 values", seconds * 1e6, "us", 10.0)
    with_image = machine(10, 100, ImageState)
    with_image.userdata.image = Image(data=b"\0" * 900_000)
    seconds = least(lambda: run(with_image)) / 1_100
    yield Row("one transition with a 0.9 MB image in userdata", seconds * 1e6, "us", 50.0)
    with_path = machine(10, 10, PathState)
    with_path.userdata.path = Path(poses=[PoseStamped() for _ in range(1_000)])
    seconds = least(lambda: run(with_path)) / 110
    yield Row("one transition with a path of 1,000 poses", seconds * 1e6, "us", 2_000.0)
    yield from first_passes()
    yield from first_entries()
    yield from memory()


def first_passes() -> Iterator[Row]:
    """Yield the time of a transition in a machine that has just been built, and never run."""
    for states in (100, 1_000):
        seconds = []
        for _ in range(_REPETITIONS):
            root = machine(states)
            gc.collect()
            seconds.append(least(lambda root=root: run(root), 1))
        text = f"one transition, first run through {states} states"
        yield Row(text, min(seconds) / (states + 1) * 1e6, "us", 2 * TRANSITION_TARGET_US)


def first_entries() -> Iterator[Row]:
    """Yield how long it takes from execute to the first on_enter, and how that grows."""
    for states in (1_250, 5_000):
        root = machine(states)
        seconds = least(lambda root=root: Engine(root).run(0.0))
        yield Row(f"execute -> first on_enter, {states} states", seconds * 1e3, "ms", 5.0)


def memory() -> Iterator[Row]:
    """Yield what a state takes in a behavior that has been built and run through."""
    states = 5_000
    gc.collect()
    tracemalloc.start()
    root = machine(states)
    built = tracemalloc.get_traced_memory()[0]
    engine = Engine(root)
    engine.run(0.0, lambda: False)
    reached = tracemalloc.get_traced_memory()[0]
    tracemalloc.stop()
    yield Row("memory of a state, built", built / states / 1e3, "kB", 4.0)
    yield Row("memory of a state, built and reached", reached / states / 1e3, "kB", 4.0)
