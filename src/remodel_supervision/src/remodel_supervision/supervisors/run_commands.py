"""Commands to a cell with or without a run; a protective stop holds it until it is released."""

from __future__ import annotations

from collections.abc import Callable, Collection

from remodel_production.errors import PlannerError
from remodel_supervision.core.runs.events import Blocked, Command, Commanded, Ending, RunEnded
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.supervisors.ports import Abilities, EventLoop, Log
from remodel_supervision.supervisors.run_control import PendingReplies, Reply
from remodel_supervision.supervisors.use_case_supervisor import UseCaseSupervisor


class UnresumedRun:
    """Keeps a run as it is until a person has it resumed or ended.

    Attributes:
        text: why it is not resumed, and what to do.
        is_over: whether a person has had it resumed, or ended.
    """

    def __init__(self, run: int, owner: int, state: RunState, log: Log, because: str) -> None:
        """Begin to wait.

        Args:
            run: its number.
            owner: token of the cell's ownership; the run is taken up.
            state: what is known of the run.
            log: keeps its events.
            because: why what it is about cannot be made.
        """
        self.text = (
            f"run {run} of order {state.order} cannot be resumed: {because}; correct that and call "
            "remodel/use_case/resume, or end the run by remodel/use_case/stop"
        )
        self.is_over = False
        self._run = run
        self._owner = owner
        self._state = state
        self._log = log
        self._because = because

    def command(self, event: Commanded, reply: Reply) -> None:
        """Resume or end the run; every other command is refused."""
        match event.command:
            case Command.RESUME:
                self.is_over = True
                reply(True, "the run is resumed if that is possible now")
            case Command.STOP:
                self._end(event, reply)
            case _:
                reply(False, self.text)

    def _end(self, event: Commanded, reply: Reply) -> None:
        stopped = f"{event.by} stopped it"
        try:
            # What was kept without an answer is known again.
            self._state = self._log.state(self._run)
            for each in (Blocked(self._because), event, RunEnded(Ending.STOPPED, stopped)):
                if self._state.ended is None:
                    self._state = self._log.append(self._run, each, self._state, self._owner)
        except PlannerError as error:
            reply(False, str(error))
            return
        self.is_over = True
        reply(True, f"run {self._run} has ended")


# [s] wall time between two checks whether what was cancelled rests.
_CHECK_S = 0.2

HELD = "the cell is held until remodel/use_case/release or resume releases it"


