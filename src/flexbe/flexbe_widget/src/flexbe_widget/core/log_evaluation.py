"""Sum up the run log of a behavior, which flexbe_core.state_logger writes.

Each visit of a state begins with its event enter and ends with exit. While it asks the operator for
a transition it waits; the rest of the time it runs.

    time        [s] of the visits
    time_wait   [s] of these, waiting for the operator
    time_run    [s] of these, running
    visits      number of visits
    interact    transitions that the operator forced
    count_wait  transitions that states requested from the operator
    correct     forced transitions that had been requested
    wrong       forced transitions that had not been requested
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

Line = Mapping[str, Any]

KEYS = ("total", "state_path", "state_name", "state_class", "transition")


@dataclass
class Sums:
    """What is added up for one key."""

    time: float = 0.0
    time_wait: float = 0.0
    time_run: float = 0.0
    visits: int = 0
    interact: int = 0
    count_wait: int = 0
    correct: int = 0
    wrong: int = 0


VALUES = tuple(field.name for field in fields(Sums))


@dataclass
class _Visit:
    """A visit that has not ended yet; times in [s]."""

    entered_at: float
    waits_since: float | None = None
    outcome: str = ""
    asked: int = 0
    forced: int = 0
    correct: int = 0


_KEY_OF: dict[str, Callable[[Line, str], str]] = {
    "total": lambda line, outcome: "total",
    "state_path": lambda line, outcome: str(line["path"]),
    "state_name": lambda line, outcome: str(line["name"]),
    "state_class": lambda line, outcome: str(line["state"]),
    "transition": lambda line, outcome: f"{line['path']} > {outcome}",
}


def evaluate(lines: Iterable[Line], key: str) -> dict[str, Sums]:
    """Return the sums for each value of a key, in the order in which they first come.

    A visit that the record does not see the end of is left out.
    """
    sums: dict[str, Sums] = {}
    visits: dict[str, _Visit] = {}
    ended: dict[str, tuple[Line, _Visit, float]] = {}
    for line in lines:
        path, at = line.get("path"), float(line.get("time", 0.0))
        if path is None:
            continue
        if line.get("event") == "enter":
            _add(sums, key, ended.pop(path, None))
            visits[path] = _Visit(at)
        elif line.get("event") == "exit" and path in visits:
            ended[path] = (line, visits.pop(path), at)
        elif line.get("logger") == "flexbe.operator" and path in visits:
            _note_operator(visits[path], line, at)
        elif line.get("logger") == "flexbe.outcomes" and path in ended:
            ended[path][1].outcome = str(line.get("outcome"))
            _add(sums, key, ended.pop(path))
    for rest in ended.values():
        _add(sums, key, rest)
    return sums


def table(rows: Mapping[str, Sums], key: str, values: Sequence[str]) -> str:
    """Return the rows as text, a line each, below a line of headings."""
    lines = [[key, *values]]
    for name, sums in rows.items():
        found = [getattr(sums, value) for value in values]
        lines.append([name, *(f"{v:.3f}" if isinstance(v, float) else str(v) for v in found)])
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "".join(
        "  ".join([line[0].ljust(widths[0]), *map(str.rjust, line[1:], widths[1:])]).rstrip() + "\n"
        for line in lines
    )


def _note_operator(visit: _Visit, line: Line, at: float) -> None:
    if line.get("type") == "request":
        visit.asked += 1
        visit.waits_since = at if visit.waits_since is None else visit.waits_since
    elif line.get("type") == "forced":
        visit.forced += 1
        visit.correct += line.get("forced") == line.get("requested")


def _add(sums: dict[str, Sums], key: str, ended: tuple[Line, _Visit, float] | None) -> None:
    if ended is None:
        return
    line, visit, at = ended
    total = sums.setdefault(_KEY_OF[key](line, visit.outcome), Sums())
    time_wait = 0.0 if visit.waits_since is None else at - visit.waits_since
    total.time += at - visit.entered_at
    total.time_wait += time_wait
    total.time_run += at - visit.entered_at - time_wait
    total.visits += 1
    total.interact += visit.forced
    total.count_wait += visit.asked
    total.correct += visit.correct
    total.wrong += visit.forced - visit.correct
