"""Does what operators and safety controllers ask of the run under way."""

from __future__ import annotations

from collections.abc import Callable

from remodel_supervision.core.runs.events import Answered, Command, Commanded
from remodel_supervision.supervisors.commands import (
    PendingReplies,
    Reply,
    require_open,
    require_sense,
)
from remodel_supervision.supervisors.gate_keeper import GateKeeper
from remodel_supervision.supervisors.ports import Abilities, EventLoop
from remodel_supervision.supervisors.run_record import RunRecord


class RunControl:
    """Keeps commands and answers, and replies to them."""

    def __init__(
        self,
        record: RunRecord,
        loop: EventLoop,
        gates: GateKeeper,
        abilities: Abilities,
        doing: Callable[[], str],
    ) -> None:
        """Take the run's record, and what commands stop.

        Args:
            record: of the run.
            loop: time.
            gates: that commands close.
            abilities: whose goals are cancelled.
            doing: returns what is being done now, for a person.
        """
        self._record = record
        self._loop = loop
        self._gate = gates.gate
        self._tasks = gates.tasks
        self._abilities = abilities
        self._doing = doing
        self._replies = PendingReplies(loop.wall_s)
        self._behaviors_ended = 0

    def command(self, event: Commanded, task_under_way: str, reply: Reply) -> None:
        """Do what an operator or a safety controller asks for.

        The reply comes when nothing moves any more: after a pause when the operation under way has
        ended, after a stop of any kind when what ran is cancelled and at rest. If something does
        not rest in time, the reply names it, and nothing else begins before it rests.

        Args:
            event: the command.
            task_under_way: name of the task of the step under way; empty between tasks.
            reply: to the command.
        """
        # At first, and after a loss, it is not known which task is under way.
        is_under_way = bool(event.task) and (
            event.task == task_under_way or self._tasks.is_settling
        )
        if not self._keep(event, reply, lambda: require_sense(event, self._record.state)):
            return
        if self._gate.halt and not self._tasks.behavior:
            self._abilities.cancel()
        if self._gate.halt and self._tasks.behavior and event.command is not Command.PAUSE:
            ended = self._behaviors_ended + 1
            self._reply_when(lambda: self._behaviors_ended >= ended, reply)
        elif event.command is Command.PAUSE or self._gate.halt or is_under_way:
            self._reply_when(lambda: self._tasks.is_still, reply)
        else:
            reply(True, "")

    def answer(self, event: Answered, reply: Reply) -> None:
        """Take an operator's answer."""
        if self._keep(event, reply, lambda: require_open(event, self._record.state)):
            reply(True, "")

    def note_behavior_end(self) -> None:
        """Note that a behavior has ended, and nothing of it moves."""
        self._behaviors_ended += 1
        self.check()

    def check(self) -> None:
        """Reply to the commands that have been carried out, or whose time has passed."""
        self._replies.check()

    def end(self) -> None:
        """Reply to all that is left as the run has ended, or this process ends."""
        self._replies.end("the run has ended")

    def _keep(self, event: Commanded | Answered, reply: Reply, require: Callable[[], None]) -> bool:
        """Keep what was asked for if it is possible now; otherwise reply why not."""
        try:
            require()
            self._record.append_now(event)
        except Exception as error:  # noqa: BLE001 - the client gets the reason, whatever it is
            reply(False, str(error))
            return False
        return True

    def _reply_when(self, holds: Callable[[], bool], reply: Reply) -> None:
        asked_s = self._loop.wall_s()

        def restless() -> str:
            names = self._tasks.restless(asked_s)
            return names or (self._doing() if self._gate.halt and not self._tasks.is_still else "")

        self._replies.reply_when(holds, reply, restless)
