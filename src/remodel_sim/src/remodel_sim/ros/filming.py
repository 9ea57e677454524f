"""Films a run: a picture every so often of simulated time, while a robot works."""

from __future__ import annotations

import rospy

from remodel_sim.core.errors import FilmError
from remodel_sim.edge.film import Film
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.ros.sim_clock import SimClock

# Between two pictures [s of simulated time]; the film shows ten a second, so it runs at four times
# the cell's pace.
PERIOD_S = 0.4


class Filming:
    """Takes the pictures; a cancel waits for one at most, some 0.1 s."""

    def __init__(self, plant: SimulatedPlant, clock: SimClock, film: Film, camera: str) -> None:
        """Film with a camera of the cell."""
        self._plant = plant
        self._clock = clock
        self._film = film
        self._camera = camera
        self._taken_s = 0.0
        self._stopped = False

    def __call__(self) -> None:
        """Take a picture when it is time."""
        if self._stopped or self._clock.now_s - self._taken_s < PERIOD_S:
            return
        self._taken_s = self._clock.now_s
        try:
            self._film.add(self._plant.film(self._camera))
        except FilmError as error:
            rospy.logerr("%s; no more pictures are taken", error)
            self._stopped = True

    def close(self) -> None:
        """End the film."""
        try:
            self._film.close()
        except FilmError as error:
            rospy.logerr("%s", error)
