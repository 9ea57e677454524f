"""Userdata: through containers, and the service that shows it."""

from __future__ import annotations

import rospy
from flexbe_msgs.srv import GetUserdata, GetUserdataResponse

from flexbe_testing.core.conformance import topics
from flexbe_testing.core.conformance.scenario import ViolationError, scenario
from flexbe_testing.ros.conformance.bench import Bench
from flexbe_testing.ros.conformance.scenarios.modules import VALUES


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
