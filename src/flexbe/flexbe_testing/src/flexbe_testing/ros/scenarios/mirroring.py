"""What mirrors need: structure, outcomes, synchronization, attaching."""

from __future__ import annotations

from flexbe_msgs.msg import OutcomeRequest
from std_msgs.msg import Empty, Int32, String, UInt8

from flexbe_testing.core import topics
from flexbe_testing.core.scenario import (
    NotJudgedError,
    Part,
    ViolationError,
    checksum,
    initial,
    scenario,
    successor,
)
from flexbe_testing.ros.bench import CHAIN, NEST, PAIR, Bench

_NAME = "Conformance Chain"


def _structure(bench: Bench) -> dict[str, Part]:
    """Ask for the structure of the running behavior."""
    bench.send(topics.REQUEST_STRUCTURE, Int32(bench.id))
    message = bench.find(topics.STRUCTURE, {"behavior_id": bench.id})
    paths = [container.path for container in message.containers]
    if len(set(paths)) != len(paths) or "" not in paths:
        raise ViolationError(f"the structure has the paths {paths}; expected: each once, and ''")
    return {
        part.path: Part(
            part.path, tuple(part.children), tuple(part.outcomes), tuple(part.transitions)
        )
        for part in message.containers
    }


def _synchronized(bench: Bench, path: str) -> None:
    expected = {"behavior_id": bench.id, "current_state_checksum": checksum(path)}
    bench.find(topics.MIRROR_SYNC, expected)


@scenario(
    "The structure lists every state and container with outcomes, transitions, autonomy", "3.3"
)
def structure(bench: Bench) -> None:
    """Of two states in a row."""
    bench.start(CHAIN, 3)
    bench.send(topics.REQUEST_STRUCTURE, Int32(bench.id))
    found = bench.find(topics.STRUCTURE, {"behavior_id": bench.id})
    expected = {
        "": (["First", "Second"], ["finished", "failed"], [], []),
        "/First": ([], ["done", "other"], ["Second", "failed"], [1, 3]),
        "/Second": ([], ["done", "other"], ["finished", "First"], [0, 2]),
    }
    parts = {part.path: part for part in found.containers}
    if sorted(parts) != sorted(expected):
        raise ViolationError(f"paths {sorted(parts)}; expected: {sorted(expected)}")
    for path, part in parts.items():
        shown = (part.children, part.outcomes, part.transitions, list(part.autonomy))
        if shown != expected[path]:
            raise ViolationError(f"{path!r} is {shown}; expected: {expected[path]}")
    bench.preempt()


@scenario("Structure and published outcomes lead a mirror to the states that are entered", "3.3")
def outcomes_lead_a_mirror(bench: Bench) -> None:
    """Follow a nested behavior as a mirror does."""
    bench.start(NEST, 3)
    parts = _structure(bench)
    path: str | None = initial(parts)
    for word in ("done", "other", "other", "done", "other", "other", "other"):
        bench.at(path or "")
        bench.gate((path or "").rpartition("/")[2], word)
        index = bench.expect(topics.OUTCOME, {}).data
        bench.expect(topics.CURRENT_STATE, {"data": f"{path} > {word}"})
        try:
            path = successor(parts, path or "", index)
        except (ValueError, LookupError) as error:
            raise ViolationError(str(error)) from error
    bench.finished("failed")
    if path is not None:
        raise ViolationError(f"the behavior has ended; the mirror is at {path}")


@scenario("A sync is acknowledged, and publishes checksums of behavior and active path", "3.2")
def sync(bench: Bench) -> None:
    """In a nested container."""
    bench.start_at("/Box/Inner/Leaf", NEST, 3)
    bench.send(topics.SYNC, Empty())
    bench.feedback("sync")
    _synchronized(bench, "/Box/Inner/Leaf")
    bench.preempt()


@scenario(
    "An attach is acknowledged with the name, synchronizes, and supervises from then on", "3.2"
)
def attach(bench: Bench) -> None:
    """Join an unsupervised behavior at level 1."""
    bench.start_at("/First", CHAIN)
    bench.send(topics.ATTACH, UInt8(1))
    bench.feedback("attach", _NAME)
    _synchronized(bench, "/First")
    bench.gate("First", "done")
    bench.expect(topics.REQUEST, {"outcome": 0, "target": "/First"})
    bench.send(topics.TRANSITION, OutcomeRequest(0, "First"))
    bench.feedback("transition", "First", "First")
    bench.left("/First", "done", 0)
    bench.at("/Second")
    bench.send(topics.PREEMPT, Empty())
    bench.feedback("preempt")
    bench.finished("preempted")


@scenario("A request for the structure makes an unsupervised behavior publish its outcomes", "3.2")
def structure_request_supervises(bench: Bench) -> None:
    """Its level stays 255: nothing is asked for."""
    bench.start_at("/First", CHAIN)
    _structure(bench)
    bench.gate("First", "other")
    bench.left("/First", "other", 1)
    bench.finished("failed")


@scenario("The end of a concurrency container synchronizes mirrors with the state after it", "2.4")
def sync_after_concurrency(bench: Bench) -> None:
    """Which child ended last is not visible to a mirror."""
    bench.start(PAIR, 3)
    bench.in_any_order("enter /Both/Left", "enter /Both/Right")
    bench.gate("Left", "done")
    bench.left_among_others("/Both/Left", "done", 0)
    bench.gate("Right", "done")
    bench.at("/After")
    _synchronized(bench, "/After")
    bench.preempt()


@scenario("A mirror publishes the active path of a supervised run, and '' at its end", "3.3")
def mirror_publishes_paths(bench: Bench) -> None:
    """Judged if a mirror runs beside the engine."""
    if not bench.mirrors():
        raise NotJudgedError(
            "there is no mirror: nothing publishes flexbe/request_mirror_structure"
        )
    bench.start(CHAIN, 3)
    bench.find(topics.UPDATE, {"data": "/First"})
    bench.pass_gate("/First")
    bench.expect(topics.UPDATE, {"data": "/Second"})
    bench.preempt()
    bench.expect(topics.UPDATE, {"data": ""})


@scenario("A lock by the path of a container above the active state finds it", "2.2")
def paths_are_of_labels(bench: Bench) -> None:
    """Paths hold labels, without the behavior's name."""
    bench.start_at("/Box/Inner/Leaf", NEST, 3)
    bench.send(topics.LOCK, String("/Conformance Nest/Box"))
    bench.feedback("lock", "/Conformance Nest/Box", "")
    bench.send(topics.LOCK, String("/Box/Inner"))
    bench.feedback("lock", "/Box/Inner", "/Box/Inner")
    bench.preempt()
