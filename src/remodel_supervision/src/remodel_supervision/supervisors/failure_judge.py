"""What is done about failures: decided by policy, or asked of an operator."""

from __future__ import annotations

from collections.abc import Callable

from remodel_supervision.core.recovery.judge import (
    NoticeKind,
    QuestionNotice,
    decide_recovery,
    failure_of,
    question_about,
)
from remodel_supervision.core.runs.events import Asked, Escalated
from remodel_supervision.core.runs.gate import Gate
from remodel_supervision.core.runs.state import SERVER_TROUBLE
from remodel_supervision.core.runs.step import Ask, Decide
from remodel_supervision.supervisors.ports import Abilities, EventLoop, Work
from remodel_supervision.supervisors.run_record import RunRecord
from remodel_tasks.core.use_case.fault import Do

# [s] wall time that a server which is gone gets to start again before the policy has its turn.
_GONE_LIMIT_S = 20.0


class FailureJudge:
    """Decides about failed tasks, and asks operators."""

    def __init__(
        self,
        record: RunRecord,
        loop: EventLoop,
        work: Work,
        abilities: Abilities,
        gate: Gate,
        describe: Callable[[str], None],
    ) -> None:
        """Take the run's record, and what decisions depend on.

        Args:
            record: of the run.
            loop: time, and what arrives.
            work: what the run is about.
            abilities: whose servers are waited for.
            gate: ends the waiting when it halts.
            describe: publishes what is waited for.
        """
        self._record = record
        self._loop = loop
        self._work = work
        self._abilities = abilities
        self._gate = gate
        self._describe = describe

    def decide(self, name: str) -> None:
        """Decide what to do about a task that failed, when what it had trouble with answers."""
        planner = self._work.planner
        self.await_server(name)
        state = self._record.state
        task = state.tasks[name]
        now_s = self._loop.now_s()
        possible = {Do.RETRY, Do.RETRY_WITH, Do.LOOK_AGAIN, Do.NEW_PART, Do.SET_ASIDE, Do.STOP}
        if state.waiting:
            possible.add(Do.REPLAN)
        if self._work.attended:
            possible.add(Do.ASK_OPERATOR)
        failure = failure_of(task, self._work.faults, now_s)
        if planner.has_other_method(name, task.decisions, failure.state_path):
            possible.add(Do.OTHER_METHOD)
        if planner.has_other_end(name, task.decisions):
            possible.add(Do.OTHER_END)
        policy = planner.use_case.recovery
        bounds = planner.task(name, task.decisions).bounds(failure.state_path)
        unpromising = planner.experience.unpromising(
            failure.fault.name, possible, self._record.tried_responses()
        )
        faults = self._work.faults
        decided = decide_recovery(
            state,
            name,
            faults,
            policy,
            possible=possible,
            at_s=now_s,
            bounds=bounds,
            unpromising=unpromising,
        )
        self._record.append_if_next(Decide(name), decided, while_paused=True)

    def await_server(self, name: str) -> None:
        """Wait until the ability server with which a task had trouble answers, and rests.

        Before that it may still complete its goal; afterwards what it has done can be inspected.
        One that stays away is left to the policy.
        """
        operations = self._record.state.tasks[name].operations
        in_trouble = {o.ability for o in operations if o.error_code in SERVER_TROUBLE}
        since_s = self._loop.wall_s()
        abilities = self._abilities
        for ability in sorted(in_trouble - {"FeedWire"}):
            self._describe(f"{name}: waiting for the server of {ability} to answer")
            self._loop.run_until(
                lambda a=ability: (
                    bool(self._gate.halt)  # type: ignore[misc]
                    or abilities.answers(a, since_s)
                    or not (
                        abilities.is_connected(a) or self._loop.wall_s() < since_s + _GONE_LIMIT_S
                    )
                ),
                self._work.reconnect_s,
            )

    def ask(self, name: str) -> None:
        """Ask an operator about a task."""
        policy = self._work.planner.use_case.recovery
        now_s, limit_s = self._loop.now_s(), policy.question.timeout_s
        asked = question_about(
            self._record.state, name, self._work.faults, now_s, timeout_s=limit_s
        )
        self._record.append_if_next(Ask(name), asked)
        self._notify(NoticeKind.ASKED, asked)

    def escalate(self) -> None:
        """Act on a question that was not answered in time."""
        state = self._record.state
        asked = state.question
        if asked is not None and 0 < asked.timeout_s < self._loop.now_s() - asked.at_s:
            fault = self._work.faults[state.tasks[asked.task].decisions[-1].fault]
            do = self._work.planner.use_case.recovery.unanswered_for(fault)
            self._record.append(Escalated(asked.number, asked.task, do))
            self._notify(NoticeKind.TIMED_OUT, asked)

    def _notify(self, event: NoticeKind, asked: Asked) -> None:
        """Notify persons who are not at the console of a question."""
        state, fault = self._record.state, self._record.state.tasks[asked.task].decisions[-1].fault
        notice = QuestionNotice(
            event,
            state.cell,
            state.order,
            self._record.run,
            task=asked.task,
            question=asked.number,
            text=asked.text,
            choices=tuple(choice.value for choice in asked.choices),
            timeout_s=asked.timeout_s,
            then=self._work.planner.use_case.recovery.unanswered_for(
                self._work.faults[fault]
            ).value,
        )
        self._work.notify(notice.data())
