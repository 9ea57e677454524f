"""The record of one run: an event is kept before anything that follows from it begins."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

from remodel_production.errors import LostError
from remodel_supervision.core.learning.experience import TriedResponse
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import Event
from remodel_supervision.core.runs.gate import late_stop_event
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.core.runs.step import Step, next_step
from remodel_supervision.errors import HaltedError
from remodel_supervision.supervisors.ports import EventLoop, Log

T = TypeVar("T")

# [s] wall time between two attempts to reach a database that does not answer.
RETRY_S = 0.25


class RunRecord:
    """Keeps the events of a run.

    Attributes:
        run: its number.
        owner: token by which its supervisor owns the cell.
        state: what is known of the run; replaced at each event, never changed.
    """

    def __init__(
        self,
        run: int,
        owner: int,
        state: RunState,
        log: Log,
        loop: EventLoop,
    ) -> None:
        """Continue the record of a run.

        Args:
            run: its number.
            owner: token by which its supervisor owns the cell.
            state: what is known of it.
            log: keeps its events.
            loop: on which the database is waited for.
        """
        self.run = run
        self.owner = owner
        self.state = state
        self._log = log
        self._loop = loop
        self._on_state: Callable[[], None] = lambda: None
        self._on_wait: Callable[[str], None] = lambda text: None
        # An event of which it is not known whether it was kept, and those that turned out to be.
        self._unsure: Event | None = None
        self._kept: list[Event] = []

    def watch(self, on_state: Callable[[], None], on_wait: Callable[[str], None]) -> None:
        """Have changes reported.

        Args:
            on_state: called when the state was replaced.
            on_wait: called with what is waited for, for a person.
        """
        self._on_state, self._on_wait = on_state, on_wait

    def append(self, event: Event) -> None:
        """Keep an event, however long the database takes to answer."""
        self.insist(lambda: self.append_now(event))
        self._kept.clear()

    def append_now(self, event: Event) -> None:
        """Keep an event; LostError if the database does not answer."""
        self.catch_up()
        if any(event is kept for kept in self._kept):
            return
        try:
            self._know(self._log.append(self.run, event, self.state, self.owner))
        except LostError:
            self._unsure = event
            raise

    def append_if_next(self, step: Step, event: Event, *, while_paused: bool = False) -> None:
        """Keep what a step leads to, unless a command has overtaken it, however long that takes.

        Args:
            step: that leads to the event.
            event: to keep.
            while_paused: keep it although the run was paused meanwhile.

        Raises:
            HaltedError: if something else is to be done by now.
        """

        def attempt() -> None:
            self.catch_up()
            if any(event is kept for kept in self._kept):
                return
            state = replace(self.state, paused=False) if while_paused else self.state
            if next_step(state) != step:
                raise HaltedError("something else is to be done by now")
            self.append_now(event)

        self.insist(attempt)
        self._kept.clear()

    def report_stop(self, operation: Operation) -> None:
        """Keep how an operation of an earlier behavior ended, which a person is to answer first."""
        self.catch_up()
        if event := late_stop_event(self.state, operation):
            self.append_now(event)

    def tried_responses(self) -> Sequence[TriedResponse]:
        """Return what was done about faults in any run, however long the database takes."""
        return self.insist(self._log.tried_responses)

    def insist(self, ask: Callable[[], T]) -> T:
        """Return what the database answers, however long it takes to answer."""
        while True:
            try:
                return ask()
            except LostError as error:
                self._on_wait(f"waiting, since {error}")
                self._loop.run_until(lambda: False, RETRY_S)

    def take_up(self) -> None:
        """Have the run belong to its owner again, however long the database takes to answer."""
        self.insist(lambda: self._log.take_up(self.run, self.owner))

    def catch_up(self) -> None:
        """Learn whether an event was kept whose commit was not answered: the log has it or not."""
        if self._unsure is None:
            return
        known = self._log.state(self.run)
        unsure, self._unsure = self._unsure, None
        if known.events != self.state.events:
            self._kept.append(unsure)
            self._know(known)

    def _know(self, state: RunState) -> None:
        self.state = state
        self._on_state()
