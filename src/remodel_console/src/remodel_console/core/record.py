"""The record of a run: what was so at each moment, two runs compared, the history of a wire.

A step is a state that was entered, a task that began or ended, a failure, a decision or an answer.
Two steps are the same if they say the same about the same task and state, whenever they happened
and whatever was measured.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from difflib import SequenceMatcher
from functools import cache, cached_property
from itertools import accumulate, zip_longest

from remodel_console.core.running import recorded_state
from remodel_console.core.use_case import UseCase, duration_words
from remodel_run.progress import Sums
from remodel_run.record import Entry, Kind, decision_words, entry_words, fault_words
from remodel_run.whole_task import counted

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


_KINDS = (Kind.TASK, Kind.STATE, Kind.FAILURE, Kind.DECISION, Kind.OPERATOR)


@dataclass(frozen=True)
class Step:
    """A step of one run: the index of its entry, when it was in the run [s], and its words."""

    index: int
    offset_s: float
    words: str


@dataclass(frozen=True)
class Row:
    """What stands beside each other; None: this run has no such step."""

    left: Step | None
    right: Step | None
    is_same: bool


@dataclass(frozen=True)
class Comparison:
    """The steps of two runs.

    Attributes:
        rows: in the order in which they happened.
        first: index of the first row that differs; None if the runs took the same steps.
    """

    rows: tuple[Row, ...]
    first: int | None


def compare(left: Record, right: Record) -> Comparison:
    """Return the steps of two runs side by side."""
    rows = tuple(_rows(left, right))
    first = next((place for place, row in enumerate(rows) if not row.is_same), None)
    return Comparison(rows, first)


def _rows(left: Record, right: Record) -> Iterator[Row]:
    sides = [[e for e in record.entries if e.kind in _KINDS] for record in (left, right)]
    ours, theirs = sides
    keys = [[_key(entry) for entry in side] for side in sides]
    start = _same_at_first(*keys)  # most of two long runs; the matcher needs the square of it
    for one, other in zip(ours[:start], theirs[:start], strict=True):
        yield Row(_step(left, one), _step(right, other), is_same=True)
    matcher = SequenceMatcher(None, keys[0][start:], keys[1][start:], autojunk=False)
    for tag, i1, i2, j1, j2 in matcher.get_opcodes():
        steps = [_step(left, entry) for entry in ours[start + i1 : start + i2]]
        others = [_step(right, entry) for entry in theirs[start + j1 : start + j2]]
        for step, beside in zip_longest(steps, others):
            yield Row(step, beside, is_same=tag == "equal")


def _same_at_first(ours: list[object], theirs: list[object]) -> int:
    pairs = enumerate(zip(ours, theirs, strict=False))
    return next((i for i, (a, b) in pairs if a != b), min(len(ours), len(theirs)))


def _key(entry: Entry) -> object:
    """Return what makes a step the same: of a failure not its text, which has measurements."""
    text = (entry.fault, entry.error_code) if entry.kind is Kind.FAILURE else entry.text
    return entry.kind, entry.task, entry.behavior, entry.state_path, text


def _step(record: Record, entry: Entry) -> Step:
    words = entry_words(entry)
    about = f"{entry.task}: {words}" if entry.task else words
    return Step(entry.position - 1, record.offset_s(entry), about)


def wire_words(wire: str, use_case: UseCase | None) -> tuple[str, ...]:
    """Return lines about a wire: its task's state, then its failures, the latest first."""
    task = next((t for t in use_case.tasks if t.name == wire), None) if use_case else None
    if task is None or use_case is None:
        return ("No task of the present order is about this wire.",)
    attempts = f", {counted(task.attempts, 'attempt')}" if task.attempts else ""
    taken = f", {duration_words(task.taken_s)}" if task.taken_s else ""
    lines = [task.description, f"{task.words}{attempts}{taken}"]
    for failure in reversed(use_case.failures):
        if failure.task == wire:
            then = decision_words(failure.decision)
            lines.append(f"{fault_words(failure.fault)}: {failure.text}; the cell {then}.")
    return tuple(filter(None, lines))


def force_words(record: Record, wire: str, last: int | None = None) -> tuple[str, ...]:
    """Return a line for each force that was measured while a wire was under way.

    Args:
        record: of the run.
        wire: name of the wire, as of its task.
        last: index of the last entry that counts; None: all do.
    """
    entries = record.entries if last is None else record.entries[: last + 1]
    forces: dict[str, list[float]] = {}
    for entry in entries:
        if entry.task == wire:
            for name, value in entry.values:
                if name.endswith("_n"):
                    forces.setdefault(name, []).append(value)
    return tuple(
        f"{value_words(name)}: {max(values):.3g} at most, {values[-1]:.3g} last"
        for name, values in forces.items()
    )


def recorded_wire_words(record: Record, wire: str, last: int) -> tuple[str, ...]:
    """Return lines about a wire at a moment of a replayed run, the latest of its history first.

    Args:
        record: of the run.
        wire: name of the wire, as of its task.
        last: index of the entry that happened last.
    """
    own = [e for e in record.entries[: last + 1] if e.task == wire]
    if not own:
        will = any(entry.task == wire for entry in record.entries)
        return ("Its task begins later in this run." if will else "No task is about this wire.",)
    shown = (Kind.TASK, Kind.FAILURE, Kind.DECISION, Kind.OPERATOR)
    history = [e for e in own if e.kind in shown]
    lines = (f"{record.offset_s(e):.1f} s: {entry_words(e)}" for e in reversed(history))
    return (*force_words(record, wire, last), *lines)
