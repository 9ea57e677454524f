"""A run of an order as the supervisor publishes it: tasks, levels, failures, the question."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from remodel_run.progress import Answer, Count, HandWire, Phase, Sums, TaskPhase
from remodel_run.record import fault_words
from remodel_run.whole_task import whole_tasks

_PHASES = {
    TaskPhase.WAITING: "waiting",
    TaskPhase.RUNNING: "running",
    TaskPhase.DONE: "done",
    TaskPhase.SET_ASIDE: "skipped",
}
_COUNT_WORDS = {Count.DONE_BEFORE: "done before", Count.INTERRUPTED: "interrupted"}


@dataclass(frozen=True)
class Task:
    """A task of the order. Times in [s].

    Attributes:
        first_pass: done by this run, and no operation of it failed.
        counts_as: what it counts for in the sums of the run.
        cable: of which it places a core, beside others; empty: none.
    """

    name: str
    description: str
    phase: TaskPhase
    attempts: int
    first_pass: bool
    taken_s: float
    expected_s: float
    cable: str = ""
    counts_as: Count = Count.OPEN

    @property
    def is_tried(self) -> bool:
        """Return whether this run began it, and has done or skipped it."""
        return self.counts_as in (Count.DONE, Count.SKIPPED) and self.attempts > 0

    @property
    def words(self) -> str:
        """Return what an operator reads of how far it is."""
        return _COUNT_WORDS.get(self.counts_as) or _PHASES[self.phase]


def hand_words(wires: Sequence[HandWire], ticked: Collection[str]) -> str:
    """Return how many of the wires by hand are still to be placed."""
    left = sum(wire.name not in ticked for wire in wires)
    done = f"all {len(wires)} are placed" if not left else f"{left} of {len(wires)} to be placed"
    return f"By hand: {done}"


@dataclass(frozen=True)
class CableTask:
    """A cable, which is one task, with the tasks of its cores as steps."""

    cores: tuple[Task, ...]

    @property
    def name(self) -> str:
        """Return the cable's name."""
        return self.cores[0].cable

    @property
    def phase(self) -> TaskPhase:
        """Return how far it is: done with its last core, skipped if one of its cores is."""
        phases = [core.phase for core in self.cores]
        if TaskPhase.RUNNING in phases:
            return TaskPhase.RUNNING
        if TaskPhase.WAITING in phases:
            return TaskPhase.RUNNING if TaskPhase.DONE in phases else TaskPhase.WAITING
        return TaskPhase.SET_ASIDE if TaskPhase.SET_ASIDE in phases else TaskPhase.DONE

    @property
    def taken_s(self) -> float:
        """Return the time that its cores have taken [s]."""
        return sum(core.taken_s for core in self.cores)

    @property
    def expected_s(self) -> float:
        """Return the time that its cores are still expected to take [s]."""
        return sum(core.expected_s for core in self.cores)

    @property
    def words(self) -> str:
        """Return what an operator reads of how far it is."""
        words = {core.words for core in self.cores}
        return words.pop() if len(words) == 1 else _PHASES[self.phase]

    @property
    def description(self) -> str:
        """Return what an operator reads beside its name."""
        done = sum(core.phase is TaskPhase.DONE for core in self.cores)
        return f"cable, {done} of {len(self.cores)} cores done"


def with_cables(tasks: Sequence[Task]) -> Iterator[CableTask | Task]:
    """Yield tasks in their order, each cable before its cores, at the place of the first."""
    named = {task.name: task for task in tasks}
    for whole in whole_tasks((task.name, task.cable) for task in tasks):
        cores = tuple(named[name] for name in whole.wires)
        if whole.is_cable:
            yield CableTask(cores)
        yield from cores


@dataclass(frozen=True)
class Level:
    """What one of the four levels of supervision does, since a ROS time [s]; 0: not known."""

    level: str
    name: str
    doing: str
    since_s: float


@dataclass(frozen=True)
class Failure:
    """A task's failure, and what was decided about it, at a ROS time [s]."""

    time_s: float
    task: str
    fault: str
    error_code: int
    ability: str
    text: str
    decision: str
    because: str


@dataclass(frozen=True)
class Question:
    """What the run waits for a person to answer.

    Attributes:
        asked_s: when it was asked, ROS time [s].
        timeout_s: after which it escalates, and the run goes on without an answer [s]; 0: never.
    """

    number: int
    task: str
    text: str
    choices: tuple[Answer, ...]
    asked_s: float = 0.0
    timeout_s: float = 0.0

    def left_s(self, now_s: float) -> float | None:
        """Return the time that is left to answer at a ROS time [s]; None without a limit."""
        return max(0.0, self.asked_s + self.timeout_s - now_s) if self.timeout_s else None


