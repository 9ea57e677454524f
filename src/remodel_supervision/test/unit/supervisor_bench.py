"""A supervisor of an order, with everything beside it faked but the database."""

from dataclasses import replace
from types import SimpleNamespace

from house import BOARD, CATALOGUE, house_order, owner_of

from remodel_production.core.board.panel import panel_of
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.errors import LostError
from remodel_supervision.core.learning.experience import Experience
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import Answered, Commanded, RunBegun
from remodel_supervision.core.runs.gate import Permit
from remodel_supervision.edge.recorded_lessons import ability_calls
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.edge.task_leases import TaskLeases
from remodel_supervision.edge.work_planner import WorkPlanner
from remodel_supervision.errors import LeavingError
from remodel_supervision.ros.peers.board_message import board_message
from remodel_supervision.supervisors.ports import BehaviorEnd, EndKind, Peers, Work, server_of
from remodel_supervision.supervisors.run_record import RunRecord
from remodel_supervision.supervisors.use_case_supervisor import UseCaseSupervisor
from remodel_tasks.core.orders.board_order import kind_of
from remodel_tasks.core.use_case.fault import Policy
from remodel_tasks.edge.fault_file import read_faults
from remodel_tasks.edge.use_case_files import use_case_for

FAULTS = read_faults()

# What a call returns with which a behavior begins that then goes on until it is cancelled.
GOES_ON = object()


class FakeLoop:
    """Time passes only while a thread waits; `arrivals` are processed then, one a turn."""

    def __init__(self):
        self.wall, self.timers, self.arrivals, self.is_leaving = 100.0, [], [], False

    def now_s(self):
        return self.wall

    def wall_s(self):
        return self.wall

    def every(self, period_s, call):
        timer = SimpleNamespace(period_s=period_s, due_s=self.wall + period_s, call=call)
        timer.cancel = lambda: self.timers.remove(timer) if timer in self.timers else None
        self.timers.append(timer)
        return timer

    def run_until(self, holds, limit_s, *, while_leaving=False):
        end_s = self.wall + limit_s
        while True:
            if self.is_leaving and not while_leaving:
                raise LeavingError("this node is shutting down")
            if self.arrivals:
                self.arrivals.pop(0)()
            for timer in list(self.timers):
                if timer.due_s <= self.wall:
                    timer.due_s = self.wall + timer.period_s
                    timer.call()
            if holds():
                return True
            if self.wall >= end_s:
                return False
            self.wall = min(end_s, self.wall + 0.05)


class FakeCell:
    """A cell in which the wires lie that were fed."""

    def __init__(self):
        self.fed, self.loaded, self.trouble, self.truth = [], [], None, True
        self.refusal = self.demands = None
        self.feeds, self.take_overs = False, []
        self.at = "rosrpc://cell:1"

    def wait(self, limit_s):
        pass

    def address(self):
        return self.at

    def load(self, panel, serial, owner, *, demands, keep):
        assert owner > 0
        if self.refusal:
            raise self.refusal
        self.demands = demands
        self.loaded.append((serial, keep))

    def feed(self, wire, owner):
        if self.trouble:
            trouble, self.trouble = self.trouble, None
            raise trouble
        self.fed.append(wire)

    def take_over(self, owner):
        if self.take_overs:
            raise self.take_overs.pop(0)
        return not self.feeds

    def placed(self, wire):
        return self.truth


class FakeMaker:
    def __init__(self):
        self.asked = []

    def wait(self, limit_s):
        pass

    def make(self, chart):
        self.asked.append(chart.name)


class FakeAbilities:
    """Their servers are away for some checks; those that stall are connected, and silent."""

    latest = None

    def __init__(self):
        self.away, self.cancelled, self.stalled, self.stops = 0, 0, (), ()

    def cancel(self, owner=None):
        self.cancelled += 1

    def is_connected(self, ability):
        return ability in self.stalled

    def answers(self, ability, since_s):
        self.away -= 1
        return self.away < 0 and ability not in self.stalled

    def are_quiet(self, since_s, owner=None):
        return not self.stalled

    def restless(self, since_s, owner=None):
        return tuple(server_of(ability) for ability in self.stalled)

    def take_stops(self):
        stops, self.stops = self.stops, ()
        return stops


