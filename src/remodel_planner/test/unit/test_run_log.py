"""What happens in runs is kept event by event, and several cells never do one task twice."""

import threading
import time
from collections import Counter
from dataclasses import replace

import pytest
from house import HOUSE
from sqlalchemy import create_engine, text

from remodel_planner.core.learning.learned_responses import TriedResponse
from remodel_planner.core.production import Component, Order, Side, Terminal, TerminalRef, Wire
from remodel_planner.core.recovery.fault import Do
from remodel_planner.core.run import Operation
from remodel_planner.core.supervision.events import (
    Decided,
    Ending,
    Interrupted,
    OperationEnded,
    Part,
    Planned,
    RunBegun,
    RunEnded,
    TaskBegun,
    TaskEnded,
)
from remodel_planner.core.supervision.state import state_after
from remodel_planner.edge.production_database import ProductionDatabase
from remodel_planner.edge.run_log import RunLog
from remodel_planner.edge.task_leases import Holding, TaskLeases
from remodel_planner.errors import LostError, OrderError

BEGUN = RunBegun("house", "switchgear", "cell", ("W1", "W2"))
JAM = Operation(
    "/Connect a/InsertCable",
    "InsertCable",
    "failed",
    301,
    "jam",
    2.0,
    1.0,
    "g1",
    (("force_limit", "8.0"),),
    (("peak_force", "7.5"),),
)
DECIDED = Decided(
    "W1",
    "insertion_jammed",
    301,
    "InsertCable",
    "/a",
    "jam",
    Do.SET_ASIDE,
    (),
    "why",
    "policy",
    3.0,
)
WHOLE = TaskBegun("W1", 1, Part.WHOLE, "Place Wire W1", "<chart/>", 1.0)


@pytest.fixture
def database(url):
    database = ProductionDatabase(url)
    database.add_order(HOUSE)
    yield database
    database.close()


def rows(url, query):
    engine = create_engine(url)
    with engine.connect() as connection:
        found = [tuple(row) for row in connection.execute(text(query))]
    engine.dispose()
    return found


def keep(log, *events):
    """Keep a run, and return its number."""
    run = log.begin(BEGUN)
    state = state_after([BEGUN])
    for event in events:
        state = log.append(run, event, state)
    return run


def test_events_come_back_in_order(database):
    log = RunLog(database)
    events = (
        Planned(("W2", "W1"), "the run begins"),
        WHOLE,
        OperationEnded("W1", JAM),
        TaskEnded("W1", "failed", 3.0, False, ("/a > failed",), ("W1.jpg",)),
        DECIDED,
        Interrupted("killed"),
    )
    run = keep(log, *events)
    assert [kept.event for kept in log.events(run)] == [BEGUN, *events]


def test_tables_made_for_questions_follow(database, url):
    log = RunLog(database)
    keep(
        log,
        Planned(("W1", "W2"), ""),
        WHOLE,
        OperationEnded("W1", JAM),
        TaskEnded("W1", "failed", 3.0, False),
        DECIDED,
    )
    assert rows(url, "SELECT outcome, attempt, ended_s FROM executions") == [("failed", 1, 3.0)]
    assert rows(url, "SELECT ability, error_code, goal_id FROM ability_records") == [
        ("InsertCable", 301, "g1")
    ]
    assert rows(url, "SELECT fault, response FROM decisions") == [("insertion_jammed", "set_aside")]
    assert rows(url, "SELECT state FROM tasks ORDER BY id") == [("set aside",), ("open",)]


def test_an_interrupted_behavior_keeps_its_operations(database, url):
    keep(
        RunLog(database),
        Planned(("W1", "W2"), ""),
        WHOLE,
        OperationEnded("W1", JAM),
        Interrupted(""),
    )
    assert rows(url, "SELECT outcome, ended_s FROM executions") == [("interrupted", 2.0)]
    assert len(database.ability_calls()) == 1


def test_a_call_is_told_with_its_parameters_and_what_it_depends_on(database):
    here = (("component_id", "Q1"), ("terminal_id", "B1"), ("force_limit", "8.0"))
    there = (("component_id", "Q9"), ("terminal_id", "B1"))
    calls = [replace(JAM, parameters=parameters) for parameters in (here, there)]
    keep(
        RunLog(database),
        Planned(("W1", "W2"), ""),
        WHOLE,
        *(OperationEnded("W1", call) for call in calls),
        TaskEnded("W1", "failed", 3.0, False),
    )
    known, unknown = database.ability_calls()
    assert known.parameters == {"force_limit": 8.0}
    assert known.features["terminal_type"] == "fuse"
    assert "terminal_type" not in unknown.features
    assert known.features["section_mm2"] == HOUSE.wires[0].section_mm2


def test_an_answer_is_told_once_it_is_known_whether_it_helped(database):
    log = RunLog(database)
    jammed = (OperationEnded("W1", JAM), TaskEnded("W1", "failed", 3.0, False))
    retried = replace(DECIDED, do=Do.RETRY)
    renewed = replace(DECIDED, do=Do.NEW_PART)
    again, third = (replace(WHOLE, attempt=number) for number in (2, 3))
    cleared = replace(WHOLE, part=Part.CLEAR), TaskEnded("W1", "finished", 4.0, False)
    failing = (Planned(("W1", "W2"), ""), WHOLE, *jammed, retried, again, *jammed, renewed)
    keep(log, *failing, *cleared)
    assert log.tried_responses() == (TriedResponse("insertion_jammed", Do.RETRY, helped=False),)
    keep(log, *failing, third, TaskEnded("W1", "finished", 5.0, True))
    assert log.tried_responses()[1:] == (
        TriedResponse("insertion_jammed", Do.RETRY, helped=False),
        TriedResponse("insertion_jammed", Do.NEW_PART, helped=True),
    )


