"""Engine, states, servers and the supervisor's ports in one process, with scripted abilities."""

from types import SimpleNamespace

import pytest
from remodel_msgs.msg import ErrorCode

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from remodel_rehearsal.ros.abilities import Exchange, Inspection, SupervisedLine
from remodel_rehearsal.ros.cell import CellClock, CellLoop, StuckError
from remodel_rehearsal.ros.engine import BehaviorMaker, LocalEngine, made
from remodel_states.ability_server import AbilityServer
from remodel_states.core.ability_error import AbilityError
from remodel_supervision.core.runs.gate import Permit
from remodel_supervision.errors import CellError
from remodel_supervision.supervisors.ports import EndKind, UnseenError

# Finds a wire, with up to two attempts.
CHART = """<?xml version="1.0"?>
<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="Look" initial="Find">
  <datamodel>
    <outcome name="finished"/>
    <outcome name="failed"/>
    <input name="cable_id" type="string" ext:default="W1"/>
  </datamodel>
  <state id="Find" type="DetectCableState" ext:attempts="2">
    <input name="cable_id" type="string"/>
    <transition event="detected" target="finished"/>
    <transition event="failed" target="Find"/>
    <transition event="command_error" target="failed"/>
    <transition event="exhausted" target="failed"/>
  </state>
</statemachine>
"""
TAKES_S = 1.5
OWNER = 7


class Scripted(AbilityServer):
    """Ends its goals after TAKES_S, one answer after the other: fields of a result, or an error."""

    def __init__(self, name, bench, answers):
        self._bench, self._answers = bench, list(answers)
        super().__init__(name, host=bench.exchange)

    def prepare(self, goal):
        self._bench.goals.append(goal)
        answer = self._answers.pop(0)
        if isinstance(answer, AbilityError) and answer.code == ErrorCode.BUSY:
            raise answer
        return answer

    def start(self, running, prepared):
        timer = self._bench.loop.every(TAKES_S, lambda: end())

        def end():
            timer.cancel()
            if isinstance(prepared, AbilityError):
                self.finish(running, lambda: running.fail(prepared.code, str(prepared), {}))
            else:
                self.finish(running, lambda: running.succeed("done", prepared))

    def cancel(self, running):
        self.finish(running, lambda: running.fail(ErrorCode.PREEMPTED, "cancelled", {}))


class Bench:
    """All of one process but supervisors and cell.

    Attributes:
        permits: what the supervisor answers next; it grants by default.
        kept: records that it has kept.
        goals: that arrived at a server.
    """

    def __init__(self, clock):
        self.clock = clock
        self.loop = CellLoop(self.clock)
        self.exchange = Exchange()
        self.line = SupervisedLine(self.exchange)
        self.maker = BehaviorMaker()
        self.engine = LocalEngine(self.clock, self.maker, self.line)
        self.exchange.on_end = self.engine.wake
        self.loop.parts += [self.engine, self.line]
        self.permits, self.kept, self.goals = [], [], []
        self.line.supervisor = SimpleNamespace(owner=OWNER, tasks=self)
        self.maker.make(parse_chart(CHART, "look.xml"))

    def begin_operation(self, behavior, path, ability):
        return (self.permits.pop(0) if self.permits else Permit.GRANTED), "because"

    def keep_record(self, behavior, operation):
        self.kept.append(operation)
        return True, ""

    def run(self, limit_s=100.0):
        self.engine.start("Look")
        self.loop.run_until(lambda: self.engine.end is not None, limit_s)
        return self.engine.end


@pytest.fixture
def clock():
    clock = CellClock()
    yield clock
    clock.close()


@pytest.fixture
def bench(clock):
    return Bench(clock)


def test_a_state_sends_its_goal_and_the_supervisor_keeps_what_it_did(bench):
    Scripted("DetectCable", bench, [{}])
    end = bench.run()
    assert (end.end, end.text) == (EndKind.FINISHED, "finished")
    (goal,), (kept,) = bench.goals, bench.kept
    assert goal.cable_id == "W1"
    assert kept.goal_id == goal.id == f"{OWNER}:Look/Find#1"
    assert (kept.outcome, kept.elapsed_s) == ("detected", pytest.approx(TAKES_S))
    assert bench.engine.path()[-1] == "/Find"


