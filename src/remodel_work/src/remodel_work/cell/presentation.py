"""Where a wire is presented to a robot: what the feeder and the magazine have in common."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from remodel_work.geometry import Pose
from remodel_work.panel import WireEnd


@dataclass(frozen=True, eq=False)
class Presentation:
    """A wire whose ends wait at known places.

    Attributes:
        tips: where each end's apex should be, x out of the wire, z of its axis, world frame.
        direction: +1 when the wire runs from end a towards +y, else -1.
    """

    tips: Mapping[WireEnd, Pose]
    direction: int
