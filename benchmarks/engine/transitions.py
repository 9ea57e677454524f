#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Time transitions of the pure engine, without ROS: chains and loops of states that do nothing.

Prints microseconds per transition, the least of some repetitions, beside the floor: a loop that
calls the three events of such a state.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from sensor_msgs.msg import Image

from flexbe_core.core import EventState, OperatableStateMachine
from flexbe_core.engine.engine import Engine
from flexbe_core.engine.supervision import UNSUPERVISED
from flexbe_core.engine.user_data import UserData

_REPETITIONS = 9


class NothingState(EventState):
    """Do nothing."""

    def __init__(self) -> None:
        """Declare the outcome."""
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
        """Take the number of rounds."""
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
        """Declare the keys."""
        super().__init__(outcomes=["done"], input_keys=["image"], output_keys=["copy"])

    def execute(self, userdata: UserData) -> str:
        """Hand it on."""
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


def least(run: Callable[[], object]) -> float:
    """Return the least time [s] that `run` takes."""
    times = []
    for _ in range(_REPETITIONS):
        begin = time.perf_counter()
        run()
        times.append(time.perf_counter() - begin)
    return min(times)


def run(root: OperatableStateMachine) -> None:
    """Run a machine on a new engine, as a behavior would be."""
    Engine(root).run(0.0, lambda: False)


def floor(transitions: int) -> None:
    """Call the events of a state."""
    state, userdata = NothingState(), UserData()
    execute = NothingState.execute
    for _ in range(transitions):
        state.on_enter(userdata)
        execute(state, userdata)
        state.on_exit(userdata)


def main() -> None:
    """Print the table."""
    floor_us = least(lambda: floor(10_000)) / 10_000 * 1e6
    rows = [("floor: three calls", floor_us)]
    for states, rounds in ((10, 1), (1_000, 1), (5_000, 1), (10, 1_000), (100, 100), (1, 10_000)):
        root = machine(states, rounds)
        transitions = (states + 1) * rounds
        seconds = least(lambda root=root: run(root))
        rows.append((f"{states} states x {rounds} rounds", seconds / transitions * 1e6))
    with_image = machine(10, 100, ImageState)
    with_image.userdata.image = Image(data=b"\0" * 900_000)
    rows.append(
        ("10 states x 100 rounds, 0.9 MB image", least(lambda: run(with_image)) / 1_100 * 1e6)
    )
    for name, microseconds in rows:
        print(f"{name:<40}{microseconds:8.2f} us {microseconds / floor_us:6.1f} x floor")


if __name__ == "__main__":
    main()