def test_a_run_that_was_cut_short_is_found_until_it_has_ended(database):
    log = RunLog(database)
    run = keep(log)
    assert (log.unfinished("cell"), log.unfinished("other")) == (run, None)
    log.append(run, RunEnded(Ending.STOPPED, "x"), state_after([BEGUN]))
    assert log.unfinished("cell") is None
    assert [(head.number, head.order, head.ended) for head in log.heads()] == [(run, "house", True)]


def test_a_database_that_is_gone_counts_as_lost(tmp_path):
    database = ProductionDatabase(f"sqlite:///{tmp_path}/production.sqlite")
    database.add_order(HOUSE)
    log = RunLog(database)
    run = keep(log)
    with database.transaction() as session:
        session.execute(text("DROP TABLE run_events"))
    with pytest.raises(LostError, match="the production database does not answer: "):
        log.append(run, Interrupted("killed"), state_after([BEGUN]))
    database.close()


def test_a_run_without_a_record_is_told_with_those_there_are(database):
    log = RunLog(database)
    keep(log)
    with pytest.raises(OrderError, match="there is no record of run 7; there are 1"):
        log.events(7)


def test_an_order_done_again_begins_from_nothing_but_not_beside_others(database, url):
    log = RunLog(database)
    run = keep(log, Planned(("W1", "W2"), ""), WHOLE, TaskEnded("W1", "finished", 2.0, True))
    other = RunBegun("house", "switchgear", "other", ("W1", "W2"))
    with pytest.raises(OrderError, match="cannot be done again: cell cell works on it"):
        log.begin(other, again=True)
    log.append(run, RunEnded(Ending.STOPPED, ""), state_after([BEGUN]))
    log.begin(other)
    assert rows(url, "SELECT state FROM tasks ORDER BY id") == [("done",), ("open",)]
    log.append(2, RunEnded(Ending.STOPPED, ""), state_after([other]))
    log.begin(BEGUN, again=True)
    assert rows(url, "SELECT state FROM tasks ORDER BY id") == [("open",), ("open",)]


def test_a_task_is_one_cells_until_its_lease_runs_out(database):
    mine = TaskLeases(database, "house", "mine", 0.3)
    other = TaskLeases(database, "house", "other", 30.0)
    assert mine.claim("W1").holding is Holding.MINE
    taken = other.claim("W1")
    assert (taken.holding, taken.cell) == (Holding.ELSEWHERE, "mine")
    assert mine.renew("W1")
    wait_until(lambda: other.claim("W1").holding is Holding.MINE_IN_DOUBT)
    assert not mine.renew("W1")
    other.give_back("W1")
    assert mine.claim("W1").holding is Holding.MINE
    with pytest.raises(OrderError, match="order house has no task W9"):
        mine.claim("W9")


def wait_until(holds):
    end = time.monotonic() + 20.0
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.01)


MANY = 24


def long_order():
    """An order of many wires, each between two terminals of its own."""
    tops = tuple(Terminal(f"T{i}", Side.TOP) for i in range(MANY))
    bottoms = tuple(Terminal(f"B{i}", Side.BOTTOM) for i in range(MANY))
    wires = tuple(
        Wire(f"W{i}", TerminalRef("Q1", f"B{i}"), TerminalRef("Q2", f"T{i}"), "BU", 1.5, "")
        for i in range(MANY)
    )
    return Order("long", "", "", (Component("Q1", "", bottoms), Component("Q2", "", tops)), wires)


@pytest.mark.parametrize("cells", [2, 8])
def test_cells_share_an_order_and_one_that_dies_loses_nothing(url, cells):
    """Each cell does tasks in threads of its own; the first dies holding one."""
    database = ProductionDatabase(url)
    database.add_order(long_order())
    done, lock = Counter(), threading.Lock()
    dead = TaskLeases(database, "long", "dead", 0.5)
    assert dead.claim("W3").holding is Holding.MINE
    names = [f"W{i}" for i in range(MANY)]

    def work(cell):
        own = ProductionDatabase(url)
        leases, log = TaskLeases(own, "long", cell, 30.0), RunLog(own)
        begun = RunBegun("long", "switchgear", cell, tuple(names))
        run, state = log.begin(begun), state_after([begun])
        end = time.monotonic() + 60.0
        left = list(names)
        while left:
            assert time.monotonic() < end
            for name in list(left):
                holding = leases.claim(name).holding
                if holding is Holding.ELSEWHERE:
                    continue
                left.remove(name)
                if holding is Holding.DONE:
                    continue
                assert (holding is Holding.MINE_IN_DOUBT) == (name == "W3")
                with lock:
                    done[name] += 1
                begin = TaskBegun(name, 1, Part.WHOLE, name, "", 0.0)
                for event in (begin, TaskEnded(name, "finished", 1.0, True)):
                    state = log.append(run, event, state)
        own.close()

    threads = [threading.Thread(target=work, args=(f"cell_{i}",)) for i in range(cells)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(90.0)
    assert not any(thread.is_alive() for thread in threads)
    assert done == Counter(dict.fromkeys(names, 1))
    database.close()