@dataclass(frozen=True)
class UseCase:
    """A run, or that there is none, as it was published at a ROS time [s].

    Attributes:
        run: its number in the production database, 0 without one.
        serial: serial number of the product.
        started_s: when it began, or was resumed after an interruption; ROS time [s].
        stopped_by: who requested the protective stop; empty without one.
        controllers: safety controllers that hold the protective stop; without any, it is released
            here.
        sums: of the tasks, a cable being one.
        by_hand: wires of the order that a person places.
        tasks: all of them, or none as long as they could not be fetched.
    """

    phase: Phase
    stamp_s: float = 0.0
    message: str = ""
    cell: str = ""
    run: int = 0
    order: str = ""
    use_case: str = ""
    serial: str = ""
    started_s: float = 0.0
    interruptions: int = 0
    stopped_by: str = ""
    controllers: tuple[str, ...] = ()
    sums: Sums = field(default_factory=Sums)
    by_hand: tuple[HandWire, ...] = ()
    tasks: tuple[Task, ...] = ()
    task: str = ""
    levels: tuple[Level, ...] = ()
    failures: tuple[Failure, ...] = ()
    question: Question | None = None

    @property
    def is_under_way(self) -> bool:
        """Return whether a run is in progress, or held."""
        return self.phase not in (Phase.IDLE, Phase.STARTING, Phase.ENDED)

    @property
    def is_held(self) -> bool:
        """Return whether the run goes on only when it is resumed."""
        return self.phase in (Phase.PAUSING, Phase.PAUSED, Phase.PROTECTIVE_STOP)

    @property
    def is_releasable(self) -> bool:
        """Return whether a protective stop is in force that a person releases."""
        return self.phase is Phase.PROTECTIVE_STOP and not self.controllers

    @property
    def left_s(self) -> float:
        """Return the time that all tasks are still expected to take [s]."""
        return sum(task.expected_s for task in self.tasks)

    @property
    def worked_s(self) -> float:
        """Return the time that the cell has worked on the run, over its interruptions [s]."""
        since_s = [level.since_s for level in self.levels if level.level == "task"]
        now_s = self.stamp_s - since_s[0] if since_s and since_s[0] else 0.0
        return self.sums.taken_s + max(0.0, now_s)


def stop_words(now: UseCase) -> tuple[str, str]:
    """Return who holds the cell by a protective stop, and how it is released."""
    persons = [name for name in now.stopped_by.split(", ") if name not in ("", *now.controllers)]
    by = ", ".join((*now.controllers, *persons)) or "an unknown device"
    if now.controllers:
        who = "safety controller" if len(now.controllers) == 1 else "safety controllers"
        how = f"It is held by the {who} {', '.join(now.controllers)}, and released there, not here."
    elif now.run:
        how = "Release ends the stop, and the run stays paused until Resume."
    else:
        how = "Release ends the stop, and orders can be started."
    return f"Protective stop, requested by {by}", f"No motion begins. {how}"


# Tasks that a page shows at once, of which a quarter each may have ended before, or be skipped.
SHOWN_TASKS = 200