class RunCommands:
    """Passes commands on to the run under way, and holds the cell between runs.

    Attributes:
        active: supervisor of the run under way; None without a run.
        unresumed: a run that waits for a person to be resumed; None if there is none.
        closed: why no goal is taken now; empty if one is, or a run is under way.

    Safety controllers stop the cell by the topic, persons by the service. Each stop holds this run
    and all later ones: controllers release their own stops, `release` and `resume` release those of
    persons.
    """

    def __init__(
        self,
        loop: EventLoop,
        abilities: Abilities,
        persons: Collection[str] = (),
        keep: Callable[[Collection[str]], None] = lambda persons: None,
    ) -> None:
        """Begin with the stops that were in force before.

        Args:
            loop: on which all calls come.
            abilities: that a protective stop cancels, run or no run.
            persons: who have stopped the cell by the service, and have not released it.
            keep: keeps these names beyond this process.
        """
        self.active: UseCaseSupervisor | None = None
        self.unresumed: UnresumedRun | None = None
        self.closed = ""
        self._loop = loop
        self._abilities = abilities
        self._controllers: set[str] = set()
        self._persons = set(persons)
        self._stops = 0  # of persons so far
        self._keep = keep
        self._replies = PendingReplies(loop.wall_s)
        loop.every(_CHECK_S, self._replies.check)

    @property
    def stopped_by(self) -> str:
        """Who has stopped the cell; empty if it is not stopped."""
        return ", ".join(sorted(self._controllers | self._persons))

    @property
    def controllers(self) -> tuple[str, ...]:
        """The safety controllers that hold the cell, which release it themselves."""
        return tuple(sorted(self._controllers))

    @property
    def safety(self) -> str:
        """Why nothing may move, by protective stops; empty if it may."""
        if self._controllers:
            return f"protective stop by {', '.join(sorted(self._controllers))}; release it first"
        if self._persons:
            return f"protective stop by {', '.join(sorted(self._persons))}; {HELD}"
        return ""

    def command(self, event: Commanded, reply: Reply) -> None:
        """Do what an operator or a safety controller asks for; see UseCaseSupervisor.command."""
        match event.command:
            case Command.PROTECTIVE_STOP:
                self._stop(event, reply)
            case Command.RELEASE:
                self._release(event, reply)
            case Command.RESUME:
                self._resume(event, reply)
            case _:
                self._pass_on(event, reply)

    def note_controller(self, by: str, *, is_stopped: bool, present: Collection[str]) -> None:
        """Note what a safety controller publishes.

        Args:
            by: its name.
            is_stopped: whether it stops the cell, or releases it.
            present: controllers that are connected; another one cannot release its own stop.
        """
        if not is_stopped:
            self._controllers &= set(present) - {by}
        elif by not in self._controllers:
            self._controllers.add(by)
            self.stop_if_unsafe()

    def stop_if_unsafe(self) -> None:
        """Stop the run under way if a protective stop is in force, from before the run or now."""
        supervisor = self.active
        by = self.stopped_by
        if supervisor is not None and by and supervisor.state.protective != by:
            stop = Commanded(Command.PROTECTIVE_STOP, "", by)
            supervisor.command(stop, lambda granted, text: None)

    def _stop(self, event: Commanded, reply: Reply) -> None:
        self._stops += 1
        self._set_persons(self._persons | {event.by})
        supervisor = self.active
        if supervisor is not None and supervisor.state.ended is None:
            supervisor.command(event, _adding(HELD, reply))
            return
        self._cancel_all(_adding(f"no run is under way; {HELD}", reply))

    def _release(self, event: Commanded, reply: Reply) -> None:
        """Release the stops of persons; a run that they held stays paused."""
        supervisor = self.active
        is_held = bool(self._persons or (supervisor and supervisor.state.protective))
        if self._controllers:
            reply(False, self.safety)
        elif not is_held:
            reply(False, "no protective stop is in force")
        elif supervisor is not None:
            supervisor.command(event, self._releasing(reply))
        else:
            self._set_persons(())
            reply(True, "the protective stop is released")

    def _resume(self, event: Commanded, reply: Reply) -> None:
        if self._controllers:
            reply(False, self.safety)
        elif self.active is None and self.unresumed is None and self._persons:
            self._set_persons(())
            reply(True, "the protective stop is released; no run is under way")
        else:
            self._pass_on(event, self._releasing(reply))

    def _pass_on(self, event: Commanded, reply: Reply) -> None:
        supervisor = self.active
        if supervisor is not None:
            supervisor.command(event, reply)
        elif self.unresumed is not None:
            is_stop = event.command is Command.STOP
            self.unresumed.command(event, self._at_rest(reply) if is_stop else reply)
        else:
            reply(False, self.closed or "no run is under way")

    def _at_rest(self, reply: Reply) -> Reply:
        """Return a reply whose success comes when nothing moves any more."""

        def rest(granted: bool, text: str) -> None:
            if granted:
                self._cancel_all(_adding(text, reply))
            else:
                reply(granted, text)

        return rest

    def _cancel_all(self, reply: Reply) -> None:
        """Cancel what abilities do, and reply when they rest."""
        since_s = self._loop.wall_s()
        self._abilities.cancel()
        self._replies.reply_when(
            lambda: self._abilities.are_quiet(since_s),
            reply,
            lambda: ", ".join(self._abilities.restless(since_s)),
        )

    def _releasing(self, reply: Reply) -> Reply:
        """Return a reply that releases the stops of persons if it is granted.

        A stop that comes before the reply holds the cell: it came after what the reply answers.
        """
        stops = self._stops

        def release(granted: bool, text: str) -> None:
            if granted and self._stops == stops:
                self._set_persons(())
            reply(granted, text)

        return release

    def _set_persons(self, persons: Collection[str]) -> None:
        if set(persons) != self._persons:
            self._persons = set(persons)
            self._keep(sorted(persons))


def _adding(text: str, reply: Reply) -> Reply:
    """Return a reply whose success says more."""
    return lambda granted, said: reply(granted, said or (text if granted else ""))
