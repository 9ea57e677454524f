"""One PyBullet world: its clock and its solver settings."""

from __future__ import annotations

from collections.abc import Callable

from remodel_sim.core.wires.wire_mechanics import GRAVITY
from remodel_work.edge.bullet import connect

# A wire's link of half a gram between two fingers makes the contact solver converge a thousand
# times too slowly. Wires get this many times their mass, and gravity is as many times weaker:
# weights, and with them all statics and friction, stay true; only a free wire moves more slowly.
# Everything else is bolted down or driven by stiff servos.
MASS_SCALE = 20.0
# A held wire creeps through the grip by 0.3 mm while the hand carries and pushes it, by 0.2 mm with
# 200 iterations, which take twice as long.
SOLVER_ITERATIONS = 80
# The solver stops when an iteration changes no velocity by more than 0.5 mm/s [(m/s)^2]. At four
# times as much the grip loses 15 % of its friction.
SOLVER_RESIDUAL = 3e-7
# Stiff penalty contacts keep a jammed ferrule within 0.35 mm of a wall at few iterations.
CONTACT_STIFFNESS = 1e5
CONTACT_DAMPING = 200.0


class World:
    """A PyBullet world with a fixed time step. Only the thread that made it may use it.

    Attributes:
        bullet: PyBullet's functions, bound to this world.
        time_step: [s].
        steps: number of steps made since the world was built.
    """

    def __init__(self, rate_hz: float, *, gui: bool = False) -> None:
        """Connect; `gui` opens PyBullet's window."""
        self.bullet = connect(gui=gui)
        self.time_step = 1.0 / rate_hz
        self.steps = 0
        self._before_step: list[Callable[[], None]] = []
        self.clear()

    def clear(self) -> None:
        """Remove every body and restart the count of steps."""
        self.bullet.resetSimulation()
        self.bullet.setGravity(0, 0, -GRAVITY / MASS_SCALE)
        self.bullet.setPhysicsEngineParameter(
            fixedTimeStep=self.time_step,
            numSolverIterations=SOLVER_ITERATIONS,
            solverResidualThreshold=SOLVER_RESIDUAL,
            deterministicOverlappingPairs=1,
            enableFileCaching=0,
        )
        self._before_step.clear()
        self.steps = 0

    def add_before_step(self, action: Callable[[], None]) -> None:
        """Call `action` before every step from now on."""
        self._before_step.append(action)

    def remove_before_step(self, action: Callable[[], None]) -> None:
        """Stop calling `action`."""
        self._before_step.remove(action)

    def step(self) -> None:
        """Advance by one time step."""
        for action in tuple(self._before_step):
            action()
        self.bullet.stepSimulation()
        self.steps += 1

    def close(self) -> None:
        """Disconnect."""
        self.bullet.disconnect()
