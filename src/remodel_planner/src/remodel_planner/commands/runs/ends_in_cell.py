"""Asks the cell where the ends of its wires are."""

from __future__ import annotations

import rospy
from remodel_msgs.srv import GetGroundTruth


def ends_in_cell() -> dict[str, tuple[str, str, bool]]:
    """Return where the ends a and b of each wire are, and whether both are fixed, by its name.

    Terminals are "component/terminal"; empty: none. A cell that cannot say, such as a real one
    without the service `cell/ground_truth`, has none.
    """
    try:
        wires = rospy.ServiceProxy("cell/ground_truth", GetGroundTruth)().wires
    except rospy.ServiceException:
        return {}
    return {wire.wire_id: (wire.a_at, wire.b_at, wire.a_fixed and wire.b_fixed) for wire in wires}
