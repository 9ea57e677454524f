"""Ctrl-C while engine_conformance plays scenarios: the engine is idle afterwards."""

import os
import signal
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest

from flexbe_testing.core.conformance import topics
from flexbe_testing.core.conformance.scenario import Scenario
from flexbe_testing.ros.conformance.bench import Bench
from flexbe_testing.ros.conformance.command import Judge
from flexbe_testing.ros.conformance.wire import Interrupt, InterruptedByUserError, Tape

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
