"""The simulated cell for a node: its plant, its clock, and what it publishes by itself."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

import rospy

from remodel_sim.edge.film import Film
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.ros.interfaces import (
    Filming,
    KeptTime,
    Markers,
    Owner,
    RobotState,
    Services,
    SimClock,
)
from remodel_vision.ros.image_message import FixedFrames
from remodel_work.cell.cell_design import CellDesign
from remodel_work.edge.cell_file import read_cell
from remodel_work.panel import Panel

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
