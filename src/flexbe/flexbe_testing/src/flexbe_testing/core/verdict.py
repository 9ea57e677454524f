"""How a test ended: whether it ran, its outcome, and each of its outputs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from flexbe_testing.core.case import Case

PASS, OUTCOME, OUTPUT = "pass", "outcome", "output_"
_NOT_REACHED = "not reached, because the case did not run to its end"


@dataclass(frozen=True)
class Check:
    """One result of a test.

    Attributes:
        name: `pass`, `outcome`, or `output_` and the key.
        complaint: what is not as it should be; empty if nothing.
    """

    name: str
    complaint: str = ""


@dataclass(frozen=True)
class Verdict:
    """How a test ended.

    Attributes:
        title: what the test is called.
        checks: its results, of which `pass` is the first: whether the case ran to its end.
    """

    title: str
    checks: tuple[Check, ...] = (Check(PASS),)

    @property
    def complaints(self) -> tuple[str, ...]:
        """Return what was not as it should be; none if the test succeeded."""
        return tuple(check.complaint for check in self.checks if check.complaint)

    @property
    def is_good(self) -> bool:
        """Return whether the test succeeded."""
        return not self.complaints

    def check(self, name: str) -> Check:
        """Return the result of a name."""
        return next(check for check in self.checks if check.name == name)


def check_names(case: Case) -> tuple[str, ...]:
    """Return the names of the results that a case has."""
    if case.import_only:
        return (PASS,)
    outcome = () if case.outcome is None else (OUTCOME,)
    return (PASS, *outcome, *(f"{OUTPUT}{key}" for key in case.outputs))


def not_run(case: Case, complaint: str) -> Verdict:
    """Return the verdict of a case that did not run to its end."""
    rest = (Check(name, _NOT_REACHED) for name in check_names(case)[1:])
    return Verdict(case.title, (Check(PASS, complaint), *rest))


def compare(
    expected_outcome: str | None,
    outcome: str | None,
    expected: Mapping[str, Any],
    outputs: Mapping[str, Any],
) -> tuple[Check, ...]:
    """Return the results of a case that ran: of its outcome, and of each output."""
    checks = []
    if expected_outcome is not None:
        text = f"outcome is {outcome!r}; expected was {expected_outcome!r}"
        checks.append(Check(OUTCOME, "" if outcome == expected_outcome else text))
    for key, value in expected.items():
        complaint = ""
        if key not in outputs:
            complaint = f"output {key!r} was not written; expected was {value!r:.200}"
        elif outputs[key] != value:
            found = outputs[key]
            complaint = f"output {key!r} is {found!r:.200}; expected was {value!r:.200}"
        checks.append(Check(f"{OUTPUT}{key}", complaint))
    return tuple(checks)
