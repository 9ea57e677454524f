"""The parts of engine_conformance that need no engine."""

from __future__ import annotations

import ast
import http.server
import os
import signal
import socketserver
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest
import rospy

from flexbe_testing.core import topics
from flexbe_testing.core.scenario import (
    Finding,
    Part,
    Scenario,
    UnknownScenarioError,
    Verdict,
    agrees,
    as_json,
    checksum,
    chosen,
    initial,
    shown,
    successor,
    table,
)
from flexbe_testing.ros.bench import Bench
from flexbe_testing.ros.conformance import Judge, main
from flexbe_testing.ros.wire import EngineWire, Interrupt, InterruptedByUserError, Tape

PACKAGE = Path(__file__).parents[2]
JUDGE = PACKAGE / "src" / "flexbe_testing"
FEEDBACK = SimpleNamespace(command="lock", args=("/A", "/A"), __slots__=("command", "args"))

SCENARIOS = [
    Scenario(name, f"what {name} requires", "2.2", lambda bench: None)
    for name in ("sync", "attach", "repeat")
]
TREE = {
    part.path: part
    for part in (
        Part("", ("Box", "End"), ("finished",), ()),
        Part("/Box", ("In", "Out"), ("ok",), ("End",)),
        Part("/Box/In", (), ("done", "again"), ("Out", "In")),
        Part("/Box/Out", (), ("done",), ("ok",)),
        Part("/End", (), ("done", "lost"), ("finished", "Nowhere")),
    )
}


def test_the_judge_imports_nothing_of_an_engine():
    parts = ["core/scenario.py", "core/topics.py"]
    parts += ["ros/bench.py", "ros/conformance.py", "ros/wire.py"]
    files = [*(JUDGE / part for part in parts), *(JUDGE / "ros/scenarios").glob("*.py")]
    assert len(files) == 9
    for file in [*files, PACKAGE / "nodes" / "engine_conformance"]:
        for node in ast.walk(ast.parse(file.read_text())):
            names = [alias.name for alias in getattr(node, "names", [])] + [
                getattr(node, "module", "")
            ]
            tops = {str(name).split(".")[0] for name in names}
            assert not tops & {"flexbe_core", "flexbe_onboard", "flexbe_mirror"}, file


def test_the_behaviors_use_only_the_public_interface():
    files = list((PACKAGE / "conformance").rglob("*.py"))
    assert len(files) > 10
    for file in files:
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("flexbe_core"):
                assert node.module in ("flexbe_core", "flexbe_core.proxy"), file


def test_checksums_are_those_of_stock():
    assert checksum("") == 1
    assert checksum("Wikipedia") == 0x11E60398
    assert checksum("x" * 100_000) < 2**31


def test_messages_agree_in_the_fields_that_are_expected():
    assert agrees(FEEDBACK, {"command": "lock"})
    assert agrees(FEEDBACK, {"args": ["/A", "/A"]})
    assert not agrees(FEEDBACK, {"command": "lock", "args": ["/A", ""]})
    assert shown(FEEDBACK, {"args": []}) == "{args: ['/A', '/A']}"
    assert shown(FEEDBACK) == "{command: 'lock', args: ['/A', '/A']}"


def test_a_structure_says_what_follows():
    assert initial(TREE) == "/Box/In"
    assert successor(TREE, "/Box/In", 0) == "/Box/Out"
    assert successor(TREE, "/Box/In", 1) == "/Box/In"
    assert successor(TREE, "/Box/Out", 0) == "/End"
    assert successor(TREE, "/End", 0) is None


def test_a_structure_without_what_follows_is_refused():
    with pytest.raises(ValueError, match="leads to 'Nowhere', which is not there"):
        successor(TREE, "/End", 1)
    with pytest.raises(LookupError):
        successor(TREE, "/End", 2)


