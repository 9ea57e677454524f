"""A runtime node, and a state in a run: its events in their order, commands applied to it.

Nodes form a tree like the definitions, made when they are first reached. Each kind has the same
operations; a container passes them on to its active children:

    begin(data) begin a visit
    tick(now)   execute once; return the outcome with which it ends, or None
    exit()      end the visit now
    skip()      pause it: it is not executed for a while
    hold(now)   try again later, after an error
    wake()      be due now, with everything active below
    next_due()  when it is due, as ROS time
    leaf()      the active state below it that a mirror shows

A state's events are on_enter (first tick of a visit), on_resume (first tick after a pause), execute
and on_exit. on_exit is called exactly once per on_enter, however the visit ends: by an outcome, a
repeat, an error that ends the run, or the end of a container around it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from flexbe_core.engine.definitions import Rate, is_over, period_s
from flexbe_core.engine.supervision import (
    NO_OUTCOME,
    PENDING,
    Act,
    ActiveState,
    Answered,
    Ended,
    Forced,
    ForceOutcome,
    Moment,
    Pending,
    Raised,
    Refused,
    Requested,
    StateCommand,
    apply_command,
    decide,
)
from flexbe_core.engine.user_data import StateError, UserData

if TYPE_CHECKING:
    from flexbe_core.engine.containers import Container
    from flexbe_core.engine.definitions import Definition
    from flexbe_core.engine.engine import Engine


# [s] Due times: at once, and only when woken.
NOW = float("-inf")
NEVER = float("inf")


class Node(ABC):
    """What all nodes have in common.

    Attributes:
        definition: the state or container that it runs.
        targets: outcome -> label or outcome of the parent; empty for the root, which may return
            any outcome.
        shown: whether a mirror shows it: in a concurrency container only the first child.
        due: [s] when it is due.
    """

    __slots__ = (
        "__weakref__",
        "definition",
        "due",
        "engine",
        "label",
        "parent",
        "path",
        "shown",
        "targets",
    )

    def __init__(
        self, engine: Engine, definition: Definition, parent: Container | None, label: str
    ) -> None:
        """Stand for `definition`, which `parent` calls `label`; the root has no parent."""
        self.engine = engine
        self.definition = definition
        self.parent = parent
        self.label = label
        self.due = NOW
        if parent is None:
            self.path = engine.root_path
            self.shown = True
            self.targets: Mapping[str, str] = {}
        else:
            self.path = f"{parent.path}/{label}"
            self.shown = parent.shown
            self.targets = parent.definition._transitions[label]

    @property
    @abstractmethod
    def active(self) -> bool:
        """Return whether a visit has begun and not ended."""

    @abstractmethod
    def begin(self, userdata: UserData | None = None) -> None:
        """Begin a visit with this userdata."""

    @abstractmethod
    def tick(self, now: float) -> str | None:
        """Execute once."""

    @abstractmethod
    def exit(self) -> None:
        """End the visit."""

    @abstractmethod
    def skip(self) -> None:
        """Pause the active states: they are not executed for a while."""

    @abstractmethod
    def hold(self, now: float) -> None:
        """Try again later."""

    @abstractmethod
    def wake(self) -> None:
        """Make everything that is active due now."""

    @abstractmethod
    def next_due(self) -> float:
        """Return when it is due."""

    @abstractmethod
    def leaf(self) -> Leaf | None:
        """Return the active state that a mirror shows."""

    def ancestors(self) -> tuple[str, ...]:
        """Return the paths of the containers around it, from the inside out."""
        return (self.parent.path, *self.parent.ancestors()) if self.parent else ()


def before(leaf: Leaf) -> tuple[Act, str | None]:
    """Decide what to do before execution.

    Returns:
        the act and, if the state is not to be executed but to leave, the outcome to leave with.
    """
    engine = leaf.engine
    _apply_commands(leaf)
    supervision = engine.supervision
    act = decide(supervision, _moment(leaf, PENDING, supervision.stored))
    if act is Act.RELEASE:
        engine.supervision = replace(supervision, stored=None)
        return act, supervision.stored
    if act is Act.FORCE:
        if engine.recording:
            engine.events.append(Forced(leaf.path, supervision.forced or "", supervision.requested))
        return act, supervision.forced
    if act is Act.WITHDRAW:
        _withdraw(leaf)
    return act, None


def after(leaf: Leaf, outcome: str | None) -> Act:
    """Decide whether the state may leave with `outcome`, and ask the operator if necessary."""
    engine = leaf.engine
    supervision = engine.supervision
    act = decide(supervision, _moment(leaf, outcome, outcome))
    if act is Act.STORE:
        engine.supervision = replace(supervision, stored=outcome, forced=None)
    elif act is Act.REPEAT:
        engine.supervision = replace(supervision, repeat=False)
    elif act is Act.WITHDRAW:
        _withdraw(leaf)
    elif act is Act.REQUEST and outcome is not None:
        engine.supervision = replace(supervision, requested=outcome)
        engine.events.append(Requested(leaf.path, leaf.definition._outcomes.index(outcome)))
    return act


def left(leaf: Leaf, outcome: str) -> None:
    """Note for mirrors that the state was left, and clear what applied only to this visit."""
    engine = leaf.engine
    if outcome in leaf.definition._outcomes:
        engine.leave(leaf, outcome)
    engine.supervision = engine.supervision.after_visit()


def exited(leaf: Leaf) -> None:
    """Clear what applied only to the visit that something else has ended."""
    engine = leaf.engine
    if engine.supervision.requested is not None:
        _withdraw(leaf)
    engine.supervision = engine.supervision.after_visit()


def at_breakpoint(leaf: Leaf, outcome: str | None) -> str | None:
    """Return the outcome with which a state leaves that is not supervised; None: it stays.

    Operators supervise only the first child of a concurrency container. A state of another child
    asks them at a breakpoint nevertheless, and is answered by its own name or path.
    """
    engine, ordered = leaf.engine, leaf.ordered
    is_stopped = (
        ordered is None
        and outcome in leaf.definition._outcomes
        and leaf.path in engine.supervision.breakpoints
    )
    if not is_stopped or outcome is None:
        forget_breakpoint(leaf)
        return outcome
    if outcome != leaf.requested:
        leaf.requested = outcome
        engine.stopped[leaf.path] = leaf
        engine.events.append(Requested(leaf.path, leaf.definition._outcomes.index(outcome)))
    return None


def forget_breakpoint(leaf: Leaf) -> None:
    """Withdraw what the operator was asked at a breakpoint, unless that was answered."""
    if leaf.requested is not None and leaf.ordered is None:
        leaf.engine.events.append(Requested(leaf.path, NO_OUTCOME))
    leaf.requested = leaf.ordered = None
    leaf.engine.stopped.pop(leaf.path, None)


def answer_at_breakpoint(engine: Engine, command: ForceOutcome) -> bool:
    """Take a forced outcome for a state that waits at a breakpoint; return whether it is for one.

    A name that the active supervised state has, too, means that state, as in stock FlexBE.
    """
    active = engine.root.leaf()
    named = [one for one in engine.stopped.values() if command.target in (one.path, one.label)]
    is_for_active = (
        active is not None and active.definition._is_controlled and command.target == active.label
    )
    if not named or is_for_active:
        return False
    outcomes = named[0].definition._outcomes
    if len(named) > 1:
        paths = ", ".join(repr(one.path) for one in named)
        text = f"several states named {command.target!r} wait at breakpoints; name one of {paths}"
        engine.events += [Answered("transition", (command.target, "")), Refused(text)]
    elif not 0 <= command.index < len(outcomes):
        declared = ", ".join(f"{index}: {name}" for index, name in enumerate(outcomes))
        text = f"asked for outcome {command.index} of {command.target!r}; it has {declared}"
        answer = Answered("transition", (command.target, command.target))
        engine.events += [answer, Refused(text)]
    else:
        named[0].ordered = outcomes[command.index]
        named[0].due = NOW
        engine.events.append(Answered("transition", (command.target, command.target)))
    return True


def _apply_commands(leaf: Leaf) -> None:
    """Apply the commands to the active state, up to a forced outcome.

    Commands after a forced outcome are for the next state.
    """
    engine = leaf.engine
    if not engine.commands:
        return
    name = leaf.definition._name or ""
    state = ActiveState(name, leaf.path, leaf.definition._outcomes, leaf.ancestors())
    while engine.commands and engine.supervision.forced is None:
        command: StateCommand = engine.commands.popleft()
        engine.supervision, events = apply_command(engine.supervision, command, state)
        engine.events.extend(events)
    engine.claim_while_paused(leaf.path)


def _moment(leaf: Leaf, outcome: str | Pending | None, leaving_with: str | None) -> Moment:
    return Moment(
        path=leaf.path,
        supervised=True,
        outcome=outcome,
        required_autonomy=-1 if leaving_with is None else _required_autonomy(leaf, leaving_with),
        leaves_locked=leaving_with is not None and _leaves_locked(leaf, leaving_with),
    )


def _required_autonomy(leaf: Leaf, outcome: str) -> int:
    if leaf.parent is None:
        return -1
    levels: Mapping[str, int] = leaf.parent.definition._autonomy.get(leaf.label, {})
    return levels.get(outcome, -1)


def _leaves_locked(leaf: Leaf, outcome: str) -> bool:
    """Return whether a locked container around the state would be left with this outcome."""
    locks = leaf.engine.supervision.locks
    target: str | None = leaf.targets.get(outcome)
    container = leaf.parent
    while locks and container is not None and target is not None:
        if target in container.definition._labels:
            return False
        if container.path in locks:
            return True
        target = container.targets.get(target)
        container = container.parent
    return False


def _withdraw(leaf: Leaf) -> None:
    engine = leaf.engine
    engine.supervision = replace(engine.supervision, requested=None)
    engine.events.append(Requested(leaf.path, NO_OUTCOME))


# What a state without a parent sees until its userdata is set.
_NOTHING = UserData(None, (), ())


class Leaf(Node):
    """The runtime node of a state.

    Attributes:
        view: userdata as the state sees it, reset at the beginning of each tick; without a parent,
            what the caller of the tick passes.
        entered: whether on_enter has been called and on_exit has not.
        skipped: whether on_pause has been called and on_resume has not.
        alarm: [s] ROS time at which the state requests its next execution, instead of at its
            rate; set again in each execution.
        requested: outcome that the operator was asked for at a breakpoint; of states that are not
            supervised, as others have it in Supervision.
        ordered: outcome that the operator answered with; None without an answer.
    """

    __slots__ = ("_execute", "alarm", "entered", "ordered", "requested", "skipped", "view")

    def __init__(
        self, engine: Engine, definition: Definition, parent: Container | None, label: str
    ) -> None:
        """Stand for the state `definition`."""
        super().__init__(engine, definition, parent, label)
        self.view = parent.view_for(label) if parent else _NOTHING
        self.entered = False
        self.skipped = False
        self.alarm = NEVER
        self.requested: str | None = None
        self.ordered: str | None = None
        self._execute = type(definition).execute

    @property
    def active(self) -> bool:
        """Return whether the state has been entered."""
        return self.entered

    def begin(self, userdata: UserData | None = None) -> None:
        """Use this userdata from now on; for a state without a parent."""
        self.view = _NOTHING if userdata is None else userdata

    def resume_visit(self, entered: bool, skipped: bool) -> None:
        """Continue a visit that began in another version of the behavior, or was about to."""
        self.entered, self.skipped = entered, skipped
        if self.parent is not None:
            self.view._reference = self.parent.userdata
        if entered and self.shown:
            self.engine.entries.append(self.path)

    def tick(self, now: float) -> str | None:
        """Execute the state once.

        Raises:
            StateError: if it returns an outcome without a transition.
            Exception: what the state raises.
        """
        self.engine.executing = self
        state = self.definition
        supervised = state._is_controlled
        outcome: str | None = None
        if supervised:
            act, outcome = before(self)
            if act is not Act.EXECUTE and outcome is None:
                if act is Act.SKIP:
                    self.skip()
                self._stay(now)
                return None
        elif self.ordered is not None:
            outcome = self.ordered
        if not self.entered:
            self._enter()
        view = self.view
        if self.skipped:
            self.skipped = False
            state.on_resume(view)
        if outcome is None:
            outcome = self._execute(state, view)
        if outcome is not None and outcome not in self.targets and self.targets:
            raise StateError(self._undeclared(outcome))
        if supervised:
            act = after(self, outcome)
            if act is Act.REPEAT:
                self._repeat()
                return None
            outcome = outcome if act is Act.LEAVE else None
        elif self.requested is not None or self.engine.supervision.breakpoints:
            outcome = at_breakpoint(self, outcome)
        if outcome is None:
            self._stay(now)
            return None
        self._leave()
        if supervised:
            left(self, outcome)
        if self.engine.recording:
            self.engine.events.append(Ended(self.path, outcome))
        return outcome

    def exit(self) -> None:
        """End the visit; an error in on_exit is reported as an event, and stops nothing."""
        self.skipped = False
        if self.definition._is_controlled:
            exited(self)
        elif self.requested is not None:
            forget_breakpoint(self)
        if self.entered:
            try:
                self._leave()
            except Exception as error:  # noqa: BLE001 - the visit ends even if on_exit raises
                self.engine.events.append(Raised(self.path, error, held=False))

    def skip(self) -> None:
        """Call on_pause, once."""
        if not self.skipped:
            self.skipped = True
            self.definition.on_pause()

    def hold(self, now: float) -> None:
        """Try again after one period."""
        if self.parent is not None:
            self.view._forget()
        self.due = now + period_s(self.definition._rate)

    def wake(self) -> None:
        """Be due now."""
        self.due = NOW

    def next_due(self) -> float:
        """Return when the state wants to be executed."""
        rate = self.definition._rate
        return NOW if type(rate) is not Rate and is_over(rate) else self.due

    def leaf(self) -> Leaf | None:
        """Return itself."""
        return self

    def _enter(self) -> None:
        if self.parent is not None and self.view._reference is not self.parent.userdata:
            self.view._reference = self.parent.userdata
        self.entered = True
        if self.shown:
            self.engine.entries.append(self.path)
        if self.engine.observe is not None:
            self.engine.observe(self, False)
        self.definition.on_enter(self.view)

    def _leave(self) -> None:
        self.entered = False
        view = self.view
        self.definition.on_exit(view)
        if self.parent is not None and view._data:
            view._close()
        if self.engine.observe is not None:
            self.engine.observe(self, True)

    def _repeat(self) -> None:
        self._leave()
        self.engine.moved = True
        self.due = NOW

    def _stay(self, now: float) -> None:
        """Set when the state is due: at its alarm, or else at its rate.

        The beat of the rate is kept; after a wake-up or a delay, a new beat begins.
        """
        if self.parent is not None and self.view._data:
            self.view._close()
        alarm, self.alarm = self.alarm, NEVER
        if now < alarm < NEVER:
            self.due = alarm
            return
        if self.due <= now:
            period = period_s(self.definition._rate)
            due = self.due + period
            self.due = due if due > now else now + period

    def _undeclared(self, outcome: object) -> str:
        declared = ", ".join(repr(name) for name in self.targets)
        return f"returned {outcome!r}; outcomes with a transition: {declared}"
