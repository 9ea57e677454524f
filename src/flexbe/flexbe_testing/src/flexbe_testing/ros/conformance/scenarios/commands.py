"""Preempt, pause, resume, repeat."""

from __future__ import annotations

from flexbe_msgs.msg import BEStatus
from std_msgs.msg import Bool, Empty

from flexbe_testing.core.conformance import topics
from flexbe_testing.core.conformance.scenario import scenario
from flexbe_testing.ros.conformance.bench import Bench
from flexbe_testing.ros.conformance.scenarios.modules import CHAIN, NEST


def _pause(bench: Bench) -> None:
    """Pause a behavior in the state `First`."""
    bench.send(topics.PAUSE, Bool(True))
    bench.feedback("pause")
    bench.event("pause /First")


@scenario("A preempt of a supervised behavior is acknowledged, and ends it with `preempted`", "3.2")
def preempt_supervised(bench: Bench) -> None:
    """on_stop is called for all states."""
    bench.start_at("/Box/Inner/Leaf", NEST, 3)
    bench.preempt()
    paths = ("/Box/Inner/Leaf", "/Box/Inner/Tail", "/Box/Last", "/After")
    bench.in_any_order(*(f"stop {path}" for path in paths))


@scenario("A preempt of an unsupervised behavior ends it, without feedback", "2.4")
def preempt_unsupervised(bench: Bench) -> None:
    """The silence is judged at the end of the scenario."""
    bench.require_unwatched()
    bench.start_at("/First", CHAIN)
    bench.preempt()
    bench.silent(topics.FEEDBACK, "the behavior was unsupervised")


@scenario("A preempt while nothing runs does not stop the next behavior", "2.4")
def preempt_while_idle(bench: Bench) -> None:
    """Leave the engine time to receive it."""
    bench.wire.send_if_heard(topics.PREEMPT, Empty(), bench.quiet_s)
    bench.silent(topics.STATUS, "nothing was running")
    bench.start_at("/First", CHAIN)
    bench.stays("no preempt was sent to this behavior")
    bench.gate("First", "other")
    bench.finished("failed")


@scenario("A paused state is not executed; resumed, it continues; both are acknowledged", "2.2")
def pause_and_resume(bench: Bench) -> None:
    """on_pause and on_resume are called."""
    bench.start_at("/First", CHAIN, 3)
    _pause(bench)
    bench.gate("First", "done")
    bench.stays("it is paused")
    bench.send(topics.PAUSE, Bool(False))
    bench.feedback("resume")
    bench.event("resume /First")
    bench.left("/First", "done", 0)
    bench.at("/Second")
    bench.preempt()


@scenario("A preempt ends a paused behavior", "2.2")
def preempt_while_paused(bench: Bench) -> None:
    """The feedback is published as well."""
    bench.start_at("/First", CHAIN, 3)
    _pause(bench)
    bench.preempt()


@scenario(
    "A repeat is acknowledged; the state is left, without a transition, and entered again", "2.2"
)
def repeat(bench: Bench) -> None:
    """No outcome is published for it."""
    bench.start_at("/First", CHAIN, 3)
    bench.send(topics.REPEAT, Empty())
    bench.feedback("repeat")
    bench.events("exit /First", "enter /First")
    bench.stays("it was only repeated")
    bench.gate("First", "other")
    bench.expect(topics.REQUEST, {"outcome": 1, "target": "/First"})
    bench.preempt()


@scenario("Commands of one behavior do not act on the next", "2.2")
def commands_end_with_the_run(bench: Bench) -> None:
    """Pause a behavior, stop it, and run the next."""
    bench.start_at("/First", CHAIN, 3)
    _pause(bench)
    bench.preempt()
    bench.start_at("/First", CHAIN, 3)
    bench.pass_gate("/First")
    bench.at("/Second")
    bench.pass_gate("/Second")
    bench.status(BEStatus.FINISHED, ["finished"])
