"""The node of a simulated cell, and its clock."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Protocol

import rospy
from rosgraph_msgs.msg import Clock

from remodel_sim.edge.film import Film
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.ros.publishers import Filming, Markers, RobotState
from remodel_sim.ros.services import Owner, Services
from remodel_vision.ros.image_message import FixedFrames
from remodel_work.cell.cell_design import CellDesign
from remodel_work.edge.cell_file import read_cell
from remodel_work.panel import Panel

# How often the clock is published [s of simulated time].
PERIOD_S = 0.02
# A pause of the process, as for a render, is not made up for by more than this at once [s].
MAX_CATCH_UP_S = 0.1


class KeptTime(Protocol):
    """What keeps the time of a cell that is killed."""

    time_s: float

    def keep_time(self, now_s: float) -> None:
        """Keep the time [s]."""


class SimClock:
    """Time that the cell makes.

    As fast as it can while an ability runs, at the pace of the wall between goals.

    Attributes:
        listeners: are called whenever time has passed.
    """

    def __init__(self, memory: KeptTime | None = None) -> None:
        """Start at one second: zero means "no time yet" in ROS.

        `memory` keeps the time; with it a restarted cell continues where it was, since nodes
        take time that goes back for a restart of the simulation.
        """
        self._memory = memory
        self.listeners: list[Callable[[], None]] = []
        kept_s = memory.time_s if memory else 0.0
        self.now_s = kept_s + PERIOD_S if kept_s else 1.0
        self._published_s = 0.0
        self._wall = time.monotonic()
        self._publisher = rospy.Publisher("/clock", Clock, queue_size=10)
        self._publish()

    @property
    def now(self) -> rospy.Time:
        """The simulated time."""
        return rospy.Time.from_sec(self.now_s)

    def advance(self, seconds: float) -> None:
        """Let simulated time pass."""
        self._wall = time.monotonic()
        self._move(seconds)

    def idle(self) -> None:
        """Let as much simulated time pass as wall time has passed."""
        wall = time.monotonic()
        self._move(min(wall - self._wall, MAX_CATCH_UP_S))
        self._wall = wall

    def _move(self, seconds: float) -> None:
        self.now_s += seconds
        if self.now_s - self._published_s >= PERIOD_S:
            self._publish()
        for listener in self.listeners:
            listener()

    def _publish(self) -> None:
        self._published_s = self.now_s
        if self._memory is not None:
            self._memory.keep_time(self.now_s)
        self._publisher.publish(Clock(self.now))


RATES_HZ = (120, 2000)


class SimulatedCell:
    """A plant whose time is ROS's.

    Attributes:
        plant: the physics.
        clock: its time.
        kind: for people.
    """

    kind = "simulated"

    def __init__(self, panel: Panel, memory: KeptTime | None, closing: ExitStack) -> None:
        """Build a cell by the node's parameters; raises ValueError or CellError."""
        design = read_cell(str(rospy.get_param("~cell", "one_panda")))
        rate_hz = float(rospy.get_param("~rate_hz", 240.0))
        if not RATES_HZ[0] <= rate_hz <= RATES_HZ[1]:
            raise ValueError(f"rate_hz is {rate_hz}; allowed: {RATES_HZ[0]} to {RATES_HZ[1]}")
        record, camera = _recording(design)
        self.clock = SimClock(memory)
        self.plant = SimulatedPlant(
            panel,
            design=design,
            seed=int(rospy.get_param("~seed", 0)),
            rate_hz=rate_hz,
            gui=bool(rospy.get_param("~gui", False)),
        )
        self.plant.on_time = self._passed
        self._film: Filming | None = None
        if record is not None:
            self._film = Filming(self.plant, self.clock, Film(record), camera)
            closing.callback(self._film.close)

    def offer(self, owner: Owner, fixed: FixedFrames) -> None:
        """Begin to publish the state of robots and scene, and offer the simulator's services."""
        self.clock.listeners += [
            RobotState(self.plant, self.clock, fixed),
            Markers(self.plant, self.clock),
        ]
        Services(self.plant, owner)

    def _passed(self, seconds: float) -> None:
        self.clock.advance(seconds)
        if self._film is not None:
            self._film()


def _recording(design: CellDesign) -> tuple[Path | None, str]:
    """Return the folder that a run is filmed into, None: it is not, and with which camera."""
    folder = str(rospy.get_param("~record", ""))
    camera = str(rospy.get_param("~record_camera", "scene"))
    if folder and not Path(folder).is_absolute():
        raise ValueError(f"record is {folder!r}; name an absolute path, such as $PWD/{folder}")
    if camera not in design.camera_names:
        there_are = ", ".join(design.camera_names)
        raise ValueError(f"record_camera is {camera!r}; there are: {there_are}")
    return Path(folder) if folder else None, camera
