"""What rehearsed runs of wires say about the next real one, and what is changed for it.

Changes are tried of wires that fail; those that have shown to help are adopted as preferences.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from random import Random
from statistics import fmean

import msgspec

from remodel_run.rehearsal import Forecast, Share, Trial, TriedChange, WireForecast
from remodel_supervision.core.learning.belief import Belief
from remodel_tasks.core.problem.preferences import FORMAT
from remodel_tasks.core.use_case.model import Bounds


def share(successes: int, trials: int) -> Share:
    """Return the probability of which so many of so many trials succeeded.

    Jeffreys' prior (Proc. R. Soc. A 186, 1946), half a success and half a failure, so that no
    number of trials makes a probability certain.
    """
    belief = Belief(successes + 0.5, trials - successes + 0.5)
    return Share(belief.mean, *belief.interval())


# How many orders are drawn from what was rehearsed, for the spread of their time.
_DRAWS = 2000


def forecast(names: Sequence[str], trials: Iterable[Trial]) -> Forecast:
    """Return what trials say of the wires of an order.

    Args:
        names: of the wires, in the order in which they are placed; those without a trial are left
            out.
        trials: of these wires.
    """
    by_wire: dict[str, list[Trial]] = {}
    for trial in trials:
        by_wire.setdefault(trial.wire, []).append(trial)
    known = [name for name in names if name in by_wire]
    wires = tuple(_of_wire(name, by_wire[name]) for name in known)
    return Forecast(
        wires,
        math.prod(wire.at_once.mean for wire in wires),
        _whole_time([[trial.cell_s for trial in by_wire[name]] for name in known]),
    )


def _of_wire(name: str, trials: Sequence[Trial]) -> WireForecast:
    ordered = sorted(trials, key=lambda trial: trial.seed)
    failed = [trial for trial in ordered if trial.failures]
    kinds = Counter((trial.failures[0].ability, trial.failures[0].code) for trial in failed)
    failure, picture = None, ""
    if failed:
        (kind, _), *_ = kinds.most_common(1)
        of_kind = [t for t in failed if (t.failures[0].ability, t.failures[0].code) == kind]
        failure = of_kind[0].failures[0]
        picture = next((trial.picture for trial in of_kind if trial.picture), "")
    return WireForecast(
        name,
        len(ordered),
        share(sum(trial.at_once for trial in ordered), len(ordered)),
        share(sum(trial.placed for trial in ordered), len(ordered)),
        failure,
        fmean(trial.cell_s for trial in ordered),
        picture,
    )


def _whole_time(times: Sequence[Sequence[float]]) -> tuple[float, float, float]:
    """Return mean, 5 % and 95 % of the sum of one time of each wire [s]."""
    if not times:
        return 0.0, 0.0, 0.0
    random = Random(1)
    sums = sorted(sum(random.choice(each) for each in times) for _ in range(_DRAWS))
    return fmean(sums), sums[_DRAWS // 20], sums[-_DRAWS // 20]


def brier_score(forecasts: Mapping[str, float], outcomes: Iterable[tuple[str, bool]]) -> float:
    """Return the mean squared difference between probabilities and what happened.

    Brier, Mon. Weather Rev. 78 (1950), for one of two classes: 0 is certain and right, 0.25 a coin.

    Args:
        forecasts: probability of success by wire.
        outcomes: wires, and whether they succeeded; at least one.
    """
    return fmean((forecasts[wire] - success) ** 2 for wire, success in outcomes)


# What can be changed about a wire that fails, how well each change did, and what is adopted


# By so much longer [m] a wire is tried: an estimate of what a duct still takes up as slack.
LONGER_M = 0.08
# Changes are tried of so many wires, no more certain of their first attempt than this [1].
CHECKED, UNCERTAIN = 3, 0.9
# A wire that is placed less often than this [1], whatever is changed, is better placed by hand.
BY_HAND_BELOW = 0.5
# Entries of an order's preferences whose names begin so come from its rehearsals.
ADOPTED = "rehearsed: "
# What a plan pays [ticks] for each wire that it places before one that is to be first.
_FIRST_WEIGHT = 10


@dataclass(frozen=True)
class Change:
    """A change of how one wire is placed.

    Attributes:
        text: for a person.
        is_first: whether it is placed before all others.
        begin: the end that is inserted first, a or b; empty: as planned.
        force_n: limit of its pushes [N]; 0: as before.
        longer_m: by which it is cut longer [m].
    """

    text: str
    is_first: bool = False
    begin: str = ""
    force_n: float = 0.0
    longer_m: float = 0.0

    def preference(self, wire: str, why: str) -> tuple[str, dict[str, object]] | None:
        """Return what makes it so in an order's preferences: section, entry.

        None if preferences cannot: forces are learned, and lengths are the design's.
        """
        name = f"{ADOPTED}{wire} {self.text}, {why}"
        if self.is_first:
            first = {"name": name, "pick": wire, "before": "all", "weight": _FIRST_WEIGHT}
            return "prefer", first
        if self.begin:
            return "require", {"name": name, "begin": wire, "at": self.begin}
        return None


def changes_within(bounds: Mapping[str, Bounds], first: str = "") -> tuple[Change, ...]:
    """Return the changes that can be tried, the cheapest first.

    Args:
        bounds: parameter -> what may be chosen of it, for pushes.
        first: the end that is inserted first by plan, a or b; empty: the planner chooses.
    """
    found = [Change("placed before the others", is_first=True)]
    if first:
        other = "b" if first == "a" else "a"
        found.append(Change(f"inserted at end {other} first", begin=other))
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


def adopted(
    forecast: Forecast, changes: Mapping[str, Iterable[Change]], document: object
) -> object:
    """Return an order's preferences with what its rehearsals have shown to help.

    A change is entered if the interval of its success lies above what is expected without it; a
    wire is by hand if it hardly succeeds with any. What is entered replaces what an earlier
    rehearsal has entered about the same wire.

    Args:
        forecast: with the changes that were tried.
        changes: by wire.
        document: the order's preferences; None: it has none.
    """
    for wire in forecast.failing:
        known = {each.text: each for each in changes.get(wire.wire, ())}
        found = _entry(wire, known) if known else None
        if found is not None:
            document = with_entry(_without_adopted(document, wire.wire), *found)
    return document


def adopted_names(document: object) -> tuple[str, ...]:
    """Return the names of the entries of an order's preferences that come from rehearsals."""
    sections = document.values() if isinstance(document, Mapping) else ()
    return tuple(
        str(entry["name"])
        for entries in sections
        if isinstance(entries, list)
        for entry in entries
        if isinstance(entry, Mapping) and str(entry.get("name", "")).startswith(ADOPTED)
    )


