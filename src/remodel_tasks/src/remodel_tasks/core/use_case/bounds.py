"""Within which values a parameter may be chosen."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

# name -> value, sorted by name; hashable.
Setting = tuple[tuple[str, float], ...]

# [settings] The trials of an order cannot compare more.
_MOST_SETTINGS = 30


@dataclass(frozen=True)
class Bounds:
    """What is safe for a parameter; its unit is the parameter's.

    Attributes:
        frozen: value that is used without learning.
        low: least safe value.
        high: greatest safe value.
        count: how many values are tried; the frozen one is among them.
    """

    frozen: float
    low: float
    high: float
    count: int = 5

    def __post_init__(self) -> None:
        """Refuse bounds that hold no choice.

        Raises:
            ValueError: if they are not in order, or there are fewer than two values.
        """
        if not -math.inf < self.low <= self.frozen <= self.high < math.inf or self.count < 2:
            raise ValueError(
                f"bounds must be low <= frozen <= high with a count of at least 2, found "
                f"{self.low:g}, {self.frozen:g}, {self.high:g}, {self.count}"
            )

    @property
    def values(self) -> tuple[float, ...]:
        """The values that are tried, evenly spaced but for the frozen one."""
        step = (self.high - self.low) / (self.count - 1)
        even = [self.low + step * i for i in range(self.count)]
        nearest = min(range(self.count), key=lambda i: abs(even[i] - self.frozen))
        even[nearest] = self.frozen
        return tuple(sorted(set(even)))


def frozen_setting(bounds: Mapping[str, Bounds]) -> Setting:
    """Return the setting that is used without learning."""
    return tuple((name, bounds[name].frozen) for name in sorted(bounds))


def nearer_settings(bounds: Mapping[str, Bounds]) -> dict[Setting, Setting]:
    """Return, of each setting but the frozen one, its neighbour towards the frozen one.

    The parameter that is the most steps away goes one step back.
    """
    return {
        setting: _nearer(setting, bounds)
        for setting in settings(bounds)
        if setting != frozen_setting(bounds)
    }


def _nearer(setting: Setting, bounds: Mapping[str, Bounds]) -> Setting:
    steps = {name: _steps(bounds[name], value) for name, value in setting}
    furthest = max(steps, key=lambda name: abs(steps[name]))
    values = bounds[furthest].values
    back = values.index(dict(setting)[furthest]) - (1 if steps[furthest] > 0 else -1)
    return tuple((name, values[back] if name == furthest else value) for name, value in setting)


def _steps(bounds: Bounds, value: float) -> int:
    """Return how many values a value is above the frozen one."""
    return bounds.values.index(value) - bounds.values.index(bounds.frozen)


def settings(bounds: Mapping[str, Bounds]) -> tuple[Setting, ...]:
    """Return all settings of some parameters together.

    Raises:
        ValueError: if there are too many to learn which is best.
    """
    names = sorted(bounds)
    found = tuple(
        tuple(zip(names, values, strict=True))
        for values in product(*(bounds[name].values for name in names))
    )
    if len(found) > _MOST_SETTINGS:
        raise ValueError(
            f"{len(found)} settings of {', '.join(names)}; at most {_MOST_SETTINGS} can be "
            "compared: learn fewer parameters, or fewer values of each"
        )
    return found
