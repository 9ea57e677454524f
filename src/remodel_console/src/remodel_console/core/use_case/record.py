"""The record of a run, and what was so at each moment of it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import accumulate

from remodel_console.core.run.chart_terms import recorded_state
from remodel_run.progress import Sums
from remodel_run.record import Entry, Kind

REASONS = (Kind.FAILURE, Kind.DECISION, Kind.OPERATOR)  # what shows why a run took its course


@dataclass(frozen=True)
class Summary:
    """A run as a list of runs shows it; `started_s` is wall time [s]."""

    run: int
    order: str
    use_case: str
    cell: str
    started_s: float
    has_ended: bool
    is_success: bool
    message: str
    sums: Sums


@dataclass(frozen=True)
class Moment:
    """What was so at one moment of a run.

    Attributes:
        entry: what happened last.
        task: under way; empty between tasks.
        behavior: that ran last in the task; empty if none did.
        state_path: its state that was active, or has failed; empty if none was.
        state: the same in terms of the chart, as a person reads it.
        passed: states that the task's behavior had entered by then, the active one too.
        feedback: the last feedback of an ability in this state; None without one.
        picture: position of the last picture; 0 if there was none.
        reasons: failures, decisions and answers up to then, the latest first.
    """

    entry: Entry
    task: str
    behavior: str
    state_path: str
    state: str
    passed: tuple[str, ...]
    feedback: Entry | None
    picture: int
    reasons: tuple[Entry, ...]


# Units at the end of a value's name: how a person writes them, and how many make one of the name's.
# What comes first here is shown first.
_UNITS = {
    "n": ("N", 1.0),
    "nm": ("N m", 1.0),
    "m": ("mm", 1000.0),
    "rad": ("rad", 1.0),
    "s": ("s", 1.0),
    "percentage": ("%", 1.0),
}


def value_words(name: str) -> str:
    """Return the name of a value as a person reads it: `force_n` is force [N]."""
    words, _, unit = name.rpartition("_")
    if not words or unit not in _UNITS:
        return name.replace("_", " ")
    return f"{words.replace('_', ' ')} [{_UNITS[unit][0]}]"


@dataclass(frozen=True)
class Record:
    """All entries of a run, in the order of their positions, which is that of time.

    An entry without a time, or with one that lies back, happened with the entry before it; the
    first ones without happened with the first that has one.
    """

    entries: tuple[Entry, ...]

    @cached_property
    def begin_s(self) -> float:
        """Return the ROS time at which the record begins [s]."""
        return next((entry.time_s for entry in self.entries if entry.time_s), 0.0)

    @cached_property
    def offsets_s(self) -> tuple[float, ...]:
        """Return when in the run each entry was [s]."""
        times = accumulate((max(self.begin_s, entry.time_s) for entry in self.entries), max)
        return tuple(time_s - self.begin_s for time_s in times)

    @property
    def length_s(self) -> float:
        """Return the time from the first entry to the last [s]."""
        return self.offsets_s[-1] if self.entries else 0.0

    def offset_s(self, entry: Entry) -> float:
        """Return when in the run an entry was [s]."""
        return self.offsets_s[entry.position - 1]

    def at(self, offset_s: float) -> int:
        """Return the index of the last entry up to a time in the run [s]; of the first before."""
        return max(0, bisect_right(self.offsets_s, offset_s) - 1)

    def moment(self, index: int) -> Moment:
        """Return what was so after the entry of an index."""
        task, behavior, path, state, picture = "", "", "", "", 0
        passed: list[str] = []
        feedback: Entry | None = None
        for entry in self.entries[: index + 1]:
            if entry.task and entry.task != task:
                task, passed, feedback = entry.task, [], None
                behavior, path, state = "", "", ""
            if entry.kind is Kind.TASK and not entry.task:
                task = ""
            if entry.kind is Kind.STATE:
                path, state, feedback = entry.state_path, entry.state, None
                behavior = entry.behavior or behavior
                if path and path not in passed:
                    passed.append(path)
            elif entry.kind in (Kind.FEEDBACK, Kind.RESULT):
                feedback = entry
            elif entry.kind is Kind.FAILURE:
                path, state = (entry.state_path, entry.state) if entry.state_path else (path, state)
            picture = entry.position if entry.has_picture else picture
        reasons = tuple(e for e in reversed(self.entries[: index + 1]) if e.kind in REASONS)
        now = self.entries[index]
        return Moment(
            now,
            task,
            behavior=behavior,
            state_path=path,
            state=state,
            passed=tuple(passed),
            feedback=feedback,
            picture=picture,
            reasons=reasons,
        )

    def visit_s(self, index: int) -> tuple[float, float]:
        """Return the ROS times at which the state of a moment became active and was left [s].

        After a failure, that is the state that has failed. One that was not left in this record was
        left at its end.
        """
        path = self.moment(index).state_path
        states = [place for place, e in enumerate(self.entries) if e.kind is Kind.STATE]
        visits = [p for p in states if p <= index and self.entries[p].state_path == path]
        entered = visits[-1] if visits else 0
        left = next((place for place in states if place > entered), len(self.entries) - 1)
        return self.begin_s + self.offsets_s[entered], self.begin_s + self.offsets_s[left]

    def next_reason(self, index: int, step: int) -> int:
        """Return the index of the next failure, decision or answer, or of the one before.

        Args:
            index: from where on.
            step: 1 for the next, -1 for the one before; without one the index stays.
        """
        last = len(self.entries) if step > 0 else -1
        found = (i for i in range(index + step, last, step) if self.entries[i].kind in REASONS)
        return next(found, index)

    def series(self, name: str) -> Iterator[tuple[float, float]]:
        """Yield (time in the run [s], value) of all entries that have a value of a name.

        The unit is that of `value_words`.
        """
        _, scale = _UNITS.get(name.rpartition("_")[2], ("", 1.0))
        for entry in self.entries:
            for own, value in entry.values:
                if own == name:
                    yield self.offset_s(entry), value * scale

    def value_names(self) -> tuple[str, ...]:
        """Return the names of the values in it: forces first, then by their first entries."""
        names = dict.fromkeys(name for entry in self.entries for name, _ in entry.values)
        return tuple(sorted(names, key=_rank))


def _rank(name: str) -> int:
    """Return where a value stands by its unit."""
    unit = name.rpartition("_")[2]
    return list(_UNITS).index(unit) if unit in _UNITS else len(_UNITS)


def in_chart_terms(record: Record, paths_of: Callable[[str], frozenset[str]]) -> Record:
    """Return a record whose entries name states of the charts; `paths_of` a behavior's chart."""
    paths_of = cache(paths_of)
    named, behavior = [], ""
    for entry in record.entries:
        behavior = entry.behavior or behavior
        if entry.state_path:
            state = recorded_state(entry.state_path, paths_of(behavior)).words
            named.append(replace(entry, state=state))
        else:
            named.append(entry)
    return Record(tuple(named))
