"""Run an ability without ROS: steps of the ability and of the plant in turn."""

from __future__ import annotations

from typing import TypeVar

from remodel_sim.abilities.station import Progress, Station, Steps
from remodel_sim.physics.plant import Plant

T = TypeVar("T")


def advance(plant: Plant, station: Station) -> None:
    """Let one tick pass."""
    for _ in range(station.steps_per_tick):
        plant.step()


def run(plant: Plant, station: Station, steps: Steps[T]) -> T:
    """Run an ability to its end and return its result; raises what it raises."""
    station.progress = Progress()
    while True:
        try:
            next(steps)
        except StopIteration as done:
            return done.value
        advance(plant, station)
