"""The cell's node: parameters in, servers up, the owner's loop."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import rospy
import yaml
from genpy import MessageException

from flexbe_core.ros.master import join, spin
from remodel_sim.cell import Cell
from remodel_sim.edge.cell_file import read_cell
from remodel_sim.edge.cell_memory import CellMemory
from remodel_sim.edge.film import Film
from remodel_sim.ros.ability_server import CellAbilityServer
from remodel_sim.ros.conversions import read_panel
from remodel_sim.ros.filming import Filming
from remodel_sim.ros.markers import Markers
from remodel_sim.ros.owner import Owner
from remodel_sim.ros.publishers import FixedFrames, Pictures, RobotState
from remodel_sim.ros.services import Services
from remodel_sim.ros.sim_clock import SimClock
from remodel_skills.abilities.ability import cell_abilities
from remodel_skills.belief_state import NO_CHANNEL
from remodel_skills.observers import Observers
from remodel_states.core.ability_choice import chosen_abilities
from remodel_states.core.wires.wire_materials import WireMaterials
from remodel_states.edge.exported_tables import read_abilities
from remodel_states.edge.wire_material_file import read_wire_materials
from remodel_work.cell.cell_design import CellDesign
from remodel_work.errors import CellError
from remodel_work.panel import WireEnd

# The owner's thread computes without pause; rospy's threads get their turn this often [s].
SWITCH_INTERVAL_S = 0.001
RATES_HZ = (120, 2000)


def main() -> int:
    """Run the cell until ROS shuts down; returns the exit code."""
    join("cell")
    sys.setswitchinterval(SWITCH_INTERVAL_S)
    with ExitStack() as closing:
        try:
            rows, abilities = read_abilities(), cell_abilities()
            served = chosen_abilities(
                list(abilities), rospy.get_param("~abilities", ""), rospy.get_param("~except", "")
            )
            materials = read_wire_materials()
            owner = _build(materials, closing)
        except (CellError, OSError, ValueError, yaml.YAMLError, MessageException) as error:
            rospy.logfatal("the cell does not start: %s", error)
            return 1
        for name in served:
            CellAbilityServer(rows[name], abilities[name], owner)
        Services(owner, materials)
        rospy.loginfo("the cell is ready")
        return spin(owner.spin)


def _build(materials: WireMaterials, closing: ExitStack) -> Owner:
    rate_hz = float(rospy.get_param("~rate_hz", 240.0))
    if not RATES_HZ[0] <= rate_hz <= RATES_HZ[1]:
        raise ValueError(f"rate_hz is {rate_hz}; allowed: {RATES_HZ[0]} to {RATES_HZ[1]}")
    panel = read_panel(Path(rospy.get_param("~panel")), materials)
    design = read_cell(str(rospy.get_param("~cell", "one_panda")))
    record, camera = _recording(design)
    memory = _memory(closing)
    clock = SimClock(memory)
    fixed = FixedFrames(clock)
    cell = Cell(
        panel,
        design=design,
        seed=int(rospy.get_param("~seed", 0)),
        rate_hz=rate_hz,
        gui=bool(rospy.get_param("~gui", False)),
        observers=Observers(Pictures(design, clock), fixed),
        memory=memory,
    )
    closing.callback(cell.close)
    wire_id = str(rospy.get_param("~feed", ""))
    if wire_id and wire_id not in cell.plant.parked:
        channel_id = NO_CHANNEL
        if design.magazine is None:
            mouth = panel.panel_from_socket(*panel.wire(wire_id).goes_to(WireEnd.A)).position
            channel_id = panel.channel_in_front_of(mouth).id
        cell.feed(wire_id, channel_id)
    publishers: list[Callable[[], None]] = [
        RobotState(cell.plant, clock, fixed),
        Markers(cell.plant, clock),
    ]
    if record is not None:
        filming = Filming(cell, clock, Film(record), camera)
        closing.callback(filming.close)
        publishers.append(filming)
    return Owner(cell, clock, publishers)


def _memory(closing: ExitStack) -> CellMemory | None:
    """Return what the cell keeps of its world; None if it keeps nothing."""
    folder = str(rospy.get_param("~memory", ""))
    if folder and not Path(folder).is_absolute():
        raise ValueError(f"memory is {folder!r}; name an absolute path, such as $PWD/{folder}")
    if not folder:
        return None
    memory = CellMemory(Path(folder))
    closing.callback(memory.close)
    return memory


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
