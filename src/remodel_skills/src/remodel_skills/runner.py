"""Run an ability without ROS: steps of the ability and of the cell in turn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from remodel_skills.robot_context import RobotContext, Steps

T = TypeVar("T")


def occupy(contexts: Sequence[RobotContext], steps: Steps[T]) -> Steps[T]:
    """Run an ability's steps, its robots marked busy until it ends."""
    for context in contexts:
        context.begin()
    try:
        return (yield from steps)
    finally:
        for context in contexts:
            context.end()


def run(tick: Callable[[], None], steps: Steps[T]) -> T:
    """Run steps to their end, a tick of the cell after each, and return their result.

    Raises what they raise.
    """
    while True:
        try:
            next(steps)
        except StopIteration as done:
            return done.value
        tick()
