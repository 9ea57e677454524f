"""Run an ability without ROS: steps of the ability and of the plant in turn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

from remodel_sim.abilities.execution.robot_context import RobotContext, Steps
from remodel_sim.physics.plant import Plant

T = TypeVar("T")


def advance(plant: Plant, context: RobotContext) -> None:
    """Advance the plant by one tick."""
    for _ in range(context.steps_per_tick):
        plant.step()


def occupy(contexts: Sequence[RobotContext], steps: Steps[T]) -> Steps[T]:
    """Run an ability's steps, its robots marked busy until it ends."""
    for context in contexts:
        context.begin()
    try:
        return (yield from steps)
    finally:
        for context in contexts:
            context.end()


def run(plant: Plant, context: RobotContext, steps: Steps[T]) -> T:
    """Run steps to their end and return their result; raises what they raise."""
    while True:
        try:
            next(steps)
        except StopIteration as done:
            return done.value
        advance(plant, context)
