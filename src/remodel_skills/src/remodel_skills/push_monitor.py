"""The forces of a push, and whether the wire gives way.

A wire that meets the bottom may buckle before the force limit, and would keep the bend. It gives
way when the force near the bottom was great and falls. One that met something before hangs at the
face, bent already: what it does near the bottom shows nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from remodel_skills.parameters import WireParameters


@dataclass(frozen=True)
class PushMonitor:
    """The forces of a push so far, along it [N].

    Attributes:
        buckles: whether what is pushed may give way.
        wire: the forces that show it.
        peak: the largest.
        peak_before: the largest before it came near the bottom.
        now: the last.
    """

    buckles: bool
    wire: WireParameters
    peak: float = 0.0
    peak_before: float = 0.0
    now: float = 0.0

    def then(self, force: float, *, near_bottom: bool) -> PushMonitor:
        """Return the forces with one more."""
        peak = max(self.peak, force)
        before = self.peak_before if near_bottom else peak
        return replace(self, peak=peak, peak_before=before, now=force)

    @property
    def gave_way(self) -> bool:
        """Whether the wire buckles at the bottom."""
        free = self.buckles and self.peak_before < self.wire.free_way_n
        return (
            free
            and self.peak >= self.wire.gives_way_from_n
            and self.now < self.peak - self.wire.gives_way_by_n
        )
