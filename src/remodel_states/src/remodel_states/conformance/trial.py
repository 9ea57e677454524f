"""What is tried with an ability server, one trial after the other."""

from __future__ import annotations

import copy
import json
import subprocess
import tempfile
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import asdict, dataclass

from genpy import Message
from remodel_msgs.msg import ErrorCode

from remodel_states.conformance import rules
from remodel_states.conformance.clauses import (
    CANCEL,
    FEEDBACK,
    INVALID_GOAL,
    NOMINAL,
    OLD_GOAL,
    OTHERS,
    RESTART,
    TIMEOUT,
    TWO_AT_ONCE,
    UNKNOWN_CANCEL,
    UNKNOWN_NAME,
    TrialKind,
)
from remodel_states.conformance.probe import (
    Probe,
    goals_with_unknown_names,
    invalid_goals,
    names_left_empty,
)
from remodel_states.conformance.rules import Exchange, Rule, Violation
from remodel_states.core.contract import GRACE_S, SILENT_LIMIT_S

# [s] ROS time in which a server refuses a goal, or is heard to work on it.
ANSWER_LIMIT_S = 5.0

# [s] ROS time to continue listening after a goal's end, for messages that should not arrive.
LINGER_S = 0.6

# [s] ROS time; a goal that takes less cannot be caught while it runs.
QUICKEST_S = 0.3

# A busy machine delays some cancels, a slow server delays each: so often one that is late is tried.
CANCEL_TRIES = 3

# [s] Wall time for a server to come back after the restart command.
RESTART_LIMIT_S = 60.0


@dataclass(frozen=True)
class Trial:
    """One trial and what came of it.

    Attributes:
        name: what was tried.
        faults: what the server does not keep; empty if all is well.
        unjudged: why nothing can be said; empty if it was judged.
    """

    name: str
    faults: tuple[Violation, ...] = ()
    unjudged: str = ""


class NotTestableError(Exception):
    """The server cannot be tried at all; the text says why and what to do."""


