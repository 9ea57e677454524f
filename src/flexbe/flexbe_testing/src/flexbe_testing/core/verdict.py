"""How a test ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Verdict:
    """How a test ended.

    Attributes:
        title: what the test is called.
        complaints: what was not as it should be; none if the test succeeded.
    """

    title: str
    complaints: tuple[str, ...] = ()

    @property
    def is_good(self) -> bool:
        """Return whether the test succeeded."""
        return not self.complaints


def compare(
    expected_outcome: str | None,
    outcome: str | None,
    expected: Mapping[str, Any],
    outputs: Mapping[str, Any],
) -> tuple[str, ...]:
    """Return what is not as it should be."""
    complaints = []
    if expected_outcome is not None and outcome != expected_outcome:
        complaints.append(f"outcome is {outcome!r}; expected was {expected_outcome!r}")
    for key, value in expected.items():
        if key not in outputs:
            complaints.append(f"output {key!r} was not written; expected was {value!r:.200}")
        elif outputs[key] != value:
            found = outputs[key]
            complaints.append(f"output {key!r} is {found!r:.200}; expected was {value!r:.200}")
    return tuple(complaints)
