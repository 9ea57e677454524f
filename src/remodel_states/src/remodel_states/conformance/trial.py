"""What is tried with an ability server, one trial after the other."""

from __future__ import annotations

import copy
import subprocess
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

from genpy import Message

from remodel_states.conformance import rules
from remodel_states.conformance.exchange import Exchange
from remodel_states.conformance.goals import goals_with_unknown_names, invalid_goals
from remodel_states.conformance.probe import Probe
from remodel_states.conformance.rules import Rule, Violation
from remodel_states.core.contract_times import GRACE_S

# [s] ROS time in which a server refuses a goal, or is heard to work on it.
ANSWER_LIMIT_S = 5.0

# [s] ROS time to continue listening after a goal's end, for messages that should not arrive.
LINGER_S = 0.6

# [s] ROS time; a goal that takes less cannot be caught while it runs.
QUICKEST_S = 0.3

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
        self, probe: Probe, goal: Message, codes: Collection[int], restart: str = ""
    ) -> None:
        """Prepare.

        Args:
            probe: the connection to the server.
            goal: a goal that it can do, with id and timeout.
            codes: all error codes.
            restart: shell command that kills and restarts the server; empty for none.
        """
        self._probe = probe
        self._goal = goal
        self._restart = restart
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
            return
        yield self._unknown_cancel()
        yield self._timeout()
        yield self._cancel()
        yield self._two_at_once()
        yield from self._invalid_goals()
        yield from self._unknown_names()
        yield (
            self._restarted()
            if self._restart
            else Trial("restart of the server", unjudged="no command given, see --restart")
        )

    def _nominal(self, exchange: Exchange) -> Trial:
        self._finish(exchange)
        if exchange.is_refused:
            raise NotTestableError(
                f"the server refuses the goal: {exchange.result.reason}; give one that it can do, "
                "see --goal"
            )
        self._probe.wait(lambda: False, LINGER_S)
        self._nominal_s = exchange.took_s
        return self._judged("a goal that can be done", [exchange])

    def _unknown_cancel(self) -> Trial:
        name = "a cancel of a goal that was never sent"
        if self._is_quick():
            return Trial(name, unjudged=self._too_quick())
        exchange = self._send()
        self._while_it_runs(exchange)
        self._probe.cancel_unknown_goal()
        self._finish(exchange)
        trial = self._judged(name, [exchange])
        if exchange.result and exchange.result.status in rules.CANCELLED:
            found = Violation("foreign-cancel", "a cancel with another id cancelled the goal")
            return Trial(name, (*trial.faults, found))
        return trial

    def _timeout(self) -> Trial:
        name = "a timeout shorter than the ability takes"
        if self._is_quick():
            return Trial(name, unjudged=self._too_quick())
        exchange = self._send(timeout=self._nominal_s / 2)
        self._finish(exchange)
        if exchange.is_refused:
            return Trial(name, unjudged=f"the server refuses it: {exchange.result.reason}")
        trial = self._judged(name, [exchange])
        if trial.faults or not exchange.is_done:
            return trial
        timeout_s = exchange.goal.timeout
        return Trial(
            name,
            unjudged=f"the goal succeeded after {exchange.took_s:.2f} s, with a timeout of "
            f"{timeout_s:.2f} s and {GRACE_S:g} s of grace: a server that ignores timeouts does "
            f"the same. Give a goal that takes at least {2 * GRACE_S + 1:g} s, see --goal",
        )

    def _cancel(self) -> Trial:
        name = "a cancel while the ability works"
        if self._is_quick():
            return Trial(name, unjudged=self._too_quick())
        exchange = self._send()
        self._while_it_runs(exchange)
        self._probe.cancel(exchange)
        self._finish(exchange)
        return self._judged(name, [exchange])

    def _two_at_once(self) -> Trial:
        name = "a second goal while the first is done"
        if self._is_quick():
            return Trial(name, unjudged=self._too_quick())
        first = self._send()
        self._while_it_runs(first)
        second = self._send()
        self._finish(first)
        self._finish(second)
        return self._judged(name, [first, second], without=(rules.reports_elapsed_time,))

    def _invalid_goals(self) -> Iterator[Trial]:
        for bad in invalid_goals(self._goal):
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

    def _unknown_names(self) -> Iterator[Trial]:
        for bad in goals_with_unknown_names(self._goal):
            exchange = self._finish(self._send(bad.goal))
            also = (rules.fails_with_unknown_name,)
            yield self._judged(f"a goal with {bad.what}", [exchange], also)

    def _restarted(self) -> Trial:
        name = "restart of the server"
        running = self._send()
        done = subprocess.run(
            self._restart, shell=True, check=False, timeout=RESTART_LIMIT_S, capture_output=True
        )
        if done.returncode:
            text = done.stderr.decode(errors="replace").strip()
            return Trial(name, unjudged=f"the command failed with {done.returncode}: {text}")
        if not self._probe.wait_for_server(RESTART_LIMIT_S):
            return Trial(name, (Violation("not-back", f"not back after {RESTART_LIMIT_S:g} s"),))
        after = self._finish(self._send())
        trial = self._judged(name, [after])
        if running.is_done and running.result.ros_s > after.sent_ros_s:
            found = Violation("ghost", "the new server ended the goal of the old one with success")
            return Trial(name, (*trial.faults, found))
        return trial

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

    def _while_it_runs(self, exchange: Exchange) -> None:
        """Wait until a third of the time is over that the ability takes."""
        self._probe.wait(lambda: bool(exchange.results), self._nominal_s / 3)

    def _is_quick(self) -> bool:
        return self._nominal_s < QUICKEST_S

    def _too_quick(self) -> str:
        return (
            f"the ability takes {self._nominal_s:.2f} s with this goal; give one that takes at "
            f"least {QUICKEST_S} s"
        )

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