def test_scenarios_are_chosen_by_name_and_keep_their_order():
    assert chosen(SCENARIOS, []) == SCENARIOS
    assert [item.name for item in chosen(SCENARIOS, ["repeat", "sync"])] == ["sync", "repeat"]
    with pytest.raises(UnknownScenarioError, match="no scenario 'atach'; near it: attach"):
        chosen(SCENARIOS, ["atach"])


def test_the_table_has_verdicts_reasons_and_a_count():
    verdicts = (Verdict.PASS, Verdict.FAIL, Verdict.NOT_JUDGED)
    found = [
        Finding(scenario, verdict, "" if verdict is Verdict.PASS else "a reason")
        for scenario, verdict in zip(SCENARIOS, verdicts, strict=True)
    ]
    lines = table(found).splitlines()
    assert lines[0].split() == ["scenario", "section", "verdict", "required"]
    assert lines[2].split(maxsplit=3) == ["sync", "2.2", "pass", "what sync requires"]
    assert lines[3].endswith("what attach requires | a reason")
    assert lines[-1] == "1 pass, 1 FAIL, 1 not judged"
    assert '"verdict": "FAIL"' in as_json(found)


# Ctrl-C while engine_conformance plays scenarios: the engine is idle afterwards


STARTED, FINISHED = 0, 1
# [s] No test waits as long; a hang ends here.
LIMIT_S = 30.0


class FakeWire:
    """An engine that answers each start and each preempt, by a thread, after it was asked.

    Attributes:
        late: the answer to the next start comes only when this is set.
        broken_off: requests to the engine's node that did not end.
    """

    def __init__(self):
        self.interrupt = Interrupt()
        self.tape = Tape(self.interrupt)
        self.late = threading.Event()
        self.late.set()
        self.broken_off = 0

    def publishers(self, topic):
        return []

    def send(self, topic, message):
        self.broken_off += 1
        os.kill(os.getpid(), signal.SIGINT)  # in the middle of the request
        self.broken_off -= 1
        threading.Thread(target=self.answer, args=(STARTED,)).start()

    def send_if_heard(self, topic, message, within_s):
        assert topic == topics.PREEMPT
        threading.Thread(target=self.answer, args=(FINISHED,)).start()

    def answer(self, code):
        assert self.late.wait(LIMIT_S)
        self.tape.add(SimpleNamespace(code=code), topics.STATUS)


class FakeJudge(Judge):
    """A judge of an engine that is a fake."""

    def __init__(self, wire):
        self.bench = Bench(wire, Path(), LIMIT_S, quiet_s=0.01)
        self._interrupt = wire.interrupt
        self._stuck = ""


def play(bench):
    bench.request(SimpleNamespace())
    bench.wire.tape.next(topics.STATUS, LIMIT_S)
    bench.wire.tape.next(topics.FEEDBACK, LIMIT_S)  # nothing is published there
    raise AssertionError("the scenario goes on after an interrupt")


@pytest.fixture
def wire():
    wire = FakeWire()
    with wire.interrupt.on_sigint():
        yield wire


SCENARIO = Scenario("starts", "starts", "2.2", play)


def test_an_interrupt_breaks_no_request_off_and_stops_the_behavior(wire):
    with pytest.raises(InterruptedByUserError):
        FakeJudge(wire).play(SCENARIO)
    assert wire.broken_off == 0
    assert [message.code for message in wire.tape.statuses] == [STARTED, FINISHED]


def test_a_behavior_that_starts_late_after_an_interrupt_is_stopped_too(wire):
    wire.late.clear()
    judge = FakeJudge(wire)
    # Longer than the scenario waits for what must not happen.
    threading.Timer(20 * judge.bench.quiet_s, wire.late.set).start()
    with pytest.raises(InterruptedByUserError):
        judge.play(SCENARIO)
    assert [message.code for message in wire.tape.statuses] == [STARTED, FINISHED]


