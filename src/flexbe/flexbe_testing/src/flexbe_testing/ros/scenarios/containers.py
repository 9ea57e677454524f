"""What happens within a behavior: containers and userdata."""

from __future__ import annotations

import rospy
from flexbe_msgs.msg import OutcomeRequest
from flexbe_msgs.srv import GetUserdata, GetUserdataResponse

from flexbe_testing.core import topics
from flexbe_testing.core.scenario import ViolationError, scenario
from flexbe_testing.ros.bench import PAIR, PRIORITY, VALUES, Bench
from flexbe_testing.ros.wire import EVENT

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