def shown_tasks(tasks: tuple[Task, ...]) -> tuple[Task, ...]:
    """Return the tasks that a page shows: all, or of a large order those around the current one.

    Skipped tasks, which a person may retry, are shown before them, the latest ones if there are
    many. The tasks shown change seldom, so that rows stay where they are.

    Args:
        tasks: those that have ended, then the others.
    """
    if len(tasks) <= SHOWN_TASKS:
        return tasks
    quarter = SHOWN_TASKS // 4
    ended = sum(task.phase in (TaskPhase.DONE, TaskPhase.SET_ASIDE) for task in tasks)
    first = max(0, (ended - quarter // 2) // quarter * quarter)
    skipped = [task for task in tasks[:first] if task.phase is TaskPhase.SET_ASIDE]
    return (*skipped[-quarter:], *tasks[first : first + 3 * quarter])


_LEVEL_WORDS = {
    "use_case": "Order",
    "task": "Task",
    "behavior": "Behavior",
    "action": "Ability",
}


def level_rows(use_case: UseCase) -> Iterator[tuple[str, Level | None]]:
    """Yield the four levels, what an operator calls them and what they do; None: idle."""
    known = {level.level: level for level in use_case.levels}
    for level, word in _LEVEL_WORDS.items():
        yield word, known.get(level)


def duration_words(time_s: float) -> str:
    """Return a duration as an operator reads it: seconds, then minutes, then hours."""
    seconds = max(0, round(time_s))
    if seconds < 100:
        return f"{seconds} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60:02} min"


_ENDED = (TaskPhase.DONE, TaskPhase.SET_ASIDE)
_KEPT_EARLY = 1000  # changes; far more than arrive while all tasks are fetched


@dataclass(frozen=True)
class Snapshot:
    """All tasks of a run, in the order of the plan, after so many changes of a series."""

    series: int
    number: int
    tasks: tuple[Task, ...]
    failures: tuple[Failure, ...]
    by_hand: tuple[HandWire, ...] = ()


@dataclass(frozen=True)
class Changes:
    """The tasks that changed and the failures that are new; `replanned`: the order has changed."""

    series: int
    number: int
    tasks: tuple[Task, ...]
    failures: tuple[Failure, ...]
    replanned: bool


@dataclass(frozen=True)
class TaskCopy:
    """What is known of a run's tasks.

    Attributes:
        series: of changes that it follows; 0: none.
        number: of the last changes that it contains.
        tasks: by name, in the order of the plan.
        early: changes that came before those that precede them, or before a snapshot.
        is_reordered: the order of the tasks is not known any more.
    """

    series: int = 0
    number: int = 0
    tasks: Mapping[str, Task] = field(default_factory=dict)
    failures: tuple[Failure, ...] = ()
    by_hand: tuple[HandWire, ...] = ()
    early: tuple[Changes, ...] = ()
    is_reordered: bool = False

    @cached_property
    def in_order(self) -> tuple[Task, ...]:
        """Return the tasks: those that have ended, then the others, each in the plan's order."""
        tasks = self.tasks.values()
        ended = [task for task in tasks if task.phase in _ENDED]
        return (*ended, *(task for task in tasks if task.phase not in _ENDED))

    def needs_snapshot(self, series: int) -> bool:
        """Return whether a snapshot is needed to know the run whose changes have this series."""
        is_gap = any(changes.series == series for changes in self.early)
        return bool(series) and (series != self.series or self.is_reordered or is_gap)

    def with_changes(self, changes: Changes) -> TaskCopy:
        """Return the copy with changes, or with those kept until what precedes them is known."""
        if changes.series == self.series and changes.number <= self.number:
            return self
        if (changes.series, changes.number) != (self.series, self.number + 1):
            return replace(self, early=(*self.early, changes)[-_KEPT_EARLY:])
        return self._applied(changes)._with_early()

    def with_snapshot(self, snapshot: Snapshot) -> TaskCopy:
        """Return the copy as a snapshot has it, unless it is newer already."""
        if snapshot.series == self.series and snapshot.number < self.number:
            return self
        tasks = {task.name: task for task in snapshot.tasks}
        return TaskCopy(
            snapshot.series,
            snapshot.number,
            tasks,
            snapshot.failures,
            by_hand=snapshot.by_hand,
            early=self.early,
        )._with_early()

    def _applied(self, changes: Changes) -> TaskCopy:
        return replace(
            self,
            number=changes.number,
            tasks={**self.tasks, **{task.name: task for task in changes.tasks}},
            failures=(*self.failures, *changes.failures),
            is_reordered=self.is_reordered or changes.replanned,
        )

    def _with_early(self) -> TaskCopy:
        """Return the copy with the early changes that follow it now, and without those it has."""
        copy = replace(self, early=())
        for changes in sorted(self.early, key=lambda each: each.number):
            if changes.series == self.series:
                copy = copy.with_changes(changes)
        return copy


@dataclass(frozen=True)
class Figures:
    """What the charts show: of the tasks that this run has done or skipped, in the run's order.

    Attributes:
        sums: of the run.
        tasks: names of the tasks that this run tried.
        yields: share of first passes among the tasks up to each one, 0 to 1.
        done: names of those that it has done.
        cycles_s: time that each of these took [s].
        recoveries: (cause, failures that were recovered from) by number, the largest first.
    """

    sums: Sums = field(default_factory=Sums)
    tasks: tuple[str, ...] = ()
    yields: tuple[float, ...] = ()
    done: tuple[str, ...] = ()
    cycles_s: tuple[float, ...] = ()
    recoveries: tuple[tuple[str, int], ...] = ()


def figures(use_case: UseCase) -> Figures:
    """Return the figures of a run.

    A failure counts as recovered from once its task is done, with a person's help or without.
    """
    tried = [task for task in use_case.tasks if task.is_tried]
    passes = 0
    yields = []
    for number, task in enumerate(tried, start=1):
        passes += task.first_pass
        yields.append(passes / number)
    done = {task.name: task.taken_s for task in tried if task.counts_as is Count.DONE}
    recovered = Counter(
        fault_words(failure.fault) for failure in use_case.failures if failure.task in done
    )
    return Figures(
        use_case.sums,
        tasks=tuple(task.name for task in tried),
        yields=tuple(yields),
        done=tuple(done),
        cycles_s=tuple(done.values()),
        recoveries=tuple(sorted(recovered.items(), key=lambda item: (-item[1], item[0]))),
    )
