"""What can be changed about a wire that fails, and how well each change did when it was tried."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import msgspec

from remodel_rehearsal.core.forecast import share
from remodel_run.rehearsal import Forecast, Trial, TriedChange
from remodel_tasks.core.use_case.bounds import Bounds

# By so much longer [m] a wire is tried: an estimate of what a duct still takes up as slack.
LONGER_M = 0.08
# Changes are tried of so many wires, no more certain of their first attempt than this [1].
CHECKED, UNCERTAIN = 3, 0.9


@dataclass(frozen=True)
class Change:
    """A change of how one wire is placed, the cheapest first.

    Attributes:
        text: for a person.
        is_first: whether it is placed before all others.
        force_n: limit of its pushes [N]; 0: as before.
        longer_m: by which it is cut longer [m].
    """

    text: str
    is_first: bool = False
    force_n: float = 0.0
    longer_m: float = 0.0


def changes_within(bounds: Mapping[str, Bounds]) -> tuple[Change, ...]:
    """Return the changes that can be tried, the cheapest first.

    Args:
        bounds: parameter -> what may be chosen of it, for pushes.
    """
    found = [Change("placed before the others", is_first=True)]
    force = bounds.get("force_limit")
    if force is not None:
        values = {force.low, force.high} - {force.frozen}
        found += [Change(f"pushed with {value:g} N", force_n=value) for value in sorted(values)]
    found.append(Change(f"{100 * LONGER_M:g} cm longer", longer_m=LONGER_M))
    return tuple(found)


def to_check(forecast: Forecast) -> tuple[str, ...]:
    """Return the names of the wires of which changes are tried."""
    return tuple(wire.wire for wire in forecast.failing[:CHECKED] if wire.at_once.mean <= UNCERTAIN)


def with_changes(forecast: Forecast, tried: Mapping[tuple[str, str], Iterable[Trial]]) -> Forecast:
    """Return a forecast with the changes that were tried, of each wire the best first.

    Args:
        forecast: without them.
        tried: wire and text of the change -> its trials.
    """
    by_wire: dict[str, list[TriedChange]] = {}
    for (wire, text), trials in tried.items():
        known = list(trials)
        at_once = share(sum(trial.at_once for trial in known), len(known))
        by_wire.setdefault(wire, []).append(TriedChange(text, at_once))
    wires = tuple(
        msgspec.structs.replace(
            wire,
            changes=tuple(sorted(by_wire.get(wire.wire, ()), key=lambda each: -each.at_once.mean)),
        )
        for wire in forecast.wires
    )
    return msgspec.structs.replace(forecast, wires=wires)
