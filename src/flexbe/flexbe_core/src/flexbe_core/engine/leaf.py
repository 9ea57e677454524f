"""A state in a run: its events, in the order that users rely on.

    on_enter (first tick of a visit), on_resume (first tick after a pause), execute, on_exit

on_exit is called exactly once per on_enter, however the visit ends: by an outcome, a repeat, an
error that ends the run, or the end of a container around it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexbe_core.engine import supervised_leaf
from flexbe_core.engine.definitions import Rate, is_over, period_s
from flexbe_core.engine.errors import StateError
from flexbe_core.engine.events import Ended, Raised
from flexbe_core.engine.node import NEVER, NOW, Node
from flexbe_core.engine.supervision import Act
from flexbe_core.engine.user_data import UserData

if TYPE_CHECKING:
    from flexbe_core.engine.containers import Container
    from flexbe_core.engine.definitions import Definition
    from flexbe_core.engine.engine import Engine


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

    def resume_visit(self, entered: bool) -> None:
        """Continue a visit that began in another version of the behavior, or was about to."""
        self.entered = entered
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
            act, outcome = supervised_leaf.before(self)
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
            act = supervised_leaf.after(self, outcome)
            if act is Act.REPEAT:
                self._repeat()
                return None
            outcome = outcome if act is Act.LEAVE else None
        elif self.requested is not None or self.engine.supervision.breakpoints:
            outcome = supervised_leaf.at_breakpoint(self, outcome)
        if outcome is None:
            self._stay(now)
            return None
        self._leave()
        if supervised:
            supervised_leaf.left(self, outcome)
        if self.engine.recording:
            self.engine.events.append(Ended(self.path, outcome))
        return outcome

    def exit(self) -> None:
        """End the visit; an error in on_exit is reported as an event, and stops nothing."""
        self.skipped = False
        if self.definition._is_controlled:
            supervised_leaf.exited(self)
        elif self.requested is not None:
            supervised_leaf.forget_breakpoint(self)
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
