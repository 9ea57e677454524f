"""What an operator commands: autonomy, forced transitions, preempt, pause, repeat, locks."""

from __future__ import annotations

import rospy
from flexbe_msgs.msg import BEStatus, OutcomeRequest
from std_msgs.msg import Bool, Empty, String, UInt8

from flexbe_testing.core import topics
from flexbe_testing.core.scenario import ViolationError, scenario
from flexbe_testing.ros.bench import CHAIN, FAULT, NEST, Bench

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


# Preempt, pause, resume, repeat


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


# Lock and unlock states and containers


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


# States that fail under supervision


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
