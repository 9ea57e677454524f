"""Lock and unlock states and containers."""

from __future__ import annotations

from flexbe_msgs.msg import OutcomeRequest
from std_msgs.msg import String

from flexbe_testing.core.conformance import topics
from flexbe_testing.core.conformance.scenario import scenario
from flexbe_testing.ros.conformance.bench import Bench
from flexbe_testing.ros.conformance.scenarios.modules import CHAIN, NEST


def _lock(bench: Bench, path: str, *answer: str) -> None:
    bench.send(topics.LOCK, String(path))
    bench.feedback("lock", *(answer or (path, path)))


def _unlock(bench: Bench, path: str, *answer: str) -> None:
    bench.send(topics.UNLOCK, String(path))
    bench.feedback("unlock", *(answer or (path, path)))


@scenario("A locked state keeps its outcome until it is unlocked", "2.2")
def lock_a_state(bench: Bench) -> None:
    """By its path."""
    bench.start_at("/First", CHAIN, 3)
    _lock(bench, "/First")
    bench.gate("First", "done")
    bench.stays("it is locked")
    _unlock(bench, "/First")
    bench.left("/First", "done", 0)
    bench.at("/Second")
    bench.preempt()


@scenario("An empty path locks and unlocks the active state, and the answer names it", "2.2")
def lock_the_active_state(bench: Bench) -> None:
    """In a nested container."""
    bench.start_at("/Box/Inner/Leaf", NEST, 3)
    leaf = "/Box/Inner/Leaf"
    _lock(bench, "", leaf, leaf)
    bench.gate("Leaf", "done")
    bench.stays("it is locked")
    _unlock(bench, "", leaf, leaf)
    bench.left(leaf, "done", 0)
    bench.at("/Box/Inner/Tail")
    bench.preempt()


@scenario("A locked container is not left, while states in it change", "2.4")
def lock_a_container(bench: Bench) -> None:
    """Lock the outer of two."""
    bench.start_at("/Box/Inner/Leaf", NEST, 3)
    _lock(bench, "/Box")
    for path, follower in (("Inner/Leaf", "Inner/Tail"), ("Inner/Tail", "Last")):
        bench.pass_gate(f"/Box/{path}")
        bench.at(f"/Box/{follower}")
    bench.gate("Last", "done")
    bench.stays("its container is locked")
    _unlock(bench, "/Box")
    bench.left("/Box/Last", "done", 0)
    bench.at("/After")
    bench.preempt()


@scenario("A forced transition of a locked state waits for the unlock", "2.2")
def forced_transition_while_locked(bench: Bench) -> None:
    """It is acknowledged at once."""
    bench.start_at("/First", CHAIN, 3)
    _lock(bench, "/First")
    bench.send(topics.TRANSITION, OutcomeRequest(0, "First"))
    bench.feedback("transition", "First", "First")
    bench.stays("it is locked")
    _unlock(bench, "/First")
    bench.left("/First", "done", 0)
    bench.at("/Second")
    bench.preempt()


@scenario("A lock for a path that is not active is acknowledged with an empty second text", "2.2")
def lock_elsewhere(bench: Bench) -> None:
    """The active state stays free."""
    bench.start_at("/First", CHAIN, 3)
    _lock(bench, "/Nowhere", "/Nowhere", "")
    bench.pass_gate("/First")
    bench.at("/Second")
    bench.preempt()


@scenario(
    "An unlock with an empty path while nothing is locked is acknowledged with two empty texts",
    "2.2",
)
def unlock_nothing(bench: Bench) -> None:
    """The operator console reads that as success."""
    bench.start_at("/First", CHAIN, 3)
    _unlock(bench, "", "", "")
    bench.preempt()


@scenario("A preempt ends a behavior whose state is locked", "2.2")
def preempt_while_locked(bench: Bench) -> None:
    """Also one that holds an outcome back."""
    bench.start_at("/First", CHAIN, 3)
    _lock(bench, "/First")
    bench.gate("First", "done")
    bench.stays("it is locked")
    bench.preempt()
