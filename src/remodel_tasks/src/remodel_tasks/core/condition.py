"""Conditions on a wire or a task, and the circumstances in which an ability was called for one.

A condition is a conjunction of tests of named values. In YAML:
`{NAME: VALUE, NAME: [VALUE, ...], NAME: {at_least: NUMBER, at_most: NUMBER}, ...}`.

A value of the task that is not there, such as a component's clamp where no end is concerned,
passes no test.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

Value = str | float | bool
Features = Mapping[str, Value]


@dataclass(frozen=True)
class Test:
    """A test of one value: it is one of some, or a number in a range.

    Attributes:
        one_of: values allowed; empty: any number from `least` to `most`.
    """

    name: str
    one_of: tuple[Value, ...] = ()
    least: float = -math.inf
    most: float = math.inf

    def passes(self, features: Features) -> bool:
        """Return whether the value is as required."""
        value = features.get(self.name)
        if self.one_of:
            return any(_same(value, allowed) for allowed in self.one_of)
        return is_number(value) and self.least <= float(value) <= self.most  # type: ignore[arg-type]

    def reason(self, features: Features) -> str:
        """Return why it does not pass."""
        found = features.get(self.name, "not given")
        if self.one_of:
            return f"{self.name} is {found}, not {' or '.join(map(str, self.one_of))}"
        bounds = []
        if self.least > -math.inf:
            bounds.append(f"at least {self.least:g}")
        if self.most < math.inf:
            bounds.append(f"at most {self.most:g}")
        return f"{self.name} is {found}, not {' and '.join(bounds)}"

    @classmethod
    def stated(cls, name: str, asked: object) -> Test:
        """Return the test that YAML of the right form states."""
        if isinstance(asked, Mapping):
            least, most = asked.get("at_least", -math.inf), asked.get("at_most", math.inf)
            return cls(name, (), least, most)
        return cls(name, tuple(asked) if isinstance(asked, list | tuple) else (asked,))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Condition:
    """Tests that must all pass; none: always true."""

    tests: tuple[Test, ...] = ()

    def holds(self, features: Features) -> bool:
        """Return whether all tests pass."""
        return all(test.passes(features) for test in self.tests)

    def reason(self, features: Features) -> str:
        """Return why it does not hold: the first test that fails."""
        return next(test.reason(features) for test in self.tests if not test.passes(features))


def is_number(value: object) -> bool:
    """Return whether a value is a number; true and false are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def _same(value: object, allowed: Value) -> bool:
    # True equals 1 in Python, and means something else here.
    return value == allowed and isinstance(value, bool) == isinstance(allowed, bool)


# An ability, then "feature=value", the most general first.
Context = tuple[str, ...]

# Of a task's features, those that abilities may depend on, the most general first: type of the
# connector or terminal, gauge, direction of approach, view.
_FEATURES = ("terminal_type", "section_mm2", "approach", "view")


def context_of(ability: str, features: Features) -> Context:
    """Return the context of a call; features that are not known are left out."""
    known = [(name, features[name]) for name in _FEATURES if name in features]
    return (ability, *(f"{name}={_text(value)}" for name, value in known))


def terminal_features(kind: str, approach: Sequence[float] | None) -> dict[str, Value]:
    """Return the features of a terminal, as far as they are known.

    Args:
        kind: its type; empty if it is not known.
        approach: unit vector along which an end goes in, component's frame.
    """
    features: dict[str, Value] = {"terminal_type": kind} if kind else {}
    if approach is not None:
        features["approach"] = " ".join(f"{round(part, 1) + 0.0:g}" for part in approach)
    return features


def _text(value: str | float | bool) -> str:
    return f"{value:g}" if isinstance(value, float | int) else value
