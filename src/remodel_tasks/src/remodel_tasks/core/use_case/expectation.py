"""How long abilities take, and how often they succeed.

This is the one place where experience enters the planner: whatever offers `expect` can stand for a
use case's frozen values.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from remodel_tasks.core.condition import Condition, Features


@dataclass(frozen=True)
class Expectation:
    """What one call of an ability is expected to take [s], and the probability of its success."""

    duration_s: float
    success: float

    def tried(self, attempts: int, between_s: float = 0.0) -> Expectation:
        """Return what is expected of up to that many calls, until the first that succeeds.

        Args:
            attempts: at least 1.
            between_s: what recovering from a failure takes.
        """
        failure = (1 - self.success) ** attempts
        calls = (1 - failure) / self.success if self.success > 0 else attempts
        return Expectation(self.duration_s * calls + between_s * (calls - 1), 1 - failure)

    def then(self, other: Expectation) -> Expectation:
        """Return what is expected of this and another call after it."""
        return Expectation(self.duration_s + other.duration_s, self.success * other.success)


NOTHING = Expectation(0.0, 1.0)


class Expectations(Protocol):
    """Knows what to expect of abilities."""

    def expect(self, ability: str, features: Features) -> Expectation:
        """Return what is expected of a call of the ability for a task with these features."""


@dataclass(frozen=True)
class Frozen:
    """An expectation that a use case states, for the tasks that meet its condition.

    Attributes:
        per_m_s: [s] more for each metre of the task's length.
    """

    when: Condition
    duration_s: float
    per_m_s: float
    success: float


@dataclass(frozen=True)
class FrozenExpectations:
    """What a use case states, before there is experience: the first that applies counts."""

    stated: dict[str, tuple[Frozen, ...]]

    def expect(self, ability: str, features: Features) -> Expectation:
        """Return what is expected of a call of the ability for a task with these features."""
        frozen = next(item for item in self.stated[ability] if item.when.holds(features))
        length_m = float(features.get("length_m", 0.0))
        return Expectation(frozen.duration_s + frozen.per_m_s * length_m, frozen.success)
