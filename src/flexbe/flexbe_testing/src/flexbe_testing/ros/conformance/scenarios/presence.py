"""What an engine is without any command: status, heartbeat, topics."""

from __future__ import annotations

import rospy
from flexbe_msgs.msg import BEStatus

from flexbe_testing.core.conformance import topics
from flexbe_testing.core.conformance.scenario import NotJudgedError, ViolationError, scenario
from flexbe_testing.ros.conformance.bench import Bench
from flexbe_testing.ros.conformance.scenarios.modules import CHAIN

_BEATS = 4
# [s] Mean time between heartbeats; 1 Hz, with room for a busy machine.
_SHORTEST_BEAT_S, _LONGEST_BEAT_S = 0.8, 1.25


@scenario(
    "A behavior of the package starts, with all topics advertised, and a preempt ends it", "3.2"
)
def runs_behaviors(bench: Bench) -> None:
    """Also connects everything, so that no later scenario loses a first message."""
    bench.start(CHAIN, 3)
    if missing := bench.wire.await_subscribed():
        raise ViolationError(f"not published while a behavior runs: {', '.join(missing)}")
    bench.preempt()


@scenario("An engine that has run nothing publishes READY with behavior_id 0 and no args", "3.2")
def ready(bench: Bench) -> None:
    """The first status received is the latched one."""
    tape = bench.wire.tape
    if not tape.wait(lambda: bool(tape.statuses), bench.limit_s):
        raise ViolationError(f"no status within {bench.limit_s:g} s; it must be latched")
    first = tape.statuses[0]
    if first.code != BEStatus.READY:
        raise NotJudgedError("the engine has run behaviors before; restart it to judge this")
    if first.behavior_id != 0 or first.args:
        raise ViolationError(f"READY carries id {first.behavior_id} and args {first.args}")


@scenario("The last status is latched: a later subscriber receives it", "3.2")
def status_is_latched(bench: Bench) -> None:
    """Subscribe again after a run."""
    bench.start(CHAIN)
    bench.preempt()
    bench.wire.subscribe_again(topics.STATUS)
    bench.status(BEStatus.FINISHED, ["preempted"])


@scenario("The heartbeat beats once per second, idle or not", "3.2")
def heartbeat(bench: Bench) -> None:
    """Judge all beats since the kit began."""
    beats = bench.wire.tape.beats
    if not bench.wire.tape.wait(lambda: len(beats) >= _BEATS, bench.limit_s):
        raise ViolationError(f"{len(beats)} beats within {bench.limit_s:g} s")
    mean_s = (beats[-1] - beats[0]) / (len(beats) - 1)
    if not _SHORTEST_BEAT_S <= mean_s <= _LONGEST_BEAT_S:
        raise ViolationError(f"one beat per {mean_s:.2f} s")


@scenario("All topics have the types of stock FlexBE", "3.2")
def topic_types(bench: Bench) -> None:
    """Compare what the master knows; messages with other sums would not arrive at all."""
    known = bench.wire.topic_types()
    for topic, kind in {**topics.PUBLISHED, **topics.COMMANDS}.items():
        found = known.get(rospy.resolve_name(topic), kind)
        if found not in (kind, "*"):
            raise ViolationError(f"{topic} has type {found}; expected: {kind}")