def test_an_interrupt_after_the_last_wait_ends_the_judging(wire):
    scenario = Scenario("ends", "ends", "2.2", lambda bench: os.kill(os.getpid(), signal.SIGINT))
    with pytest.raises(InterruptedByUserError):
        FakeJudge(wire).play(scenario)
        wire.interrupt.check()


def test_python_gets_sigint_again_afterwards():
    before = signal.getsignal(signal.SIGINT)
    with Interrupt().on_sigint():
        assert signal.getsignal(signal.SIGINT) != before
    assert signal.getsignal(signal.SIGINT) == before


# The kit sends nothing before all that an engine publishes reaches it


KIT, ENGINE = "/kit", "/engine"


class Engine:
    """The connections of an engine, as the bus info of its node lists them."""

    def __init__(self, sent, listed_as):
        self.connections = [
            (i, listed_as, "o", "TCPROS", f"/{topic}", True) for i, topic in enumerate(sent)
        ]

    def getBusInfo(self, _caller):  # noqa: N802 - XML-RPC's name
        return 1, "bus info", self.connections


@pytest.fixture
def kit(monkeypatch):
    """Return a kit that waits no time, and whose own list says that all is connected."""
    monkeypatch.setattr(rospy, "get_name", lambda: KIT)
    monkeypatch.setattr(rospy, "resolve_name", lambda topic: f"/{topic}")
    wire = object.__new__(EngineWire)
    wire.interrupt, wire._limit_s, wire._uri = (
        SimpleNamespace(check=lambda: None),
        0.0,
        "http://kit",
    )
    wire._engine_ends = {ENGINE}
    making = SimpleNamespace(get_stats_info=lambda: [(0, ENGINE, "i", "TCPROS", "", True)])
    wire._subscribers = {topic: SimpleNamespace(impl=making) for topic in topics.WATCHED}
    return wire


@pytest.mark.parametrize("listed_as", [KIT, "http://kit/"])
def test_what_the_engine_sends_here_is_connected(kit, listed_as):
    kit._engine_slave = Engine(topics.PUBLISHED, listed_as)
    assert kit.await_subscribed() == []


def test_a_connection_that_is_still_being_made_is_waited_for(kit):
    first, *others = topics.PUBLISHED
    kit._engine_slave = Engine(others, KIT)
    assert kit.await_subscribed() == [first]


def test_what_the_engine_sends_elsewhere_is_not_connected(kit):
    kit._engine_slave = Engine(topics.PUBLISHED, "/rosbag")
    assert kit.await_subscribed() == list(topics.PUBLISHED)


class Gate:
    """A publisher of the kit, one of whose connections the engine has closed."""

    name = "/conformance/first"

    def __init__(self, *alive):
        self.impl, self._alive, self._connections = self, alive, (*alive, ENGINE)

    def check(self):
        self._connections = self._alive

    def get_stats_info(self):
        return [(i, end, "o", "TCPROS", self.name, True) for i, end in enumerate(self._connections)]


@pytest.mark.parametrize("alive", [(), (ENGINE,)])
def test_a_word_waits_for_the_connection_of_a_behavior_started_again(kit, alive):
    kit._engine_slave = SimpleNamespace(
        getBusInfo=lambda _: (1, "", [(0, "http://kit/", "i", "TCPROS", Gate.name, True)])
    )
    assert kit._is_heard(Gate(*alive)) == bool(alive)


@pytest.mark.parametrize("uri", ["nonsense", "{web}"])
def test_what_is_no_master_is_reported_as_none(monkeypatch, capsys, uri):
    with socketserver.TCPServer(("127.0.0.1", 0), http.server.BaseHTTPRequestHandler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        web = f"http://127.0.0.1:{server.server_address[1]}"
        monkeypatch.setenv("ROS_MASTER_URI", uri.format(web=web))
        assert main([]) == 4
        server.shutdown()
    assert "no ROS master at" in capsys.readouterr().err
