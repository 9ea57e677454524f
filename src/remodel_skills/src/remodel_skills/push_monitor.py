"""The forces of a push, and whether the wire gives way.

A wire that meets the bottom may buckle before the force limit, and would keep the bend. It gives
way when the force near the bottom was great and falls. One that met something before hangs at the
face, bent already: what it does near the bottom shows nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

# A wire rubs with some 1 N in its opening; one that meets no more is free [N].
FREE_WAY_N = 2.0
# The force that falls, and by how much [N].
GIVES_WAY_FROM_N = 4.0
GIVES_WAY_BY_N = 0.5


@dataclass(frozen=True)
class PushMonitor:
    """The forces of a push so far, along it [N].

    Attributes:
        buckles: whether what is pushed may give way.
        peak: the largest.
        peak_before: the largest before it came near the bottom.
        now: the last.
    """

    buckles: bool
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
        free = self.buckles and self.peak_before < FREE_WAY_N
        return free and self.peak >= GIVES_WAY_FROM_N and self.now < self.peak - GIVES_WAY_BY_N
