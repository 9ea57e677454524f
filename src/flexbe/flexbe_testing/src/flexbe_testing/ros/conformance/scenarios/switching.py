"""Start requests while a behavior runs."""

from __future__ import annotations

from flexbe_msgs.msg import BEStatus, OutcomeRequest
from std_msgs.msg import String

from flexbe_testing.core.conformance import topics
from flexbe_testing.core.conformance.identity import checksum
from flexbe_testing.core.conformance.scenario import ViolationError, scenario
from flexbe_testing.ros.conformance.bench import Bench
from flexbe_testing.ros.conformance.scenarios.modules import CHAIN, NEST


@scenario("A request for the running behavior switches: its active state continues, locked", "3.2")
def switch_keeps_the_state(bench: Bench) -> None:
    """Unlock it at the end, as an operator does."""
    bench.start_at("/First", CHAIN, 3)
    bench.pass_gate("/First")
    bench.at("/Second")
    bench.request(bench.selection(CHAIN, 3))
    for phase in ("received", "start", "prepared"):
        bench.feedback("switch", phase)
    bench.status(BEStatus.SWITCHING, [])
    bench.status(BEStatus.STARTED, ["/Second"])
    bench.send(topics.TRANSITION, OutcomeRequest(0, "Second"))
    bench.feedback("transition", "Second", "Second")
    bench.send(topics.UNLOCK, String("/Second"))
    bench.feedback("unlock", "/Second", "/Second")
    bench.left("/Second", "done", 0)
    bench.finished()


def _goes_on(bench: Bench) -> None:
    """Expect that the refused request has changed nothing."""
    bench.pass_gate("/First")
    bench.at("/Second")
    bench.pass_gate("/Second")
    bench.finished()


@scenario(
    "A request for another behavior is refused, and the running one ends with FINISHED", "3.2"
)
def switch_to_another_is_refused(bench: Bench) -> None:
    """Stock FlexBE 1.4.1 ends it with SWITCHING, its known defect 2."""
    bench.start_at("/First", CHAIN, 3)
    other = bench.selection(NEST, 3)
    bench.request(other)
    bench.feedback("switch", "received")
    answer = bench.expect(topics.FEEDBACK, {"command": "switch"}).args
    if answer not in (["not_switchable"], ["failed"]):
        raise ViolationError(f"switch {answer}; expected: not_switchable or failed")
    bench.status(BEStatus.ERROR, [], other.behavior_checksum)
    _goes_on(bench)


@scenario(
    "A request that cannot be prepared is refused with `failed`; the running one continues", "3.2"
)
def switch_to_unknown_is_refused(bench: Bench) -> None:
    """An id that no package path has."""
    bench.start_at("/First", CHAIN, 3)
    unknown = bench.selection(CHAIN, 3)
    unknown.behavior_id = checksum("no_such_package.no_such_module")
    unknown.behavior_checksum = 1
    bench.request(unknown)
    bench.feedback("switch", "received")
    bench.find(topics.FEEDBACK, {"command": "switch", "args": ["failed"]})
    bench.status(BEStatus.ERROR, [], 1)
    _goes_on(bench)
