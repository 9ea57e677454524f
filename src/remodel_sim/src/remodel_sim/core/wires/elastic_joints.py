"""The elastic joints of a wire in motion: their shape at rest, the set they took, their torques."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from remodel_sim.core.wires.wire_mechanics import CableModel, rotation_vectors
from remodel_work.geometry import Array

# How fast a joint's shape at rest is changed for good [rad/s].
TURN_RAD_S = 0.5


class ElasticJoints:
    """All joints of a wire but the bolted ones, in their order."""

    def __init__(self, model: CableModel, time_step: float) -> None:
        """Take the joints of a wire, straight at rest; `time_step` in [s]."""
        self._elastic = model.spans > 0.0
        self._model = replace(
            model,
            spans=model.spans[self._elastic],
            stiffness=model.stiffness[self._elastic],
            yield_angles=model.yield_angles[self._elastic],
        )
        self._turn_per_step = TURN_RAD_S * time_step
        self.rest_at(np.zeros(len(model.spans)))

    def rest_at(self, rest: Array) -> None:
        """Set the angle at rest of each joint about its x axis [rad], and forget any set.

        Args:
            rest: (n - 1,), of the bolted joints as well.
        """
        angles = rest[self._elastic]
        self._rest = np.zeros((len(angles), 3))
        self._rest[:, 0] = angles
        self._plastic = np.zeros((len(angles), 2))
        self._to_turn = np.zeros(len(angles))

    def bend_rest(self, joint: int, angle: float) -> None:
        """Turn a joint's shape at rest about its x axis [rad], over the next steps.

        So slowly that the joint follows instead of taking a set the other way.
        """
        self._to_turn[joint] += angle

    def torques(self, turns: Array, rates: Array) -> Array:
        """Let the joints yield; return their elastic torques for the next step.

        Args:
            turns: (joints, 4) quaternion of each link in the frame of the one before.
            rates: (joints, 3) [rad/s], joint frame.

        Returns:
            (joints, 3) [N m], joint frame.
        """
        if self._to_turn.any():
            turn = np.clip(self._to_turn, -self._turn_per_step, self._turn_per_step)
            self._rest[:, 0] += turn
            self._to_turn -= turn
        bend = rotation_vectors(turns) - self._rest
        self._plastic = self._model.yielded(bend[:, :2], self._plastic)
        bend[:, :2] -= self._plastic
        return self._model.torques(bend, rates)