class FakeEngine:
    """Ends behaviors as given, in turn: an outcome, an error code, an exception, or a call."""

    state_path, is_idle = "", True

    def __init__(self):
        self.endings, self.ran, self.cancelled, self.back = [], [], 0, True
        self.clearings = []
        self.end, self.trouble, self.supervisor = None, "", None

    def wait(self, limit_s):
        if not self.back:
            raise LostError("the engine does not answer")

    def start(self, behavior):
        self.ran.append(behavior)
        self.end, self.trouble = None, ""
        if behavior.endswith(" Clear") and self.clearings:
            self.clearings.pop(0)()
        if behavior.endswith((" Clear", " Discard")):
            self.end = self.end or BehaviorEnd(EndKind.FINISHED, "finished")
            return
        ending = self.endings.pop(0) if self.endings else "finished"
        if callable(ending):
            if ending() is not GOES_ON:
                self.end = self.end or BehaviorEnd(EndKind.FINISHED, "finished")
        elif isinstance(ending, LostError):
            self.trouble = str(ending)
        elif isinstance(ending, BaseException):
            raise ending
        elif isinstance(ending, int):
            self.operate(behavior, ending)
            self.end = BehaviorEnd(EndKind.FINISHED, "failed")
        else:
            self.end = BehaviorEnd(EndKind.FINISHED, ending)

    def operate(self, behavior, code, path="/Insert a"):
        """Have an operation granted and recorded; return the permit."""
        tasks = self.supervisor().tasks
        permit, _ = tasks.begin_operation(behavior, path, "InsertCable")
        if permit is Permit.GRANTED:
            goal = f"{path}#{len(self.ran)}"
            done = Operation(path, "InsertCable", "failed", code, "no", 2.0, 1.0, goal)
            assert tasks.keep_record(behavior, done) == (True, "")
            assert tasks.keep_record(behavior, done) == (True, ""), "sent twice, kept once"
        return permit

    def cancel(self, own_only=False):
        self.cancelled += 1
        self.end = self.end or BehaviorEnd(EndKind.PREEMPTED, "stopped")

    def path(self):
        return ("/Insert a", "/Find ends")


class FakeInspection:
    """Sees the ends that are given as connected."""

    def __init__(self):
        self.connected, self.trouble = set(), None

    def wait(self, limit_s):
        pass

    def is_connected(self, owner, wire, end, component, terminal):
        if self.trouble:
            raise self.trouble
        return (wire, end) in self.connected


class FakePictures:
    def begin(self):
        pass

    def keep(self, run, label):
        return ()


class Bench:
    """A supervisor of the order, with everything beside it faked but the database."""

    def __init__(self, url, attended=False, explore=False, timeout_s=0.0, policy=None):
        self.database = ProductionDatabase(url)
        self.log = RunLog(self.database)
        use_case = replace(use_case_for(kind_of(BOARD)), recovery=policy or Policy())
        experience = Experience(use_case, ability_calls(self.database), explore=explore)
        self.loop, self.notified = FakeLoop(), []
        self.cell, self.maker, self.engine = FakeCell(), FakeMaker(), FakeEngine()
        self.abilities, self.inspection = FakeAbilities(), FakeInspection()
        self.engine.supervisor = lambda: self.supervisor
        self.owner = owner_of(self.database)
        self.leases = TaskLeases(self.database, "house", "cell", 30.0, self.owner)
        order = house_order(use_case)
        self.work = Work(
            WorkPlanner(order, use_case, experience, 0.0),
            FAULTS,
            board_message(panel_of(BOARD, CATALOGUE), order),
            leases=self.leases,
            attended=attended,
            reconnect_s=1.0,
            notify=self.notified.append,
        )
        begun = RunBegun("house", use_case.name, "cell", ("W1", "W2"), timeout_s=timeout_s)
        self.number, _ = self.log.begin(begun, self.owner)
        self.take_up()

    def take_up(self):
        """Have a new supervisor take the run up."""
        state = state_after(kept.event for kept in self.log.events(self.number))
        self.supervisor = UseCaseSupervisor(
            RunRecord(self.number, self.owner, state, self.log, loop=self.loop),
            self.loop,
            self.work,
            Peers(
                self.cell,
                self.maker,
                self.engine,
                self.abilities,
                self.inspection,
                FakePictures(),
            ),
            on_change=lambda: None,
        )

    def take_over(self):
        """Have a new owner of the cell take the run up; return the token of the one before."""
        before, self.owner = self.owner, owner_of(self.database)
        self.leases = TaskLeases(self.database, "house", "cell", 30.0, self.owner)
        self.work = replace(self.work, leases=self.leases)
        self.log.take_up(self.number, self.owner)
        self.take_up()
        return before

    def run(self, *endings):
        """Let behaviors end so, and return the run's state when it has ended."""
        self.engine.endings = list(endings)
        return self.supervisor.supervise()

    def command(self, command, task=""):
        """Give a command, and return the list that its reply is put into."""
        replies = []
        event = Commanded(command, task, "ann")
        self.supervisor.command(event, lambda granted, text: replies.append((granted, text)))
        return replies

    def answer_questions(self, choice):
        """Have an operator answer each question some seconds after it is asked."""

        def answer():
            if question := self.supervisor.state.question:
                event = Answered(question.number, choice, "ann")
                self.supervisor.answer(event, lambda *reply: None)

        self.loop.every(10.0, answer)

    def events(self, *kinds):
        return [k.event for k in self.log.events(self.number) if isinstance(k.event, kinds)]

    @property
    def ran(self):
        return [name.removeprefix("Place Wire ") for name in self.engine.ran]
