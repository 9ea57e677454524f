"""The cell's node: parameters in, servers up, the owner's loop."""

from __future__ import annotations

import sys
from pathlib import Path

import rospy
import yaml
from genpy import MessageException

from remodel_sim.cell import Cell
from remodel_sim.core.errors import CellError
from remodel_sim.core.panel import End
from remodel_sim.core.wire_materials import WireMaterials
from remodel_sim.edge.cell_file import read_cell
from remodel_sim.edge.wire_material_file import read_wire_materials
from remodel_sim.ros.abilities import ABILITIES
from remodel_sim.ros.ability_server import AbilityServer
from remodel_sim.ros.conversions import read_panel
from remodel_sim.ros.markers import Markers
from remodel_sim.ros.owner import Owner
from remodel_sim.ros.publishers import Pictures, RobotState
from remodel_sim.ros.services import Services
from remodel_sim.ros.sim_clock import SimClock

# The owner's thread computes without pause; rospy's threads get their turn this often [s].
SWITCH_INTERVAL_S = 0.001
RATES_HZ = (120, 2000)


def main() -> int:
    """Run the cell until ROS shuts down; returns the exit code."""
    rospy.init_node("cell")
    sys.setswitchinterval(SWITCH_INTERVAL_S)
    try:
        materials = read_wire_materials()
        owner = _build(materials)
    except (CellError, OSError, ValueError, yaml.YAMLError, MessageException) as error:
        rospy.logfatal("the cell does not start: %s", error)
        return 1
    for ability in ABILITIES:
        AbilityServer(ability, owner)
    Services(owner, materials)
    rospy.loginfo("the cell is ready")
    owner.spin()
    owner.cell.close()
    return 0


def _build(materials: WireMaterials) -> Owner:
    rate_hz = float(rospy.get_param("~rate_hz", 240.0))
    if not RATES_HZ[0] <= rate_hz <= RATES_HZ[1]:
        raise ValueError(f"rate_hz is {rate_hz}; allowed: {RATES_HZ[0]} to {RATES_HZ[1]}")
    panel = read_panel(Path(rospy.get_param("~panel")), materials)
    design = read_cell(str(rospy.get_param("~cell", "one_panda")))
    clock = SimClock()
    cell = Cell(
        panel,
        design=design,
        seed=int(rospy.get_param("~seed", 0)),
        rate_hz=rate_hz,
        gui=bool(rospy.get_param("~gui", False)),
        solid_parked=bool(rospy.get_param("~solid_parked", False)),
        on_look=Pictures(design, clock),
    )
    wire_id = str(rospy.get_param("~feed", ""))
    if wire_id:
        mouth = panel.panel_from_socket(*panel.wire(wire_id).goes_to(End.A)).position
        cell.feed(wire_id, panel.channel_in_front_of(mouth).id)
    return Owner(cell, clock, (RobotState(cell.plant, clock), Markers(cell.plant, clock)))
