"""The running behavior as the console knows it, and what a page says about it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import Enum, IntEnum
from typing import TypeAlias

from flexbe_synthesizer.core.chart.names import FAILED
from flexbe_synthesizer.core.machine.lower import OTHER
from remodel_console.core.running import FAILURES, UNATTENDED, ChartState, Structure, chart_state
from remodel_run.whole_task import counted

_WITHDRAWN = 255  # the outcome of a request that takes the previous one back


_LOG_SAYS_WHY = "; the log says why"
_BAD = FAILURES | {OTHER}  # of a state that chooses by code, too


class Phase(Enum):
    """What the engine does."""

    AWAY = "away"
    IDLE = "idle"
    RUNNING = "running"


class Status(IntEnum):
    """Codes of flexbe_msgs/BEStatus."""

    STARTED = 0
    FINISHED = 1
    FAILED = 2
    SWITCHING = 6
    ERROR = 11
    READY = 20


@dataclass(frozen=True)
class EngineSeen:
    """The engine is there, or no longer."""

    is_there: bool


@dataclass(frozen=True)
class EngineStatus:
    """A status of the engine."""

    code: int
    behavior_id: int
    args: tuple[str, ...] = ()


@dataclass(frozen=True)
class Entered:
    """A state became active; an empty path: none is."""

    path: str


@dataclass(frozen=True)
class Asked:
    """The engine asks whether it may leave a state with an outcome.

    Attributes:
        before: path of the state that was active until then. Beside a state that waits at a
            breakpoint in a concurrency container, another one may go on.
    """

    path: str
    index: int
    before: str = field(default="", compare=False)


@dataclass(frozen=True)
class Acknowledged:
    """The engine has taken a command."""

    command: str
    args: tuple[str, ...] = ()


@dataclass(frozen=True)
class Left:
    """A state was left with an outcome; the engine publishes this for supervised runs only."""

    path: str
    outcome: str


@dataclass(frozen=True)
class LevelSeen:
    """The autonomy level in force; only engines of this workspace publish it."""

    level: int


@dataclass(frozen=True)
class Troubled:
    """The log has a warning or an error."""

    text: str


@dataclass(frozen=True)
class Ordered:
    """This console has ordered a start or a level; it counts once the engine confirms it."""

    level: int | None
    source_checksum: int | None = None


Event: TypeAlias = (
    EngineSeen
    | EngineStatus
    | Entered
    | Left
    | Asked
    | Acknowledged
    | LevelSeen
    | Structure
    | Troubled
    | Ordered
)


@dataclass(frozen=True)
class RunView:
    """The run that goes on, or how the last one ended.

    Attributes:
        behavior_id: checksum of the source of the behavior that runs.
        active: path of the active state, empty if none is known.
        visited: paths that this run has entered.
        entries: how many states it has entered.
        asks: the requests that wait for the operator, the oldest first.
        level: the autonomy level, as the engine publishes it, or as this console set it; None if
            neither is known.
        attached_name: name that the engine gave when it was attached to.
        held: path that is locked; None if nothing is.
        structure: its containers and states, once the engine has published them.
        is_sure: the engine itself has published the active state. A mirror infers it, and may be
            wrong if it joins while states change, since topics have no order among each other.
        ending: how the last run ended, in words, without the cause.
        is_ending_bad: and it did not end by itself or on command.
        ended_with: the outcome of the last run; empty if it did not end with one.
        left: what was left last; its structure may arrive later.
        left_last: the same, also when the run has ended; of what failed, the innermost.
        trouble: the last warning or error in the log of the run.
        announced: path of a state published before the start of its run; topics have no order.
        announced_level: the same of an autonomy level; None if none was.
        ordered: what this console ordered last about starting and levels.
        is_starting: this console has ordered a start, and the engine prepares it.
        waits_for: what the engine waits for meanwhile, in the words of its log.
    """

    phase: Phase = Phase.AWAY
    behavior_id: int = 0
    active: str = ""
    visited: frozenset[str] = frozenset()
    entries: int = 0
    asks: tuple[Asked, ...] = ()
    level: int | None = None
    attached_name: str = ""
    is_paused: bool = False
    held: str | None = None
    structure: Structure | None = None
    is_sure: bool = False
    ending: str = ""
    is_ending_bad: bool = False
    left: Left | None = None
    left_last: Left | None = None
    trouble: str = ""
    ended_with: str = ""
    announced: str = ""
    announced_level: int | None = None
    ordered: Ordered = Ordered(None)
    is_starting: bool = False
    waits_for: str = ""

    @property
    def is_supervised(self) -> bool:
        """Return whether this console supervises the run."""
        return self.phase is Phase.RUNNING and self.level not in (None, UNATTENDED)

    @property
    def asked(self) -> Asked | None:
        """Return the latest request that waits for the operator; None without one."""
        return self.asks[-1] if self.asks else None

    def outcomes(self, path: str) -> tuple[str, ...]:
        """Return the outcomes of a state in the engine's order; none if they are not known."""
        if not self.has_structure or self.structure is None:
            return ()
        level = self.structure.by_path.get(path)
        return () if level is None else level.outcomes

    @property
    def has_structure(self) -> bool:
        """Return whether the structure is that of the running behavior."""
        return self.structure is not None and self.structure.behavior_id == self.behavior_id

    def chart_state(self, path: str) -> ChartState:
        """Return which state of the chart a path of the engine means."""
        return chart_state(path, self.structure if self.has_structure else None)

    @property
    def ending_words(self) -> str:
        """Return how the last run ended, and the cause if it failed."""
        if self.ended_with not in FAILURES:
            return self.ending
        ending, last = self.ending.removesuffix(_LOG_SAYS_WHY), self.left_last
        if last is not None:
            state = self.chart_state(last.path)
            ending += f": '{state.label}' was left with '{state.event(last.outcome)}'"
        return f"{ending}; the log says: {self.trouble}" if self.trouble else ending + _LOG_SAYS_WHY

    @property
    def has_failed(self) -> bool:
        """Return whether the last run ended badly."""
        return self.is_ending_bad or self.ended_with in FAILURES

    def holdable(self) -> tuple[str, ...]:
        """Return the paths that can be locked: the active state, then what is around it."""
        parts = self.active.split("/")
        return tuple("/".join(parts[:end]) for end in range(len(parts), 1, -1))


