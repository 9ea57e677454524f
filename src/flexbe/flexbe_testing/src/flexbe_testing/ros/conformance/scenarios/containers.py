"""Concurrency and priority containers."""

from __future__ import annotations

from flexbe_msgs.msg import OutcomeRequest

from flexbe_testing.core.conformance import topics
from flexbe_testing.core.conformance.scenario import ViolationError, scenario
from flexbe_testing.ros.conformance.bench import Bench
from flexbe_testing.ros.conformance.scenarios.modules import PAIR, PRIORITY
from flexbe_testing.ros.conformance.tape import EVENT

_LEFT, _RIGHT = "/Both/Left", "/Both/Right"


def _enter_both(bench: Bench, level: int = 255) -> None:
    bench.start(PAIR, level)
    bench.in_any_order(f"enter {_LEFT}", f"enter {_RIGHT}")


@scenario(
    "A concurrency container is left once all outcomes of a condition have been returned", "2.4"
)
def concurrency_waits_for_all(bench: Bench) -> None:
    """One after the other."""
    _enter_both(bench)
    bench.gate("Right", "done")
    bench.event(f"exit {_RIGHT}")
    bench.never("enter /After", "one of two children had not ended")
    bench.gate("Left", "done")
    bench.at("/After")
    bench.gate("After", "done")
    bench.finished()


@scenario(
    "The first condition that holds ends the container, and on_exit runs once per child", "2.4"
)
def concurrency_ends_the_others(bench: Bench) -> None:
    """The second child ends it."""
    _enter_both(bench)
    bench.gate("Right", "other")
    bench.finished("failed")
    bench.wire.tape.wait(lambda: "stop /After" in bench.wire.tape.left(EVENT), bench.limit_s)
    events = bench.wire.tape.left(EVENT)
    for path in (_LEFT, _RIGHT):
        if events.count(f"exit {path}") != 1:
            raise ViolationError(f"on_exit of {path} ran {events.count(f'exit {path}')} times")


@scenario("Only the first child of a concurrency container is supervised", "2.4")
def concurrency_supervises_the_first(bench: Bench) -> None:
    """A command for the second names the first in its answer."""
    _enter_both(bench, 0)
    bench.send(topics.TRANSITION, OutcomeRequest(1, "Right"))
    bench.feedback("transition", "Right", "Left")
    bench.gate("Left", "done")
    bench.expect(topics.REQUEST, {"outcome": 0, "target": _LEFT})
    bench.never(f"exit {_LEFT}", "level 0 allows nothing")
    bench.send(topics.TRANSITION, OutcomeRequest(0, "Left"))
    bench.feedback("transition", "Left", "Left")
    bench.left_among_others(_LEFT, "done", 0)
    bench.gate("Right", "done")
    bench.at("/After")
    bench.preempt()


@scenario("A preempt ends all children of a concurrency container", "2.4")
def concurrency_is_preempted(bench: Bench) -> None:
    """Supervised."""
    _enter_both(bench, 3)
    bench.preempt()
    bench.in_any_order(*(f"stop {path}" for path in (_LEFT, _RIGHT, "/After")))


@scenario("A priority container pauses concurrent states, and resumes them afterwards", "2.4")
def priority_pauses_siblings(bench: Bench) -> None:
    """The gate of the paused state is open meanwhile."""
    bench.start(PRIORITY)
    bench.in_any_order("enter /Both/Calm", "enter /Both/Watch/Wait")
    bench.gate("Wait", "done")
    bench.in_any_order("enter /Both/Watch/Alarm/Act", "pause /Both/Calm")
    bench.gate("Calm", "done")
    bench.never("exit /Both/Calm", "a priority container beside it is active")
    bench.gate("Act", "done")
    bench.in_any_order("resume /Both/Calm", "exit /Both/Calm")
    bench.finished()
