"""Asks the cell what was built: where its wires are, and what the cabinet looks like."""

from __future__ import annotations

from collections.abc import Mapping

import rospy
from remodel_msgs.srv import GetGroundTruth

from remodel_planner.core.reports.net_list import FoundEnd, FoundWire
from remodel_planner.core.reports.run_report import Picture
from remodel_production.core.production import Order, TerminalRef
from remodel_production.errors import LostError
from remodel_supervision.errors import RefusedError
from remodel_supervision.ros.peers.cell import Cell
from remodel_supervision.ros.peers.pictures import jpeg

# The camera that sees the whole cabinet from above.
_CAMERA = "overhead"


def wires_in_cell(order: Order) -> tuple[Mapping[str, FoundWire], str]:
    """Return the wires of which the cell has a piece, by name, or why it did not say.

    Only a simulated cell has the service `cell/ground_truth`.
    """
    try:
        truths = rospy.ServiceProxy("cell/ground_truth", GetGroundTruth)().wires
    except rospy.ServiceException as error:
        return {}, f"the cell gave no ground truth, as no real cell does ({error})"
    terminals = {
        f"{component.name}/{terminal.name}": TerminalRef(component.name, terminal.name)
        for component in order.components
        for terminal in component.terminals
    }

    def found(at: str, fixed: bool) -> FoundEnd:
        ref = terminals.get(at) or TerminalRef(*at.partition("/")[::2])
        return FoundEnd(ref if at else None, fixed)

    return {
        truth.wire_id: FoundWire(
            found(truth.a_at, truth.a_fixed),
            found(truth.b_at, truth.b_fixed),
            duct_length_m=truth.duct_length,
            in_ducts=truth.in_ducts,
        )
        for truth in truths
    }, ""


def picture_of_cabinet() -> tuple[Picture, ...]:
    """Return a picture of the cabinet as it is now; none if the cell takes none."""
    try:
        image = Cell().picture(_CAMERA)
    except (RefusedError, LostError):
        return ()
    return (Picture.of_jpeg("The cabinet at the end, from above", jpeg(image)),)
