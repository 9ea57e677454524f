"""A protective stop holds the cell, with or without a run; a command is answered in time."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from supervisor_bench import FakeAbilities, FakeLoop

from remodel_supervision.core.runs.events import Command, Commanded, Ending
from remodel_supervision.core.runs.gate import Permit
from remodel_supervision.supervisors.run_commands import RunCommands
from remodel_supervision.supervisors.run_control import REST_LIMIT_S

# remodel_msgs/ErrorCode.SERVER_LOST.
LOST = 4


class Cell:
    """The commands of a cell whose run may be under way."""

    def __init__(self, bench=None, persons=()):
        self.loop = bench.loop if bench else FakeLoop()
        self.abilities = bench.abilities if bench else FakeAbilities()
        self.kept = list(persons)
        self.commands = RunCommands(
            self.loop,
            self.abilities,
            persons,
            lambda names: self.kept.__setitem__(slice(None), names),
        )
        self.commands.active = bench.supervisor if bench else None

    def command(self, command, by="ann"):
        """Give a command, and return the list that its reply is put into."""
        replies = []
        event = Commanded(command, "", by)
        self.commands.command(event, lambda granted, text: replies.append((granted, text)))
        return replies

    def pass_time(self, for_s):
        self.loop.run_until(lambda: False, for_s)


def test_a_protective_stop_without_a_run_holds_the_cell_until_it_is_resumed():
    cell = Cell()
    cell.abilities.stalled = ("InsertCable",)
    replies = cell.command(Command.PROTECTIVE_STOP)
    assert (replies, cell.abilities.cancelled) == ([], 1), "something moves"
    cell.abilities.stalled = ()
    cell.pass_time(1.0)
    ((granted, text),) = replies
    assert granted
    assert text.startswith("no run is under way; the cell is held until")
    assert "protective stop by ann" in cell.commands.safety
    assert cell.kept == ["ann"]
    ((granted, text),) = cell.command(Command.RESUME)
    assert (granted, cell.commands.safety, cell.kept) == (True, "", [])
    assert "no run is under way" in text
    assert cell.command(Command.RESUME) == [(False, "no run is under way")]


def test_a_protective_stop_outlives_its_supervisor_and_stops_the_run_that_is_resumed(bench):
    cell = Cell(bench, persons=("ann",))
    cell.commands.stop_if_unsafe()
    assert bench.supervisor.state.protective == "ann"
    cell.commands.stop_if_unsafe()
    assert len(bench.events(Commanded)) == 1, "the run has it already"
    assert cell.command(Command.RESUME) == [(True, "")]
    assert (bench.supervisor.state.protective, cell.commands.safety) == ("", "")


def test_a_protective_stop_holds_the_cell_when_its_run_has_been_stopped(bench):
    cell, replies = Cell(bench), []

    def stop():
        replies.append(cell.command(Command.PROTECTIVE_STOP))
        replies.append(cell.command(Command.STOP))
        bench.engine.cancel()

    assert bench.run(stop).ended.ending is Ending.STOPPED
    assert [[granted for granted, _ in each] for each in replies] == [[True], [True]]
    cell.commands.active = None
    assert "protective stop by ann" in cell.commands.safety


def test_a_protective_stop_is_released_by_a_command_of_its_own_and_the_run_stays_paused(bench):
    cell = Cell(bench)
    assert cell.command(Command.RELEASE) == [(False, "no protective stop is in force")]
    cell.command(Command.PROTECTIVE_STOP)
    assert cell.commands.controllers == ()
    assert cell.command(Command.RELEASE) == [(True, "")]
    assert (cell.commands.safety, cell.kept) == ("", [])
    assert (bench.supervisor.state.protective, bench.supervisor.state.paused) == ("", True)
    assert cell.command(Command.RESUME) == [(True, "")]
    assert not bench.supervisor.state.paused


def test_only_a_safety_controller_releases_its_own_stop(bench):
    cell = Cell(bench)
    cell.command(Command.PROTECTIVE_STOP)
    cell.commands.note_controller("/safety", is_stopped=True, present=["/safety"])
    assert cell.commands.controllers == ("/safety",)
    ((granted, text),) = cell.command(Command.RELEASE)
    assert not granted
    assert "protective stop by /safety" in text
    cell.commands.note_controller("/safety", is_stopped=False, present=["/safety"])
    assert cell.command(Command.RELEASE) == [(True, "")]
    assert (bench.supervisor.state.protective, cell.kept) == ("", [])


def test_a_protective_stop_without_a_run_is_released_too():
    cell = Cell(persons=("ann",))
    assert cell.command(Command.RELEASE) == [(True, "the protective stop is released")]
    assert (cell.commands.safety, cell.kept) == ("", [])


class SlowRun:
    """A run under way that grants commands late, as while a server stalls."""

    def __init__(self):
        self.state = SimpleNamespace(ended=None, protective="")
        self.waiting = []

    def command(self, event, reply):
        self.waiting.append(reply)

    def grant_all(self):
        for reply in self.waiting:
            reply(True, "")


@pytest.mark.parametrize("by", ["ann", "bob"])
def test_a_resume_that_is_granted_late_does_not_release_a_stop_that_came_after_it(by):
    cell = Cell()
    cell.commands.active = run = SlowRun()
    cell.command(Command.PROTECTIVE_STOP)
    cell.command(Command.RESUME)
    replies = cell.command(Command.PROTECTIVE_STOP, by)
    run.grant_all()
    assert replies[0][1].startswith("the cell is held until")
    assert by in cell.commands.safety
    assert by in cell.kept
    run.waiting.clear()
    cell.command(Command.RESUME)
    run.grant_all()
    assert (cell.commands.safety, cell.kept) == ("", [])


def test_controllers_release_their_own_stops_before_anybody_resumes(bench):
    cell = Cell(bench)
    cell.commands.note_controller("/safety", is_stopped=True, present=["/safety"])
    assert bench.supervisor.state.protective == "/safety"
    assert not cell.command(Command.RESUME)[0][0]
    cell.commands.note_controller("/safety", is_stopped=False, present=["/safety"])
    assert cell.command(Command.RESUME) == [(True, "")]


def test_a_stop_without_a_run_is_answered_although_a_server_stalls_for_ever():
    cell = Cell()
    cell.abilities.stalled = ("InsertCable",)
    replies = cell.command(Command.PROTECTIVE_STOP)
    cell.pass_time(REST_LIMIT_S + 1.0)
    ((granted, text),) = replies
    assert not granted
    assert "not at rest" in text
    assert "the server of InsertCable" in text
    assert cell.commands.safety


def after(loop, delay_s, call):
    """Have something called once, after a time [s]."""

    def fire():
        timer.cancel()
        call()

    timer = loop.every(delay_s, fire)


def lose_server(bench, command, replies):
    """Have the server of an operation stall forever, and give a command."""
    assert bench.engine.operate(bench.engine.ran[-1], LOST) is Permit.GRANTED
    bench.abilities.stalled = ("InsertCable",)
    replies.append(bench.command(command))


def test_a_pause_names_the_server_that_stalls_and_nothing_begins_before_it_rests(bench):
    replies, ran = [], []

    def lose():
        lose_server(bench, Command.PAUSE, replies)
        after(bench.loop, REST_LIMIT_S - 1.0, lambda: replies.append(list(replies[0])))
        after(bench.loop, REST_LIMIT_S + 1.0, resume)

    def resume():
        replies.append(list(replies[0]))
        bench.command(Command.RESUME)
        ran.append(list(bench.engine.ran))
        after(bench.loop, 100.0, wake)

    def wake():
        ran.append(list(bench.engine.ran))
        assert "not at rest: the server of InsertCable" in bench.supervisor.doing
        bench.abilities.stalled = ()

    state = bench.run(lose)
    _, early, ((granted, text),) = replies
    assert early == []
    assert not granted
    assert text.startswith("not at rest 30 s after it was asked for: the server of InsertCable")
    assert ran[0] == ran[1], "nothing begins while the server may still complete its goal"
    assert state.ended.ending is Ending.COMPLETE
    assert bench.supervisor.doing == "ending: all tasks are done"


def test_a_pause_names_the_feeder_of_the_supervisor_before_if_it_does_not_rest(bench):
    bench.work = replace(bench.work, reconnect_s=100.0)
    bench.take_up()
    bench.cell.feeds, replies = True, []
    after(bench.loop, 1.0, lambda: replies.extend([bench.command(Command.PAUSE)]))

    def rest():
        bench.cell.feeds = False
        bench.command(Command.RESUME)

    after(bench.loop, REST_LIMIT_S + 5.0, rest)
    assert bench.run().ended.ending is Ending.COMPLETE
    (((granted, text),),) = replies
    assert not granted
    assert "not at rest 30 s after it was asked for: the feeder" in text


def test_a_stop_names_the_server_that_stalls(bench):
    replies = []
    state = bench.run(lambda: lose_server(bench, Command.STOP, replies))
    assert state.ended.ending is Ending.STOPPED
    (((granted, text),),) = replies
    assert not granted
    assert "not at rest: the server of InsertCable" in text
