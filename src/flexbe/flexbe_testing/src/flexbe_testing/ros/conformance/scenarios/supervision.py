"""Autonomy levels, outcome requests, forced transitions, breakpoints."""

from __future__ import annotations

import rospy
from flexbe_msgs.msg import OutcomeRequest
from std_msgs.msg import UInt8

from flexbe_testing.core.conformance import topics
from flexbe_testing.core.conformance.scenario import scenario
from flexbe_testing.ros.conformance.bench import Bench
from flexbe_testing.ros.conformance.scenarios.modules import CHAIN

_WITHDRAWN = 255
_BREAKPOINTS = "/flexbe/breakpoints"

# First: done needs Low (1), other needs Full (3). Second: done needs Off (0), other needs High (2).


def _requested(bench: Bench, path: str, outcome: int) -> None:
    bench.expect(topics.REQUEST, {"outcome": outcome, "target": path})


def _force(bench: Bench, label: str, outcome: int) -> None:
    bench.send(topics.TRANSITION, OutcomeRequest(outcome, label))
    bench.feedback("transition", label, label)


def _set_level(bench: Bench, level: int) -> None:
    bench.send(topics.AUTONOMY, UInt8(level))
    bench.feedback("autonomy")


@scenario("At level 255 no outcome is requested, and mirrors receive nothing", "2.4")
def unsupervised_is_silent(bench: Bench) -> None:
    """Leave a state with an outcome that needs Full."""
    bench.require_unwatched()
    bench.start_at("/First", CHAIN)
    bench.gate("First", "other")
    bench.finished("failed")
    bench.silent(topics.OUTCOME, "the behavior was unsupervised")
    bench.silent(topics.REQUEST, "the behavior was unsupervised")


@scenario("A transition below the level is taken, and its index and path are published", "2.2")
def transition_below_level(bench: Bench) -> None:
    """Low and Off at level 3."""
    bench.start(CHAIN, 3)
    for path in ("/First", "/Second"):
        bench.at(path)
        bench.pass_gate(path)
    bench.finished()


@scenario("A transition at the level is requested once, and the state stays active", "2.2")
def transition_at_level_asks(bench: Bench) -> None:
    """Low at level 1; the operator then allows it."""
    bench.start_at("/First", CHAIN, 1)
    bench.gate("First", "done")
    _requested(bench, "/First", 0)
    bench.stays("its transition needs the operator")
    bench.silent(topics.REQUEST, "it was asked already")
    _force(bench, "First", 0)
    bench.left("/First", "done", 0)
    bench.preempt()


@scenario("Level 0 blocks even transitions that need Off", "2.4")
def level_0_blocks_off(bench: Bench) -> None:
    """Get to the state by force."""
    bench.start_at("/First", CHAIN, 0)
    _force(bench, "First", 0)
    bench.left("/First", "done", 0)
    bench.at("/Second")
    bench.gate("Second", "done")
    _requested(bench, "/Second", 0)
    bench.stays("level 0 allows nothing")
    bench.preempt()


@scenario("A raised level takes the requested transition; a lowered one requests", "3.2")
def level_is_changed(bench: Bench) -> None:
    """Raise from 2 to 3, then lower to 0."""
    bench.start_at("/First", CHAIN, 2)
    bench.pass_gate("/First")
    bench.at("/Second")
    bench.gate("Second", "other")
    _requested(bench, "/Second", 1)
    _set_level(bench, 3)
    bench.left("/Second", "other", 1)
    bench.at("/First")
    _set_level(bench, 0)
    bench.gate("First", "done")
    _requested(bench, "/First", 0)
    bench.preempt()


@scenario("A state that no longer returns the outcome withdraws its request with 255", "2.2")
def request_is_withdrawn(bench: Bench) -> None:
    """Close the gate again."""
    bench.start_at("/First", CHAIN, 1)
    bench.gate("First", "done")
    _requested(bench, "/First", 0)
    bench.gate("First", "")
    _requested(bench, "/First", _WITHDRAWN)
    bench.preempt()


@scenario("A state that returns another outcome requests that one", "2.2")
def request_is_changed(bench: Bench) -> None:
    """From Low to Full at level 1."""
    bench.start_at("/First", CHAIN, 1)
    bench.gate("First", "done")
    _requested(bench, "/First", 0)
    bench.gate("First", "other")
    _requested(bench, "/First", 1)
    bench.preempt()


@scenario("A forced transition is taken at any level, whatever the state returns", "2.2")
def forced_transition(bench: Bench) -> None:
    """Force an outcome that needs Full at level 0."""
    bench.start_at("/First", CHAIN, 0)
    _force(bench, "First", 1)
    bench.event("exit /First")
    bench.left("/First", "other", 1)
    bench.finished("failed")


@scenario("A forced transition for another label is acknowledged with both, and dropped", "2.2")
def forced_transition_elsewhere(bench: Bench) -> None:
    """Name the other state, by its label and by its path."""
    bench.start_at("/First", CHAIN, 3)
    for target in ("Second", "/Second"):
        bench.send(topics.TRANSITION, OutcomeRequest(0, target))
        bench.feedback("transition", target, "First")
    bench.stays("the transition was for another label")
    bench.preempt()


@scenario("A forced outcome that the state does not have is dropped; the state stays active", "2.2")
def forced_outcome_unknown(bench: Bench) -> None:
    """Send an index beyond the outcomes."""
    bench.start_at("/First", CHAIN, 3)
    _force(bench, "First", 9)
    bench.stays("it has no such outcome")
    bench.pass_gate("/First")
    bench.preempt()


@scenario("Every transition of a state in /flexbe/breakpoints is requested", "2.2")
def breakpoint(bench: Bench) -> None:
    """Engines may have the master notify them of the parameter: leave it the time to do so."""
    before = rospy.get_param(_BREAKPOINTS, [])
    rospy.set_param(_BREAKPOINTS, ["/First"])
    try:
        bench.next_beat()
        bench.start_at("/First", CHAIN, 3)
        bench.gate("First", "done")
        _requested(bench, "/First", 0)
        _force(bench, "First", 0)
        bench.left("/First", "done", 0)
        bench.preempt()
    finally:
        rospy.set_param(_BREAKPOINTS, before)
