"""A cell without ROS: the plant, and the station that the abilities use."""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from remodel_sim.abilities.runner import run
from remodel_sim.abilities.station import OnLook, Station, Steps
from remodel_sim.core.book import EndState, Feed
from remodel_sim.core.codes import Code
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.panel import End, Panel
from remodel_sim.physics.plant import Plant

T = TypeVar("T")

# An arm that was stopped, and the wire in its hand, come to rest in this time [s].
SETTLE_S = 0.15


class Cell:
    """One cell with one panel; what an operator and a feeder can do with it.

    Attributes:
        plant: the physical side.
        station: what abilities see of it.
    """

    def __init__(
        self,
        panel: Panel,
        *,
        seed: int = 0,
        rate_hz: float = 240.0,
        gui: bool = False,
        solid_parked: bool = False,
        on_look: OnLook | None = None,
    ) -> None:
        """Build the cell, see Plant; raises PanelError."""
        self.plant = Plant(panel, seed=seed, rate_hz=rate_hz, gui=gui, solid_parked=solid_parked)
        self._on_look = on_look
        self.station = Station(self.plant, on_look)

    def load(self, panel: Panel) -> None:
        """Build another panel; raises PanelError and changes nothing when it breaks the rules."""
        self.plant.load(panel)
        self.station = Station(self.plant, self._on_look)

    def reset(self) -> None:
        """Build the same panel anew; every wire is taken away."""
        self.load(self.plant.panel)

    def feed(self, wire_id: str, channel_id: str) -> None:
        """Lay a wire into a channel.

        Raises AbilityError when a name is unknown or the hand holds a wire.
        """
        book = self.station.book
        wire = self.plant.panel.wire(wire_id)
        self.plant.panel.channel(channel_id)
        if book.grip is not None and book.feed is not None:
            raise AbilityError(
                Code.OTHER_CABLE_HELD,
                f"the gripper holds end {book.grip.end.value} of {book.feed.wire_id!r}; place it "
                "first",
            )
        laying = self.plant.feed(wire_id, channel_id, self.station.commanded)
        self.station.arm_restarted()
        straight = np.array([0.0, laying.direction * wire.length])
        expected = {End.A: laying.tip_a, End.B: laying.tip_a + straight}
        book.start_wire(Feed(wire_id, channel_id, laying.direction), expected)

    def run(self, steps: Steps[T]) -> T:
        """Run an ability to its end; raises what it raises."""
        try:
            return run(self.plant, self.station, steps)
        finally:
            self.settle()

    def settle(self) -> float:
        """Let the scene come to rest after an ability, however it ended.

        Return the time that passed [s].

        The live wire is parked once both its ends are fixed and let go.
        """
        steps = round(SETTLE_S / self.plant.world.time_step)
        for _ in range(steps):
            self.plant.step()
        book = self.station.book
        placed = book.ends and all(state is EndState.FIXED for state in book.ends.values())
        if placed and book.grip is None:
            self.plant.park()
        return steps * self.plant.world.time_step

    def close(self) -> None:
        """Leave PyBullet."""
        self.plant.close()
