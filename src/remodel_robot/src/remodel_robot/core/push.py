"""A push along one axis: how far it goes, and what it ended with.

APPROACH --opening reached--> PUSH --force limit--> ended   (seated, jammed or misaligned)
+--deepest-------> ended   (nothing was met)
"""

from __future__ import annotations

from dataclasses import dataclass

from remodel_states.core.codes import Code

FACE_M = 0.003
"""[m] An end that stops before this depth has met the face beside the opening."""


@dataclass(frozen=True)
class PushRules:
    """What is true of your terminals and your robot.

    Attributes:
        standoff_m: [m] before the opening, where the push begins.
        speed_m_s: [m/s] of the equilibrium pose.
        seated_m: [m] at which depth an end sits, at least.
        deepest_m: [m] at which a push ends that meets nothing.
    """

    standoff_m: float = 0.005
    speed_m_s: float = 0.01
    seated_m: float = 0.012
    deepest_m: float = 0.02

    def __post_init__(self) -> None:
        """Refuse what cannot be.

        Raises:
            ValueError: which value, what was found, and what is allowed.
        """
        for name, value in vars(self).items():
            if not value > 0.0:
                raise ValueError(f"{name} is {value:g}; allowed: more than 0")
        if self.seated_m > self.deepest_m:
            raise ValueError(
                f"seated_m is {self.seated_m:g}; allowed: up to deepest_m, {self.deepest_m:g}"
            )


class Push:
    """One push.

    Attributes:
        depth_m: [m] of the equilibrium pose behind the opening; negative before it.
        peak_n: [N] largest force so far.
    """

    def __init__(self, rules: PushRules, force_limit: float) -> None:
        """Begin before the opening.

        Args:
            rules: of the cell.
            force_limit: [N] at which the push ends.
        """
        self._rules = rules
        self._force_limit = force_limit
        self.depth_m = -rules.standoff_m
        self.peak_n = 0.0

    @property
    def has_ended(self) -> bool:
        """Whether the force limit or the deepest place is reached."""
        return self.peak_n >= self._force_limit or self.depth_m >= self._rules.deepest_m

    @property
    def percentage(self) -> float:
        """How much of the way is done, 0 to 100; an end that sits may stop before 100."""
        whole = self._rules.standoff_m + self._rules.deepest_m
        return 100.0 * (self.depth_m + self._rules.standoff_m) / whole

    def advance(self, seconds: float, force_n: float) -> None:
        """Go on for some time [s], with the force [N] that was measured last."""
        self.peak_n = max(self.peak_n, abs(force_n))
        if not self.has_ended:
            ahead = self.depth_m + self._rules.speed_m_s * seconds
            self.depth_m = min(ahead, self._rules.deepest_m)

    @property
    def problem(self) -> Code:
        """Return why the end does not sit; NONE if it does."""
        if self.peak_n < self._force_limit:
            return Code.INSERTION_NO_CONTACT
        if self.depth_m >= self._rules.seated_m:
            return Code.NONE
        is_face = self.depth_m < FACE_M
        return Code.INSERTION_MISALIGNED if is_face else Code.INSERTION_JAMMED

    def __str__(self) -> str:
        """Return what was measured."""
        return f"{self.peak_n:.1f} N at {1000.0 * self.depth_m:.1f} mm"
