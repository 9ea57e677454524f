"""A scenario: something that every FlexBE engine does, and how it is found out."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from enum import Enum
from types import ModuleType
from typing import Any

Play = Callable[[Any], None]


class ViolationError(Exception):
    """The engine did something else than what is required; the text states what."""


class NotJudgedError(Exception):
    """The scenario cannot be judged here; the text states why."""


class UnknownScenarioError(Exception):
    """There is no scenario of this name."""


class Verdict(Enum):
    """How a scenario ended."""

    PASS = "pass"
    FAIL = "FAIL"
    NOT_JUDGED = "not judged"


@dataclass(frozen=True)
class Scenario:
    """One requirement on an engine.

    Attributes:
        name: for `--only`.
        required: what an engine does, in one sentence.
        section: where the contract of FlexBE's interfaces states it.
        play: plays it on a bench; raises ViolationError or NotJudgedError.
    """

    name: str
    required: str
    section: str
    play: Play


@dataclass(frozen=True)
class Finding:
    """How a scenario ended.

    Attributes:
        scenario: the scenario.
        verdict: how it ended.
        reason: why, if it did not pass.
        wall_s: how long it took [s, wall time].
    """

    scenario: Scenario
    verdict: Verdict
    reason: str = ""
    wall_s: float = 0.0


def scenario(required: str, section: str) -> Callable[[Play], Scenario]:
    """Make a scenario of a function; its name is the function's, with dashes."""

    def made_of(play: Play) -> Scenario:
        return Scenario(play.__name__.replace("_", "-"), required, section, play)

    return made_of


def scenarios_of(module: ModuleType) -> list[Scenario]:
    """Return the scenarios that a module defines, in their order."""
    return [value for value in vars(module).values() if isinstance(value, Scenario)]


def chosen(scenarios: Iterable[Scenario], names: Iterable[str]) -> list[Scenario]:
    """Return the scenarios of these names in their order; all if no names are given.

    Raises:
        UnknownScenarioError: if there is no scenario of a name.
    """
    known = {item.name: item for item in scenarios}
    wanted = set(names)
    for name in sorted(wanted - set(known)):
        near = get_close_matches(name, known, n=3)
        hint = f"; near it: {', '.join(near)}" if near else ""
        raise UnknownScenarioError(f"there is no scenario {name!r}{hint}; --list shows all")
    return [item for item in known.values() if not wanted or item.name in wanted]
