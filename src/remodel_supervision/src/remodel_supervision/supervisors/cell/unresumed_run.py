"""A run that cannot be resumed, since what it is about cannot be made: it waits for a person."""

from __future__ import annotations

from remodel_production.errors import PlannerError
from remodel_supervision.core.runs.events import Blocked, Command, Commanded, Ending, RunEnded
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.supervisors.ports import Log
from remodel_supervision.supervisors.run_control import Reply


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