def step(view: RunView, event: Event) -> RunView:
    """Return the view after an event."""
    if isinstance(event, EngineSeen):
        return _on_engine(view, event)
    if isinstance(event, EngineStatus):
        return _on_status(view, event)
    if isinstance(event, Entered):
        return _on_entered(view, event)
    if isinstance(event, Left):
        return _on_left(view, event)
    if isinstance(event, Asked):
        return _on_asked(view, event)
    if isinstance(event, Acknowledged):
        return _on_acknowledged(view, event)
    if isinstance(event, LevelSeen):
        if view.phase is Phase.RUNNING:
            return replace(view, level=event.level)
        return replace(view, announced_level=event.level)
    if isinstance(event, Troubled):
        return _on_trouble(view, event)
    if isinstance(event, Structure):
        view = replace(view, structure=event)
        return view if view.left is None else _after_left(view, view.left)
    is_starting = view.phase is Phase.IDLE and event.source_checksum is not None
    return replace(view, ordered=event, is_starting=is_starting, waits_for="")


def _on_engine(view: RunView, event: EngineSeen) -> RunView:
    if not event.is_there:
        ending = "was cut off when the engine ended" if view.phase is Phase.RUNNING else ""
        return RunView(ending=ending or view.ending, is_ending_bad=bool(ending))
    return replace(view, phase=Phase.IDLE) if view.phase is Phase.AWAY else view


def _on_status(view: RunView, event: EngineStatus) -> RunView:
    if event.code == Status.STARTED:
        is_ours = view.ordered.source_checksum == event.behavior_id
        return RunView(
            phase=Phase.RUNNING,
            behavior_id=event.behavior_id,
            level=view.ordered.level if is_ours else view.announced_level,
            ordered=view.ordered if is_ours else Ordered(None),
            held=event.args[0] if event.args else None,  # a switch leaves its state locked
            structure=view.structure,
            active=view.announced,
            visited=frozenset(filter(None, (view.announced,))),
            entries=1 if view.announced else 0,
        )
    if event.code == Status.SWITCHING:
        return view
    words, is_bad = _ending(event)
    if event.code == Status.ERROR and view.phase is Phase.RUNNING:
        words = (
            "continues in its own version, because the engine refused the switch; the log says why"
        )
        return replace(view, ending=words, is_ending_bad=True)
    if event.code == Status.READY:
        return replace(_idle(view), ended_with=view.ended_with)
    ended_with = FAILED if is_bad else "".join(event.args[:1])
    if event.code == Status.ERROR:  # nothing of the run before is its cause
        view = replace(view, left_last=None, trouble="")
    return replace(_idle(view), ending=words, is_ending_bad=is_bad, ended_with=ended_with)


def _idle(view: RunView) -> RunView:
    """Return the view without a run; how the last one went stays."""
    return RunView(
        phase=Phase.IDLE,
        behavior_id=view.behavior_id,
        visited=view.visited,
        entries=view.entries,
        structure=view.structure,
        ending=view.ending,
        is_ending_bad=view.is_ending_bad,
        left_last=view.left_last,
        trouble=view.trouble,
    )


def _on_trouble(view: RunView, event: Troubled) -> RunView:
    """Return the view with what may have caused a failure; topics have no order."""
    if view.is_starting:
        return replace(view, waits_for=event.text)
    is_late = view.phase is Phase.IDLE and view.ended_with in FAILURES and not view.trouble
    return replace(view, trouble=event.text) if view.phase is Phase.RUNNING or is_late else view


