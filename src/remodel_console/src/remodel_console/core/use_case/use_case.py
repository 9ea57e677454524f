"""A run of an order as the supervisor publishes it: tasks, levels, failures, the question."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum


class Phase(Enum):
    """What the supervisor does; the values are those of remodel_msgs/UseCaseState."""

    IDLE = "idle"
    STARTING = "starting"
    PLANNING = "planning"
    RUNNING = "running"
    SETTLING = "settling"
    PAUSING = "pausing"
    PAUSED = "paused"
    PROTECTIVE_STOP = "protective_stop"
    ASKING = "asking"
    ENDED = "ended"

    @property
    def words(self) -> str:
        """Return what an operator reads."""
        return _PHASE_WORDS[self]


_PHASE_WORDS = {
    Phase.IDLE: "idle",
    Phase.STARTING: "starting",
    Phase.PLANNING: "planning",
    Phase.RUNNING: "running",
    Phase.SETTLING: "inspecting the interrupted task",
    Phase.PAUSING: "pausing…",
    Phase.PAUSED: "paused",
    Phase.PROTECTIVE_STOP: "protective stop",
    Phase.ASKING: "waiting for you",
    Phase.ENDED: "ended",
}


class TaskPhase(Enum):
    """How far a task is; the values are those of remodel_msgs/TaskState."""

    WAITING = "waiting"
    RUNNING = "running"
    DONE = "done"
    SET_ASIDE = "set_aside"


class Choice(Enum):
    """An answer to a question; the values are those of remodel_msgs/OperatorQuestion."""

    RETRY = "retry"
    FIXED = "fixed"
    MARK_DONE = "mark_done"
    SKIP = "skip"
    REPLAN = "replan"
    STOP = "stop"

    @property
    def words(self) -> str:
        """Return the label of its button."""
        return _CHOICE_WORDS[self][0]

    @property
    def meaning(self) -> str:
        """Return what it does."""
        return _CHOICE_WORDS[self][1]


_CHOICE_WORDS = {
    Choice.RETRY: ("Try again", "The cell repeats what is left of the task."),
    Choice.FIXED: ("I have fixed it", "The cell checks, then continues with what is left."),
    Choice.MARK_DONE: ("The task is done", "You confirm it: the cell does not check."),
    Choice.SKIP: ("Skip the task", "The task stays undone; the run continues with the others."),
    Choice.REPLAN: ("Do it later", "The cell replans the rest of the order."),
    Choice.STOP: ("Stop the run", "The run ends safely."),
}


@dataclass(frozen=True)
class Task:
    """A task of the order. Times in [s].

    Attributes:
        first_pass: done, and no operation of it failed.
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
        """Return what an operator reads beside its name."""
        done = sum(core.phase is TaskPhase.DONE for core in self.cores)
        return f"cable, {done} of {len(self.cores)} cores done"


def with_cables(tasks: Sequence[Task]) -> Iterator[CableTask | Task]:
    """Yield tasks in their order, each cable before its cores, at the place of the first."""
    groups: dict[tuple[str, str], list[Task]] = {}
    for task in tasks:
        groups.setdefault((task.cable, "" if task.cable else task.name), []).append(task)
    for (cable, _), cores in groups.items():
        if cable and len(cores) > 1:
            yield CableTask(tuple(cores))
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
    choices: tuple[Choice, ...]
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
        total: number of tasks, a cable being one, of which `done` and `set_aside` have ended.
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
    total: int = 0
    done: int = 0
    set_aside: int = 0
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
    def left_s(self) -> float:
        """Return the time that all tasks are still expected to take [s]."""
        return sum(task.expected_s for task in self.tasks)


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


_DECISION_WORDS = {
    "retry": "tries again",
    "retry_with": "tries again with changed parameters",
    "look_again": "looks again from another view",
    "other_method": "uses another method",
    "new_part": "starts again with a new part",
    "replan": "replans the rest; the task comes later",
    "set_aside": "skips the task and continues",
    "ask_operator": "asks you",
    "stop": "stops safely",
}


def decision_words(decision: str) -> str:
    """Return what a decision means; one that is not known stays as it is."""
    return _DECISION_WORDS.get(decision, decision.replace("_", " "))


def fault_words(fault: str) -> str:
    """Return a fault's name as a person writes it."""
    return fault.replace("_", " ").capitalize() or "Unknown fault"


def duration_words(time_s: float) -> str:
    """Return a duration as an operator reads it: seconds, then minutes, then hours."""
    seconds = max(0, round(time_s))
    if seconds < 100:
        return f"{seconds} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60:02} min"