class Trials:
    """The trials of one server."""

    def __init__(
        self,
        probe: Probe,
        goal: Message,
        codes: Collection[int],
        restart: str = "",
        restart_limit_s: float = RESTART_LIMIT_S,
    ) -> None:
        """Prepare.

        Args:
            probe: the connection to the server.
            goal: a goal that it can do, with id and timeout.
            codes: all error codes.
            restart: shell command that kills and restarts the server; empty for none.
            restart_limit_s: [s] wall time for that command, and again until the server serves.
        """
        self._probe = probe
        self._goal = goal
        self._restart = restart
        self._restart_limit_s = restart_limit_s
        self._count = 0
        self._nominal_s = 0.0
        self._always: tuple[Rule, ...] = (
            rules.answers_once,
            rules.echoes_the_id,
            rules.is_consistent,
            rules.knows_its_codes(codes),
            rules.reports_elapsed_time,
            rules.reports_progress,
            rules.keeps_its_timeout,
            rules.ends_when_cancelled,
        )

    def run(self, limit_s: float = ANSWER_LIMIT_S) -> Iterator[Trial]:
        """Yield the trials as they end; a server that never answers gets no more than the first.

        Args:
            limit_s: [s] wall time to wait for the server.

        Raises:
            NotTestableError: if there is no server, or it refuses the good goal.
        """
        if not self._probe.wait_for_server(limit_s):
            missing = ", ".join(self._probe.missing()) or "/clock"
            raise NotTestableError(
                f"no server of this type: no node is connected on {missing}; start the server, and "
                "compare TYPE with `rostopic info`"
            )
        nominal = self._send()
        yield self._nominal(nominal)
        if not nominal.results:
            yield _unjudged(OTHERS, OTHERS.unjudged)
            return
        yield self._feedback(nominal)
        yield self._unknown_cancel()
        yield self._timeout()
        yield self._cancel()
        yield self._two_at_once()
        yield from self._invalid_goals()
        yield from self._unknown_names()
        yield from self._restarted()

    def _nominal(self, exchange: Exchange) -> Trial:
        self._finish(exchange)
        if exchange.is_refused:
            raise NotTestableError(
                f"the server refuses the goal: {exchange.result.reason}; give one that it can do, "
                "see --goal"
            )
        self._probe.wait(lambda: False, LINGER_S)
        self._nominal_s = exchange.took_s
        return self._judged(NOMINAL.name, [exchange])

    def _feedback(self, exchange: Exchange) -> Trial:
        if not exchange.feedback and exchange.took_s <= SILENT_LIMIT_S:
            return _unjudged(
                FEEDBACK,
                f"the goal took {exchange.took_s:.2f} s, and only one that takes longer than "
                f"{SILENT_LIMIT_S:g} s must report its progress",
            )
        return Trial(FEEDBACK.name, tuple(rules.gives_feedback(exchange)))

    def _unknown_cancel(self) -> Trial:
        if self._is_quick():
            return _unjudged(UNKNOWN_CANCEL, self._too_quick())
        exchange = self._send()
        if not self._runs(exchange):
            return _unjudged(UNKNOWN_CANCEL, self._ended_before("the cancel"))
        self._probe.cancel_unknown_goal()
        self._finish(exchange)
        trial = self._judged(UNKNOWN_CANCEL.name, [exchange])
        if exchange.result and exchange.result.status in rules.CANCELLED:
            found = Violation("foreign-cancel", "a cancel with another id cancelled the goal")
            return Trial(trial.name, (*trial.faults, found))
        return trial

    def _timeout(self) -> Trial:
        if self._is_quick():
            return _unjudged(TIMEOUT, self._too_quick())
        exchange = self._finish(self._send(timeout=self._nominal_s / 2))
        if exchange.is_refused:
            return _unjudged(TIMEOUT, f"the server refuses it: {exchange.result.reason}")
        trial = self._judged(TIMEOUT.name, [exchange])
        result = exchange.result
        if trial.faults or result is None or result.message.error_code == ErrorCode.TIMEOUT:
            return trial
        timeout_s = exchange.goal.timeout
        if not exchange.is_done:
            return _unjudged(
                TIMEOUT,
                f"the goal failed before its timeout of {timeout_s:.2f} s: {result.reason}",
            )
        return _unjudged(
            TIMEOUT,
            f"the goal succeeded after {exchange.took_s:.2f} s, with a timeout of "
            f"{timeout_s:.2f} s and {GRACE_S:g} s of grace: a server that ignores timeouts does "
            f"the same. Give a goal that takes at least {2 * GRACE_S + 1:g} s, see --goal",
        )

    def _cancel(self) -> Trial:
        if self._is_quick():
            return _unjudged(CANCEL, self._too_quick())
        for _ in range(CANCEL_TRIES):
            exchange = self._send()
            if not self._runs(exchange):
                return _unjudged(CANCEL, self._ended_before("the cancel"))
            self._probe.cancel(exchange)
            self._finish(exchange)
            trial = self._judged(CANCEL.name, [exchange])
            if all(fault.rule != "slow-cancel" for fault in trial.faults):
                break
        return trial

    def _two_at_once(self) -> Trial:
        if self._is_quick():
            return _unjudged(TWO_AT_ONCE, self._too_quick())
        first = self._send()
        if not self._runs(first):
            return _unjudged(TWO_AT_ONCE, self._ended_before("the second one"))
        second = self._send()
        self._finish(first)
        self._finish(second)
        return self._judged(
            TWO_AT_ONCE.name, [first, second], without=(rules.reports_elapsed_time,)
        )

    def _invalid_goals(self) -> Iterator[Trial]:
        for bad in (bad_goals := list(invalid_goals(self._goal))):
            exchange = self._send(bad.goal)
            self._probe.wait(
                lambda e=exchange: bool(e.results) or e.active_ros_s is not None, ANSWER_LIMIT_S
            )
            if not exchange.results:
                self._probe.cancel(exchange)
                self._probe.wait(lambda e=exchange: bool(e.results), ANSWER_LIMIT_S)
            refuses = rules.refuses_invalid_goal(bad.field)
            faults = [*refuses(exchange)] or [*rules.answers_once(exchange)]
            yield Trial(f"a goal with {bad.what}", tuple(faults))
        if all(bad.field in ("id", "timeout") for bad in bad_goals):
            reason = "with NaN: the goal has no other field of numbers than timeout"
            yield _unjudged(INVALID_GOAL, reason)

    def _unknown_names(self) -> Iterator[Trial]:
        for bad in (bad_goals := list(goals_with_unknown_names(self._goal))):
            exchange = self._finish(self._send(bad.goal))
            also = (rules.fails_with_unknown_name,)
            yield self._judged(f"a goal with {bad.what}", [exchange], also)
        if empty := names_left_empty(self._goal):
            reason = f"empty in the goal: {', '.join(empty)}; give names, see --goal"
            yield _unjudged(UNKNOWN_NAME, reason)
        elif not bad_goals:
            yield _unjudged(UNKNOWN_NAME, "the goal has no field of text but id")

    def _restarted(self) -> Iterator[Trial]:
        if not self._restart:
            yield _unjudged(RESTART, "no command given, see --restart")
            return
        running = self._send()
        self._probe.wait(lambda: running.active_ros_s is not None, ANSWER_LIMIT_S)
        ended_before = bool(running.results)
        if reason := self._restart_problem():
            yield _unjudged(RESTART, reason)
            yield _unjudged(OLD_GOAL, "the server was not restarted")
            return
        # A success by then is of the old server, or of one that the command has not reached.
        ended_before |= running.is_done
        if not self._probe.wait_for_server(self._restart_limit_s):
            found = f"not back after {self._restart_limit_s:g} s"
            yield Trial(RESTART.name, (Violation("not-back", found),))
            yield _unjudged(OLD_GOAL, "the server is not back")
            return
        after = self._finish(self._send())
        yield self._judged(RESTART.name, [after])
        if ended_before:
            yield _unjudged(OLD_GOAL, self._ended_before("the server was restarted"))
            return
        longest_s = (1.0 + rules.CLOCK_SLACK) * self._nominal_s + rules.CLOCK_SLACK_S
        self._probe.wait(lambda: bool(running.results), longest_s)
        if running.is_done and running.result.ros_s > after.sent_ros_s:
            found = "the new server ended the goal of the old one with success"
            yield Trial(OLD_GOAL.name, (Violation("ghost", found),))
        else:
            yield Trial(OLD_GOAL.name)

    def _restart_problem(self) -> str:
        """Restart the server; return why that was not possible, empty if it was.

        The command may leave the server behind, which keeps what the command writes to open: so
        that is no pipe.
        """
        with tempfile.TemporaryFile() as errors:
            try:
                done = subprocess.run(
                    self._restart,
                    shell=True,
                    check=False,
                    timeout=self._restart_limit_s,
                    stdout=subprocess.DEVNULL,
                    stderr=errors,
                )
            except subprocess.TimeoutExpired:
                return f"the command did not end within {self._restart_limit_s:g} s"
            errors.seek(0)
            text = errors.read().decode(errors="replace").strip()
        return f"the command failed with {done.returncode}: {text}" if done.returncode else ""

    def _send(self, goal: Message | None = None, timeout: float | None = None) -> Exchange:
        """Send a goal; the good one gets an id of its own."""
        self._count += 1
        if goal is None:
            goal = copy.deepcopy(self._goal)
            goal.id = f"{goal.id}#{self._count}"
        if timeout is not None:
            goal.timeout = timeout
        return self._probe.send(goal)

    def _finish(self, exchange: Exchange) -> Exchange:
        """Wait for the result; an overdue goal is cancelled, so that it disturbs no other."""
        limit_s = exchange.goal.timeout + GRACE_S + rules.CLOCK_SLACK_S
        if not self._probe.wait(lambda: bool(exchange.results), limit_s):
            self._probe.cancel(exchange)
            self._probe.wait(lambda: bool(exchange.results), ANSWER_LIMIT_S)
        return exchange

    def _runs(self, exchange: Exchange) -> bool:
        """Wait for a third of the ability's time; return whether the goal still runs.

        A cancel has a connection of its own: on a busy machine it overtakes a goal that the server
        does not work on yet, and actionlib ends that goal with an empty result.
        """
        self._probe.wait(
            lambda: (
                bool(exchange.results or exchange.feedback) or exchange.active_ros_s is not None
            ),
            ANSWER_LIMIT_S,
        )
        return not self._probe.wait(lambda: bool(exchange.results), self._nominal_s / 3)

    def _is_quick(self) -> bool:
        return self._nominal_s < QUICKEST_S

    def _too_quick(self) -> str:
        return (
            f"the ability takes {self._nominal_s:.2f} s with this goal; give one that takes at "
            f"least {QUICKEST_S} s"
        )

    def _ended_before(self, what: str) -> str:
        return f"the goal ended before {what}; it took {self._nominal_s:.2f} s the first time"

    def _judged(
        self,
        name: str,
        exchanges: list[Exchange],
        also: tuple[Rule, ...] = (),
        without: tuple[Callable[..., object], ...] = (),
    ) -> Trial:
        judges = [rule for rule in (*self._always, *also) if rule not in without]
        faults = [fault for e in exchanges for rule in judges for fault in rule(e)]
        return Trial(name, tuple(dict.fromkeys(faults)))


def _unjudged(kind: TrialKind, reason: str) -> Trial:
    return Trial(kind.name, unjudged=reason)


# Findings of a server's trials, in words and as JSON


def line(trial: Trial) -> str:
    """Return what a person reads about a trial."""
    if trial.unjudged:
        return f"not judged  {trial.name}: {trial.unjudged}"
    if not trial.faults:
        return f"ok          {trial.name}"
    found = "".join(f"\n            [{fault.rule}] {fault.found}" for fault in trial.faults)
    return f"BROKEN      {trial.name}{found}"


def summary(trials: Sequence[Trial]) -> str:
    """Return the last line: how many trials were kept, broken and not judged."""
    broken = sum(bool(trial.faults) for trial in trials)
    unjudged = sum(bool(trial.unjudged) for trial in trials)
    return f"{len(trials) - broken - unjudged} kept, {broken} broken, {unjudged} not judged"


def as_json(topic: str, action: str, trials: Sequence[Trial]) -> str:
    """Return all trials as JSON."""
    found = [asdict(trial) for trial in trials]
    return json.dumps({"topic": topic, "action": action, "trials": found}, indent=2)
