"""A run whose work cannot be made waits for a person, who has it resumed or ended."""

import pytest

from remodel_production.errors import LostError
from remodel_supervision.core.runs.events import Blocked, Command, Commanded, Ending, RunEnded
from remodel_supervision.core.runs.replay import replayed
from remodel_supervision.supervisors.run_commands import RunCommands, UnresumedRun


@pytest.fixture
def unresumed(bench):
    state = bench.log.state(bench.number)
    return UnresumedRun(bench.number, bench.owner, state, bench.log, "no use case 'cabinet'")


def given(bench, unresumed, command):
    """Give a command without a supervisor, and return the list that its reply is put into."""
    commands = RunCommands(bench.loop, bench.abilities)
    commands.unresumed, commands.closed = unresumed, unresumed.text
    replies = []
    event = Commanded(command, "", "ann")
    commands.command(event, lambda granted, text: replies.append((granted, text)))
    return replies


def test_it_names_the_reason_and_what_to_do(bench, unresumed):
    assert "run 1 of order house cannot be resumed: no use case 'cabinet'" in unresumed.text
    assert given(bench, unresumed, Command.PAUSE) == [(False, unresumed.text)]
    assert not unresumed.is_over


def test_it_is_resumed_without_an_event(bench, unresumed):
    ((granted, _),) = given(bench, unresumed, Command.RESUME)
    assert granted
    assert unresumed.is_over
    assert bench.run().ended.ending is Ending.COMPLETE


def test_it_is_ended_when_nothing_moves(bench, unresumed):
    bench.abilities.stalled = ("InsertCable",)
    replies = given(bench, unresumed, Command.STOP)
    assert (replies, bench.abilities.cancelled) == ([], 1)
    bench.abilities.stalled = ()
    bench.loop.run_until(lambda: False, 1.0)
    assert replies == [(True, "run 1 has ended")]
    assert [event.because for event in bench.events(Blocked)] == ["no use case 'cabinet'"]
    assert [event.ending for event in bench.events(RunEnded)] == [Ending.STOPPED]
    events = bench.events(object)
    assert [frame.differs for frame in replayed(events) if frame.differs] == []


def test_an_end_that_the_database_does_not_answer_is_asked_for_again(bench, unresumed, monkeypatch):
    kept = bench.log.append

    def append(*arguments):
        kept(*arguments)
        raise LostError("the production database does not answer")

    monkeypatch.setattr(bench.log, "append", append)
    ((granted, text),) = given(bench, unresumed, Command.STOP)
    assert (granted, unresumed.is_over) == (False, False)
    assert "does not answer" in text
    monkeypatch.setattr(bench.log, "append", kept)
    ((granted, _),) = given(bench, unresumed, Command.STOP)
    assert granted
    assert bench.log.state(bench.number).ended.ending is Ending.STOPPED