def with_entry(document: object, section: str, entry: object) -> dict[str, object]:
    """Return a document of preferences with one more entry; None: there is none yet."""
    found: dict[str, object] = {"format": FORMAT}
    if isinstance(document, Mapping):
        found |= document
    listed = found.get(section)
    return {**found, section: [*(listed if isinstance(listed, list) else []), entry]}


def _entry(
    wire: WireForecast, changes: Mapping[str, Change]
) -> tuple[str, dict[str, object]] | None:
    """Return what is entered of a wire: section, entry; None: nothing."""
    expected = wire.at_once.mean
    for tried in wire.changes:
        why = f"{tried.at_once.mean:.0%} at the first attempt in place of {expected:.0%}"
        entry = changes[tried.text].preference(wire.wire, why) if tried.text in changes else None
        if entry is not None and tried.at_once.low > expected:
            return entry
    shares = (wire.placed, *(each.at_once for each in wire.changes))
    if all(each.high < BY_HAND_BELOW for each in shares):
        name = f"{ADOPTED}{wire.wire} by hand, placed in {wire.placed.mean:.0%}"
        return "require", {"name": name, "by_hand": wire.wire}
    return None


def _without_adopted(document: object, wire: str) -> object:
    if not isinstance(document, Mapping):
        return document
    return {
        section: [entry for entry in entries if not _is_adopted(entry, wire)]
        if isinstance(entries, list)
        else entries
        for section, entries in document.items()
    }


def _is_adopted(entry: object, wire: str) -> bool:
    name = entry.get("name", "") if isinstance(entry, Mapping) else ""
    return str(name).startswith(f"{ADOPTED}{wire} ")
