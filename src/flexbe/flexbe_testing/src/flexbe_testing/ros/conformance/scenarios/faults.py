"""States that fail under supervision."""

from __future__ import annotations

from flexbe_msgs.msg import OutcomeRequest

from flexbe_testing.core.conformance import topics
from flexbe_testing.core.conformance.scenario import ViolationError, scenario
from flexbe_testing.ros.conformance.bench import Bench
from flexbe_testing.ros.conformance.scenarios.modules import CHAIN, FAULT


@scenario(
    "Supervised, a state that raises stays active, and the operator can force an outcome", "2.5"
)
def raising_state_is_held(bench: Bench) -> None:
    """It raises in every execution."""
    bench.start(FAULT, 3, args={"how": "execute"})
    bench.at("/Fault")
    bench.stays("the operator decides about a state that raises")
    bench.send(topics.TRANSITION, OutcomeRequest(0, "Fault"))
    bench.feedback("transition", "Fault", "Fault")
    bench.left("/Fault", "done", 0)
    bench.finished()


@scenario(
    "Supervised, an undeclared outcome keeps the state active; the operator can force an outcome",
    "2.5",
)
def undeclared_outcome_is_held(bench: Bench) -> None:
    """The state may be left and entered again, but no transition is taken."""
    bench.start_at("/First", CHAIN, 3)
    bench.gate("First", "undeclared")
    bench.never("enter /Second", "the outcome is not declared")
    if not bench.wire.tape.is_running:
        raise ViolationError("the behavior has ended")
    bench.send(topics.TRANSITION, OutcomeRequest(0, "First"))
    bench.feedback("transition", "First", "First")
    bench.left("/First", "done", 0)
    bench.at("/Second")
    bench.preempt()
