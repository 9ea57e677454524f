"""What mirrors need of a running behavior, and what happens in containers and to userdata."""

from __future__ import annotations

import rospy
from flexbe_msgs.msg import OutcomeRequest
from flexbe_msgs.srv import GetUserdata, GetUserdataResponse
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
from flexbe_testing.ros.bench import CHAIN, NEST, PAIR, PRIORITY, VALUES, Bench
from flexbe_testing.ros.wire import EVENT

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


# Userdata: through containers, and the service that shows it


def _hold(bench: Bench) -> None:
    bench.start(VALUES, inputs={"piece": "copper"})
    bench.at("/Hold")


def _release(bench: Bench) -> None:
    bench.gate("Hold", "done")
    bench.finished()


def _get(key: str) -> GetUserdataResponse:
    return rospy.ServiceProxy(topics.USERDATA_SERVICE, GetUserdata)(key)


@scenario("Outputs reach later states through contained behaviors and remapped keys", "2.3")
def userdata_is_remapped(bench: Bench) -> None:
    """Label of the state, label of the contained behavior, tag of the root, shown of the state."""
    bench.start(VALUES, inputs={"piece": "copper"})
    shown = bench.text_event("shown ")
    if shown != "made of copper":
        raise ViolationError(f"the state read {shown!r}; expected: 'made of copper'")
    bench.at("/Hold")
    _release(bench)


@scenario("flexbe/get_userdata shows a key with state, type and data", "3.2")
def get_userdata(bench: Bench) -> None:
    """A key of the root."""
    bench.require_service(topics.USERDATA_SERVICE)
    _hold(bench)
    answer = _get("tag")
    found = [(info.state, info.key, info.type, info.data) for info in answer.userdata]
    expected = ("Conformance Values", "tag", "str", "made of copper")
    if not answer.success or expected not in found:
        raise ViolationError(f"success {answer.success}, {found}; expected: {expected}")
    keys = {info.key for info in _get("").userdata}
    if not {"piece", "tag"} <= keys:
        raise ViolationError(f"an empty key shows {sorted(keys)}; expected: all")
    _release(bench)


@scenario("flexbe/get_userdata fails for a key that does not exist, and while nothing runs", "3.2")
def get_userdata_fails(bench: Bench) -> None:
    """Ask before a run and during one."""
    bench.require_service(topics.USERDATA_SERVICE)
    if _get("").success:
        raise ViolationError("success while nothing runs")
    _hold(bench)
    if _get("no_such_key").success:
        raise ViolationError("success for a key that is not there")
    _release(bench)