def _ending(event: EngineStatus) -> tuple[str, bool]:
    """Return how a run ended in words, and whether badly."""
    if event.code == Status.FINISHED:
        outcome = event.args[0] if event.args else ""
        return ("was stopped" if outcome == "preempted" else f"ended with '{outcome}'"), False
    if event.code == Status.FAILED:
        return "failed; the log says why", True
    return "was not started; the log says why", True


def _on_entered(view: RunView, event: Entered) -> RunView:
    if view.phase is not Phase.RUNNING:
        return replace(view, announced=event.path)
    return view if view.is_sure else _at(view, event.path)


def _on_left(view: RunView, event: Left) -> RunView:
    # Of a container that is left since a state in it failed, the state is the cause.
    last = view.left_last
    is_around = last is not None and last.path.startswith(f"{event.path}/")
    if not (is_around and last is not None and last.outcome in _BAD):
        view = replace(view, left_last=event)
    if view.phase is not Phase.RUNNING:
        return view
    view = _without_ask(view, event.path)  # nothing else answers it: topics have no order
    view = replace(view, visited=view.visited | {event.path}, left=event)
    return _after_left(view, event)


def _after_left(view: RunView, event: Left) -> RunView:
    """Return the view with the state that follows the one left, if it is known."""
    if not view.has_structure or view.structure is None:
        return view
    following = view.structure.following(event.path, event.outcome)
    if following is None:
        return replace(view, is_sure=False)
    return replace(_at(view, following), is_sure=True)


def _on_asked(view: RunView, event: Asked) -> RunView:
    asks = tuple(ask for ask in view.asks if ask.path != event.path)
    if event.index == _WITHDRAWN:
        return _back(_without_ask(view, event.path), view, event.path)
    if view.phase is not Phase.RUNNING:
        return view
    known = next((ask.before for ask in view.asks if ask.path == event.path), view.active)
    asks = (*asks, replace(event, before=known))
    return replace(_at(view, event.path), asks=asks, is_sure=True)


def _without_ask(view: RunView, path: str) -> RunView:
    """Return the view without what the engine asked about a state."""
    asks = tuple(ask for ask in view.asks if ask.path != path)
    return view if asks == view.asks else replace(view, asks=asks)


def _back(view: RunView, before: RunView, path: str) -> RunView:
    """Return the view after a request has ended with the state active that is shown then.

    That is the one that asked before; or, if the request came from beside it, the one of before.
    """
    if view.asks:
        return _at(view, view.asks[-1].path)
    ask = next((ask for ask in before.asks if ask.path == path), None)
    if ask is None or not ask.before or view.active != path:
        return view
    return _at(view, ask.before)


def _at(view: RunView, path: str) -> RunView:
    """Return the view with another state active."""
    if path == view.active:
        return view
    if not path:
        return replace(view, active="")
    visited = view.visited if path in view.visited else view.visited | {path}
    return replace(view, active=path, visited=visited, entries=view.entries + 1)


def _on_acknowledged(view: RunView, event: Acknowledged) -> RunView:
    args = event.args
    if event.command in ("attach", "autonomy"):
        name = args[0] if args else view.attached_name
        return replace(view, attached_name=name, level=view.ordered.level)
    if event.command in ("pause", "resume"):
        return replace(view, is_paused=event.command == "pause")
    has_worked = len(args) == 2 and args[0] == args[1]
    if event.command == "lock" and has_worked:
        return replace(view, held=args[0])
    if event.command == "unlock" and has_worked:
        return replace(view, held=None)
    if event.command == "transition" and has_worked:
        # The next state may have asked before this arrives: topics have no order.
        about = [ask.path for ask in view.asks if args[0] == ask.path]
        about = about or [ask.path for ask in view.asks if args[0] == ask.path.rpartition("/")[2]]
        if len(about) == 1:  # else `Left` names the one
            return _back(_without_ask(view, about[0]), view, about[0])
    return view


def state_words(view: RunView, *, waits: bool) -> str:
    """Return the state of the run; `waits`: for a value, a decision or a confirmation."""
    if view.phase is Phase.AWAY:
        return "no engine"
    if view.is_starting:
        return f"starting: {view.waits_for}" if view.waits_for else "starting"
    if view.phase is Phase.IDLE:
        return "idle"
    if waits or view.asked is not None:
        return "waiting for you"
    if view.is_paused:
        return "paused"
    if view.held is not None:
        return "locked"
    return "running" if view.is_supervised else "running unattended"


def count_words(view: RunView) -> str:
    """Return how many states the run has entered."""
    return f"{counted(view.entries, 'state')} entered"


def path_words(path: str) -> str:
    """Return the path of a state as a person reads it."""
    return " / ".join(filter(None, path.split("/")))
