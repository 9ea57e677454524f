"""The services by which states, operators and safety controllers reach the run under way."""

from __future__ import annotations

import contextlib

import rospy
from remodel_msgs.msg import AbilityRecord
from remodel_msgs.srv import (
    AnswerQuestion,
    AnswerQuestionResponse,
    BeginOperation,
    BeginOperationRequest,
    BeginOperationResponse,
    CommandRun,
    CommandRunResponse,
    CommandTask,
    CommandTaskResponse,
    KeepRecord,
    KeepRecordRequest,
    KeepRecordResponse,
)
from std_msgs.msg import Bool

from remodel_run.progress import Answer
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import Answered, Command, Commanded
from remodel_supervision.core.runs.gate import Permit
from remodel_supervision.ros.event_loop import RosEventLoop
from remodel_supervision.supervisors.ports import Abilities
from remodel_supervision.supervisors.run_commands import RunCommands
from remodel_supervision.supervisors.run_control import Reply

RECORDER = "remodel/keep_record"
RECORDER_PARAMETER = "remodel/recorder"
BEGIN = "remodel/begin_operation"
PROTECTIVE_STOP = "remodel/protective_stop"
# Names of the persons who have stopped the cell by the service; it outlives this node.
STOPPED_PARAMETER = "remodel/protective_stop_by"

_ANSWERS = {
    Permit.GRANTED: BeginOperationResponse.GRANTED,
    Permit.HELD: BeginOperationResponse.HELD,
    Permit.REFUSED: BeginOperationResponse.REFUSED,
}
_OF_RUN = (
    Command.PAUSE,
    Command.RESUME,
    Command.STOP,
    Command.PROTECTIVE_STOP,
    Command.RELEASE,
)
_OF_TASK = (Command.SKIP, Command.RETRY)


class RunServices:
    """Passes requests on to the supervisor, on its loop.

    Attributes:
        commands: does what is commanded; holds the cell during protective stops.
    """

    def __init__(
        self,
        loop: RosEventLoop,
        abilities: Abilities,
    ) -> None:
        """Advertise all services, and listen to safety controllers.

        Args:
            loop: on which requests are processed.
            abilities: that a protective stop cancels, run or no run.
        """
        self._loop = loop
        self._abilities = abilities
        self.commands = RunCommands(
            loop,
            abilities,
            rospy.get_param(STOPPED_PARAMETER, []),
            lambda persons: rospy.set_param(STOPPED_PARAMETER, list(persons)),
        )
        rospy.Service(RECORDER, KeepRecord, self._on_record)
        rospy.Service(BEGIN, BeginOperation, self._on_begin)
        rospy.Service("remodel/use_case/answer", AnswerQuestion, self._on_answer)
        for command in _OF_RUN:
            self._serve_run(command)
        for command in _OF_TASK:
            self._serve_task(command)
        self._stops = rospy.Subscriber(PROTECTIVE_STOP, Bool, self._on_stop, tcp_nodelay=True)

    def ask_to_be_asked(self) -> None:
        """Have all states ask before they begin, and wait until their records are kept.

        When this process is killed they go on waiting for the next one, which stops them.
        """
        rospy.set_param(RECORDER_PARAMETER, rospy.resolve_name(RECORDER))

    def ask_no_more(self) -> None:
        """Have states begin as they like."""
        with contextlib.suppress(KeyError, OSError):
            rospy.delete_param(RECORDER_PARAMETER)

    def _on_record(self, request: KeepRecordRequest) -> KeepRecordResponse:
        record = request.record

        def keep() -> tuple[bool, str]:
            supervisor = self.commands.active
            if supervisor is not None:
                return supervisor.tasks.keep_record(record.behavior, operation_of(record))
            closed = self.commands.closed
            return not closed, closed or "no run is under way; the record is not kept"

        return KeepRecordResponse(*self._loop.call(keep, (False, "this node is shutting down")))

    def _on_begin(self, request: BeginOperationRequest) -> BeginOperationResponse:
        def begin() -> BeginOperationResponse:
            supervisor = self.commands.active
            if supervisor is None:
                closed = self.commands.closed
                held = BeginOperationResponse.HELD, 0, closed
                refused = BeginOperationResponse.REFUSED, 0, "no run is under way"
                return BeginOperationResponse(*(held if closed else refused))
            permit, why = supervisor.tasks.begin_operation(
                request.behavior, request.state_path, request.ability
            )
            return BeginOperationResponse(_ANSWERS[permit], supervisor.owner, why)

        leaving = BeginOperationResponse(BeginOperationResponse.HELD, 0, "shutting down")
        return self._loop.call(begin, leaving)

    def _serve_run(self, command: Command) -> None:
        def on_call(request: object) -> CommandRunResponse:
            return CommandRunResponse(*self._command(command, "", request.by))  # type: ignore[attr-defined]

        rospy.Service(f"remodel/use_case/{command.value}", CommandRun, on_call)

    def _serve_task(self, command: Command) -> None:
        def on_call(request: object) -> CommandTaskResponse:
            done = self._command(command, request.task, request.by)  # type: ignore[attr-defined]
            return CommandTaskResponse(*done)

        rospy.Service(f"remodel/use_case/{command.value}", CommandTask, on_call)

    def _command(self, command: Command, task: str, by: str) -> tuple[bool, str]:
        event = Commanded(command, task, by or "an unnamed client")

        def do(reply: Reply) -> None:
            self.commands.command(event, reply)

        # The gate closes first: what is cancelled before it does may be followed by another goal.
        if command is Command.PROTECTIVE_STOP:
            return self._loop.ask(do, self._abilities.cancel)
        return self._loop.ask(do)

    def _on_answer(self, request: object) -> AnswerQuestionResponse:
        number, choice, by = request.question, request.choice, request.by  # type: ignore[attr-defined]
        known = {answer.value for answer in Answer}

        def do(reply: Reply) -> None:
            supervisor = self.commands.active
            if choice not in known:
                reply(False, f"unknown answer {choice!r}; possible are {', '.join(sorted(known))}")
            elif supervisor is None:
                reply(False, "no run is under way")
            else:
                supervisor.answer(
                    Answered(number, Answer(choice), by or "an unnamed client"), reply
                )

        return AnswerQuestionResponse(*self._loop.ask(do))

    def _on_stop(self, message: Bool) -> None:
        by = message._connection_header.get("callerid", "a safety controller")
        self._loop.post(lambda: self._note_stop(by, is_stopped=message.data))
        if message.data:
            self._abilities.cancel()

    def _note_stop(self, by: str, *, is_stopped: bool) -> None:
        # A client that is not there any more, such as `rostopic pub`, cannot release its own stop.
        present = {link.callerid_pub for link in self._stops.impl.connections}
        self.commands.note_controller(by, is_stopped=is_stopped, present=present)


def operation_of(record: AbilityRecord) -> Operation:
    """Return a record as the planner keeps it."""
    return Operation(
        record.state_path,
        record.ability,
        record.outcome,
        record.error_code,
        text=record.error_message or record.message,
        ended_s=record.stamp.to_sec(),
        elapsed_s=record.elapsed_time,
        goal_id=record.goal_id,
        parameters=_pairs(record.parameters),
        measurements=_pairs(record.measurements),
    )


def _pairs(lines: list[str]) -> tuple[tuple[str, str], ...]:
    return tuple((name, value) for name, _, value in (line.partition("=") for line in lines))
