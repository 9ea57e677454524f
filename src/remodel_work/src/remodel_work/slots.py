"""Slots of ducts before terminals: there a wire passes from its terminal into the duct."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from remodel_work.geometry import Pose
from remodel_work.panel import Duct, Panel

# A duct's wall that stands so near before an opening is the one that its wire passes [m].
BEFORE_M = 0.060
# A wall stands across an opening's axis if their directions differ from a right angle by less.
ACROSS_RAD = math.radians(20.0)


@dataclass(frozen=True)
class Slot:
    """A slot in a duct's wall, seen from an opening.

    Attributes:
        aside: from the opening's axis, along the opening's y [m].
        before: from the opening, against its axis [m].
    """

    aside: float
    before: float

    @property
    def slant(self) -> float:
        """Yaw of a wire that runs straight from the slot to the opening, from its axis [rad]."""
        return -math.atan2(self.aside, self.before)


def slot_before(panel: Panel, opening: Pose) -> Slot | None:
    """Return the slot nearest to an opening's axis; None where no slotted duct stands before it.

    Args:
        panel: with its ducts.
        opening: its frame, x into the terminal, panel frame.
    """
    found = [slot for duct in panel.ducts if (slot := _slot_of(duct, opening)) is not None]
    return min(found, key=lambda slot: abs(slot.aside), default=None)


def _slot_of(duct: Duct, opening: Pose) -> Slot | None:
    if not duct.slot_pitch:
        return None
    into_duct = duct.panel_from_duct.inverse() @ opening
    out = -into_duct.rotation[:, 0]
    along, across, _ = (float(v) for v in into_duct.position)
    if abs(out[0]) > math.sin(ACROSS_RAD) or across * out[1] >= 0:
        return None
    away = abs(across) - duct.width / 2
    if not 0 <= away <= BEFORE_M or abs(along) > duct.length / 2:
        return None
    slot = round(along / duct.slot_pitch) * duct.slot_pitch
    aside = np.array([slot - along, 0.0, 0.0])
    return Slot(float(aside @ into_duct.rotation[:, 1]), away)