def test_the_chart_decides_what_follows_a_failure(bench):
    unseen = AbilityError(ErrorCode.CABLE_NOT_FOUND, "no wire")
    Scripted("DetectCable", bench, [unseen, {}])
    assert bench.run().text == "finished"
    assert [kept.outcome for kept in bench.kept] == ["failed", "detected"]


def test_a_server_that_refuses_a_goal_ends_it_as_a_command_error(bench):
    Scripted("DetectCable", bench, [AbilityError(ErrorCode.BUSY, "another goal")])
    assert bench.run().text == "failed"
    assert bench.kept[0].error_code == ErrorCode.BUSY
    assert "another goal" in bench.line.warnings[0]


def test_an_ability_without_a_server_is_an_error_that_names_those_there_are(bench):
    assert bench.run().text == "failed"
    assert "no ability at remodel_abilities/detectcable" in bench.line.warnings[0]


def test_a_held_operation_waits_until_the_supervisor_grants_it(bench):
    Scripted("DetectCable", bench, [{}])
    bench.permits = [Permit.HELD, Permit.HELD]
    assert bench.run().text == "finished"
    assert not bench.permits


def test_a_refused_operation_is_not_sent(bench):
    Scripted("DetectCable", bench, [{}])
    bench.permits = [Permit.REFUSED]
    assert bench.run().text == "failed"
    assert not bench.goals


def test_a_preempted_behavior_cancels_its_goal(bench):
    Scripted("DetectCable", bench, [{}])
    bench.engine.start("Look")
    bench.loop.run_until(lambda: bool(bench.goals), 1.0)
    assert bench.exchange.restless(0.0)
    bench.engine.cancel()
    bench.loop.run_until(lambda: bench.engine.end is not None, 1.0)
    assert bench.engine.end.end is EndKind.PREEMPTED
    assert bench.engine.is_idle and bench.exchange.are_quiet(0.0)
    assert bench.kept[0].error_code == ErrorCode.PREEMPTED


def test_results_that_need_a_person_are_reported_once(bench):
    Scripted("DetectCable", bench, [AbilityError(ErrorCode.MOTION_FAULT, "hit"), {}])
    bench.run()
    (stop,) = bench.exchange.take_stops()
    assert stop.error_code == ErrorCode.MOTION_FAULT
    assert bench.exchange.take_stops() == ()


@pytest.mark.parametrize("connected", [True, False])
def test_an_inspection_returns_what_was_seen(bench, connected):
    Scripted("CheckConnection", bench, [{"connected": connected}])
    inspection = Inspection(bench.exchange, bench.loop)
    assert inspection.is_connected(OWNER, "W1", "a", "Q1", terminal="T1") is connected


def test_an_inspection_that_sees_nothing_says_why(bench):
    Scripted(
        "CheckConnection", bench, [AbilityError(ErrorCode.COMPONENT_OCCLUDED, "the arm hides it")]
    )
    inspection = Inspection(bench.exchange, bench.loop)
    with pytest.raises(UnseenError, match="the arm hides it"):
        inspection.is_connected(OWNER, "W1", "a", "Q1", terminal="T1")


def test_a_chart_with_errors_is_refused_with_all_of_them(bench):
    broken = CHART.replace('target="finished"', 'target="nowhere"').replace("Look", "Broken")
    with pytest.raises(CellError, match="nowhere"):
        bench.maker.make(parse_chart(broken, "broken.xml"))


def test_a_behavior_is_what_the_synthesizer_writes():
    assert made(CHART, "Look").__name__ == "LookSM"


def test_time_passes_to_what_is_due_next(clock):
    loop, rung = CellLoop(clock), []
    loop.every(0.25, lambda: rung.append(clock.now_s))
    assert not loop.run_until(lambda: False, 1.0)
    assert rung == pytest.approx([1.25, 1.5, 1.75, 2.0])
    assert clock.now.to_sec() == pytest.approx(2.0)


def test_what_waits_forever_is_an_error(clock):
    with pytest.raises(StuckError):
        CellLoop(clock).run_until(lambda: False, float("inf"))
