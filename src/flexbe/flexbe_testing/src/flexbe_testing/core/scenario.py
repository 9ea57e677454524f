"""A scenario: something that every FlexBE engine does, and how it is found out."""

from __future__ import annotations

import json
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
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


# Follow a behavior from outside, by its structure and the outcomes that were published


@dataclass(frozen=True)
class Part:
    """A state or container of a published structure.

    Attributes:
        path: its path; empty for the root.
        children: the labels of its states, the initial one first.
        outcomes: its outcomes.
        transitions: label or outcome of the container around it, for each outcome.
    """

    path: str
    children: tuple[str, ...]
    outcomes: tuple[str, ...]
    transitions: tuple[str, ...]


def initial(parts: Mapping[str, Part], path: str = "") -> str:
    """Return the path of the state with which a container begins; the path itself if a state."""
    part = parts[path]
    return initial(parts, f"{path}/{part.children[0]}") if part.children else path


def successor(parts: Mapping[str, Part], path: str, index: int) -> str | None:
    """Return the state that follows a state's outcome; None if the behavior ends.

    Raises:
        ValueError: if the structure does not contain what follows.
    """
    part, container = parts[path], path.rpartition("/")[0]
    target = part.transitions[index]
    if target in parts[container].children:
        return initial(parts, f"{container}/{target}")
    if target not in parts[container].outcomes:
        raise ValueError(f"outcome {index} of {path} leads to {target!r}, which is not there")
    if not container:
        return None
    return successor(parts, container, parts[container].outcomes.index(target))


# Compare messages with what was expected of them


Fields = Mapping[str, Any]


def agrees(message: object, expected: Fields) -> bool:
    """Return whether a message has the expected fields; the others may be anything."""
    return all(_value(getattr(message, name)) == value for name, value in expected.items())


def shown(message: object, fields: Fields | None = None) -> str:
    """Return a message, or some of its fields, on one line."""
    names = list(fields) if fields else list(getattr(message, "__slots__", ()))
    values = ", ".join(f"{name}: {_value(getattr(message, name))!r}" for name in names)
    return f"{{{values}}}"


def _value(value: object) -> object:
    """Return a field with tuples as lists, which is how ROS delivers arrays of some types."""
    return list(value) if isinstance(value, tuple) else value


# The numbers by which FlexBE's nodes name behaviors, sources and paths


def checksum(text: str) -> int:
    """Return the checksum of a source, of a path, or of a manifest's `package_path`."""
    return zlib.adler32(text.encode()) & 0x7FFFFFFF


# Print scenarios and findings


def listing(scenarios: Sequence[Scenario]) -> str:
    """Return the scenarios with what is required, one per line."""
    width = max(len(scenario.name) for scenario in scenarios)
    return "\n".join(
        f"{scenario.name:{width}}  {scenario.section:5}  {scenario.required}"
        for scenario in scenarios
    )


def progress(finding: Finding) -> str:
    """Return one line about a finding that was just made."""
    reason = f": {finding.reason}" if finding.reason else ""
    return f"{finding.verdict.value:10} {finding.scenario.name}{reason}"


def table(findings: Sequence[Finding]) -> str:
    """Return a table of all findings, and their count."""
    heads = ("scenario", "section", "verdict", "required")
    rows = [(f.scenario.name, f.scenario.section, f.verdict.value, _last(f)) for f in findings]
    widths = [max(len(row[column]) for row in (heads, *rows)) for column in range(3)]
    lines = [_row(heads, widths), _row(tuple("-" * width for width in (*widths, 8)), widths)]
    lines += [_row(row, widths) for row in rows]
    return "\n".join([*lines, "", count(findings)])


def count(findings: Iterable[Finding]) -> str:
    """Return how many scenarios ended how."""
    found = Counter(finding.verdict for finding in findings)
    return ", ".join(f"{found[verdict]} {verdict.value}" for verdict in Verdict)


def as_json(findings: Sequence[Finding]) -> str:
    """Return the findings as JSON."""
    rows = [
        {
            "scenario": finding.scenario.name,
            "section": finding.scenario.section,
            "required": finding.scenario.required,
            "verdict": finding.verdict.value,
            "reason": finding.reason,
            "wall_s": round(finding.wall_s, 3),
        }
        for finding in findings
    ]
    return json.dumps(rows, indent=2)


def _last(finding: Finding) -> str:
    reason = f" | {finding.reason}" if finding.reason else ""
    return f"{finding.scenario.required}{reason}"


def _row(cells: Sequence[str], widths: Sequence[int]) -> str:
    padded = [f"{cell:{width}}" for cell, width in zip(cells, widths, strict=False)]
    return "  ".join([*padded, cells[-1]]).rstrip()
