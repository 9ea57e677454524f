"""What happens in runs is kept event by event, and several cells never do one task twice."""

import threading
import time
from collections import Counter
from dataclasses import replace

import pytest
from databases import execute
from house import HOUSE, owner_of
from long_run import long_order
from sqlalchemy import text

from remodel_production.edge.database import production_database
from remodel_production.edge.database.cell_ownership import database_time_s
from remodel_production.edge.database.production_database import (
    ProductionDatabase,
    keep_rehearsal,
    last_rehearsal,
)
from remodel_production.errors import LostError, OrderError, OwnerError, RecordLostError
from remodel_run.rehearsal import Forecast, Rehearsal, RehearsedCall, Trial
from remodel_supervision.core.learning.experience import REHEARSED_WEIGHT, TriedResponse
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import (
    AsLeft,
    Command,
    Commanded,
    Decided,
    Ending,
    Interrupted,
    OperationEnded,
    PanelLoaded,
    Part,
    Planned,
    RunBegun,
    RunEnded,
    TaskBegun,
    TaskElsewhere,
    TaskEnded,
)
from remodel_supervision.edge.recorded_lessons import ability_calls
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.edge.task_leases import Holding, TaskLeases
from remodel_tasks.core.use_case.fault import Do

BEGUN = RunBegun("house", "cabinet", "cell", ("W1", "W2"))
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


def product(begun, number, *, keep_panel=False):
    """Return the beginning of a run of one of the order's products."""
    return replace(begun, serial=f"house-{number:04d}", keep_panel=keep_panel)


@pytest.fixture
def owner(database):
    """Return the token of the owner of the cell that does the runs."""
    return owner_of(database)


@pytest.fixture
def log(database):
    return RunLog(database)


@pytest.fixture
def keep(log, owner):
    """Return a function that keeps a run of some events, and returns its number."""

    def keep(*events):
        run, _ = log.begin(BEGUN, owner)
        state = state_after([BEGUN])
        for event in events:
            state = log.append(run, event, state, owner)
        return run

    return keep


def test_events_come_back_in_order(keep, log):
    events = (
        Planned(("W2", "W1"), "the run begins"),
        WHOLE,
        OperationEnded("W1", JAM),
        TaskEnded("W1", "failed", 3.0, False, ("/a > failed",), ("W1.jpg",)),
        DECIDED,
        Interrupted("killed"),
    )
    run = keep(*events)
    begun = replace(BEGUN, serial="house-0001")
    assert [kept.event for kept in log.events(run)] == [begun, *events]


def test_tables_made_for_questions_follow(keep, url):
    keep(
        Planned(("W1", "W2"), ""),
        WHOLE,
        OperationEnded("W1", JAM),
        TaskEnded("W1", "failed", 3.0, False),
        DECIDED,
    )
    assert execute(url, "SELECT outcome, attempt, ended_s FROM executions") == [("failed", 1, 3.0)]
    assert execute(url, "SELECT ability, error_code, position FROM ability_records") == [
        ("InsertCable", 301, 3)
    ]
    assert execute(url, "SELECT fault, response FROM decisions") == [
        ("insertion_jammed", "set_aside")
    ]
    assert execute(url, "SELECT state FROM tasks ORDER BY id") == [("set aside",), ("open",)]


def test_an_interrupted_behavior_keeps_its_operations(keep, database, url):
    keep(Planned(("W1", "W2"), ""), WHOLE, OperationEnded("W1", JAM), Interrupted(""))
    assert execute(url, "SELECT outcome, ended_s FROM executions") == [("interrupted", 2.0)]
    assert len(ability_calls(database)) == 1


def test_a_call_is_returned_with_its_parameters_and_what_it_depends_on(keep, database):
    here = (("component_id", "Q1"), ("terminal_id", "B1"), ("force_limit", "8.0"))
    there = (("component_id", "Q9"), ("terminal_id", "B1"))
    calls = [replace(JAM, parameters=parameters) for parameters in (here, there)]
    keep(
        Planned(("W1", "W2"), ""),
        WHOLE,
        *(OperationEnded("W1", call) for call in calls),
        TaskEnded("W1", "failed", 3.0, False),
    )
    known, unknown = ability_calls(database)
    assert known.parameters == {"force_limit": 8.0}
    assert known.features["terminal_type"] == "fuse"
    assert "terminal_type" not in unknown.features
    assert known.features["section_mm2"] == HOUSE.wires[0].section_mm2


def test_calls_of_the_newest_rehearsal_come_before_the_recorded_and_count_less(keep, database):
    def rehearsal(code):
        call = RehearsedCall("InsertCable", {"section_mm2": 1.5}, code, 4.0, {"force_limit": 8.0})
        found = Forecast((), 1.0, (0.0, 0.0, 0.0))
        return Rehearsal("cell", ("W1",), (Trial("W1", 3, True, 1),), (call,), found)

    keep_rehearsal(database, HOUSE.name, rehearsal(0))
    keep_rehearsal(database, HOUSE.name, rehearsal(301))
    keep(Planned(("W1", "W2"), ""), WHOLE, OperationEnded("W1", JAM), Interrupted(""))
    first, second = ability_calls(database)
    assert (first.error_code, first.weight) == (301, REHEARSED_WEIGHT)
    assert first.parameters == {"force_limit": 8.0}
    assert second.weight == 1.0
    assert last_rehearsal(database, HOUSE.name) == rehearsal(301)


def test_a_response_is_returned_once_it_is_known_whether_it_helped(keep, log):
    jammed = (OperationEnded("W1", JAM), TaskEnded("W1", "failed", 3.0, False))
    retried = replace(DECIDED, do=Do.RETRY)
    renewed = replace(DECIDED, do=Do.NEW_PART)
    again, third = (replace(WHOLE, attempt=number) for number in (2, 3))
    cleared = replace(WHOLE, part=Part.CLEAR), TaskEnded("W1", "finished", 4.0, False)
    failing = (Planned(("W1", "W2"), ""), WHOLE, *jammed, retried, again, *jammed, renewed)
    keep(*failing, *cleared)
    assert log.tried_responses() == (TriedResponse("insertion_jammed", Do.RETRY, helped=False),)
    keep(*failing, third, TaskEnded("W1", "finished", 5.0, True))
    assert log.tried_responses()[1:] == (
        TriedResponse("insertion_jammed", Do.RETRY, helped=False),
        TriedResponse("insertion_jammed", Do.NEW_PART, helped=True),
    )


def test_a_run_that_was_cut_short_is_found_until_it_has_ended(keep, log, owner):
    run = keep()
    assert (log.unfinished("cell"), log.unfinished("other")) == (run, None)
    log.append(run, RunEnded(Ending.STOPPED, "x"), state_after([BEGUN]), owner)
    assert log.unfinished("cell") is None
    assert [(head.number, head.order, head.ended) for head in log.heads()] == [(run, "house", True)]
    with pytest.raises(OwnerError, match="run 1 has ended: nothing can be added to it"):
        log.append(run, Interrupted("late"), state_after([BEGUN]), owner)


def test_a_run_without_a_record_is_reported_with_those_there_are(keep, log):
    keep()
    with pytest.raises(OrderError, match="there is no record of run 7; there are 1"):
        log.events(7)


def test_an_order_done_again_begins_from_nothing_but_not_beside_others(
    keep, log, owner, database, url
):
    run = keep(Planned(("W1", "W2"), ""), WHOLE, TaskEnded("W1", "finished", 2.0, True))
    other = RunBegun("house", "cabinet", "other", ("W1", "W2"))
    other_owner = owner_of(database, "other", "another station")
    with pytest.raises(OrderError, match="cannot be done again: cell cell works on it"):
        log.begin(other, other_owner, again=True)
    log.append(run, RunEnded(Ending.STOPPED, ""), log.state(run), owner)
    begun = replace(product(other, 1, keep_panel=True), done=("W1",))
    assert log.begin(other, other_owner) == (2, begun)
    assert execute(url, "SELECT state FROM tasks ORDER BY id") == [("done",), ("open",)]
    log.append(2, RunEnded(Ending.STOPPED, ""), log.state(2), other_owner)
    assert log.begin(BEGUN, owner, again=True) == (3, product(BEGUN, 2))
    assert execute(url, "SELECT state FROM tasks ORDER BY id") == [("open",), ("open",)]
    assert next(iter(log.events(3))).event.serial == "house-0002"


def test_cells_that_share_an_order_wire_the_same_product(log, owner, database):
    other = replace(BEGUN, cell="other")
    assert log.begin(BEGUN, owner) == (1, product(BEGUN, 1))
    second = log.begin(other, owner_of(database, "other", "b"))
    assert second == (2, product(other, 1, keep_panel=True))


def test_an_owner_that_was_replaced_adds_nothing_to_its_run(keep, log, owner, database, url):
    run = keep()
    newer = owner_of(database)
    with pytest.raises(
        OwnerError, match=r"cell cell is owned by another .* \(token 2; this one ha"
    ):
        log.append(run, Interrupted("late"), state_after([BEGUN]), owner)
    with pytest.raises(OwnerError, match=r"belongs to another owner .*: take it up first"):
        log.append(run, Interrupted("early"), state_after([BEGUN]), newer)
    with pytest.raises(OwnerError, match="owned by another supervisor now: supervisor at station"):
        log.take_up(run, owner)
    with pytest.raises(OwnerError, match="owned by another"):
        log.begin(BEGUN, owner)
    assert execute(url, "SELECT count(*) FROM run_events") == [(1,)]
    log.take_up(run, newer)
    log.append(run, Interrupted("resumed"), state_after([BEGUN]), newer)
    assert execute(url, "SELECT position, kind FROM run_events ORDER BY id") == [
        (0, "RunBegun"),
        (1, "Interrupted"),
    ]


def test_only_a_run_that_has_not_ended_is_taken_up(keep, log, owner):
    run = keep(RunEnded(Ending.STOPPED, ""))
    with pytest.raises(OwnerError, match="run 1 has ended"):
        log.take_up(run, owner)
    with pytest.raises(RecordLostError, match="no longer has run 7; restore a backup"):
        log.take_up(7, owner)


def test_a_task_that_another_cell_ends_stays_its_own(keep, url):
    keep(Planned(("W1", "W2"), ""), TaskElsewhere("W1", "other", AsLeft.DONE))
    assert execute(url, "SELECT state, cell FROM tasks ORDER BY id") == [("open", ""), ("open", "")]


def test_a_task_that_is_retried_can_be_claimed(keep, database, owner):
    skip, retry = (Commanded(each, "W1", "ann") for each in (Command.SKIP, Command.RETRY))
    leases = TaskLeases(database, "house", "cell", 30.0, owner)
    keep(Planned(("W1", "W2"), ""), skip)
    assert leases.claim("W1").holding is Holding.SET_ASIDE
    keep(Planned(("W1", "W2"), ""), skip, retry)
    assert leases.claim("W1").holding is Holding.MINE_UNVERIFIED


def test_a_task_that_another_cell_has_taken_over_is_not_ended_for_it(keep, database, url):
    leases = TaskLeases(database, "house", "other", 30.0, owner_of(database, "other", "b"))
    leases.claim("W1")
    keep(Planned(("W1", "W2"), ""), WHOLE, TaskEnded("W1", "finished", 2.0, True))
    assert execute(url, "SELECT state, cell FROM tasks ORDER BY id")[0] == ("begun", "other")


@pytest.mark.parametrize(
    ("damage", "reported"),
    [
        ("DELETE FROM runs", "no longer has run 1; restore a backup"),
        ("DELETE FROM tasks", "no longer has task W1 of run 1; restore a backup"),
        ("DROP TABLE run_events", "cannot be used: .*run_events.*; restore a backup"),
    ],
)
def test_rows_and_tables_that_are_gone_are_reported(keep, log, owner, database, damage, reported):
    run = keep(Planned(("W1", "W2"), ""), WHOLE)
    with database.transaction() as connection:
        connection.execute(text(damage))
    state = state_after([BEGUN, Planned(("W1", "W2"), ""), WHOLE])
    with pytest.raises(RecordLostError, match=reported):
        log.append(run, TaskEnded("W1", "finished", 2.0, True), state, owner)


@pytest.fixture
def file(tmp_path):
    return tmp_path / "production.sqlite"


@pytest.fixture
def in_file(file):
    database = ProductionDatabase(f"sqlite:///{file}")
    database.add_order(HOUSE)
    yield database
    database.close()


def test_a_product_stays_on_the_panel_of_its_use_case(log, owner, keep):
    other = replace(BEGUN, use_case="own_cabinet")
    keep(RunEnded(Ending.STOPPED, "refused"))
    run, begun = log.begin(other, owner)
    assert begun == product(other, 1, keep_panel=True), "nothing was built for the other use case"
    state = log.append(run, PanelLoaded("house-0001"), state_after([begun]), owner)
    log.append(run, RunEnded(Ending.STOPPED, "ann stopped it"), state, owner)
    with pytest.raises(
        OrderError, match="begun by use case own_cabinet, asked for cabinet"
    ) as caught:
        log.begin(BEGUN, owner)
    assert "--again" in str(caught.value)
    assert log.begin(other, owner)[1].serial == "house-0001"
    assert log.begin(BEGUN, owner, again=True)[1] == product(BEGUN, 2)


def test_a_file_that_was_deleted_is_reported_and_not_made_again(in_file, file):
    log, owner = RunLog(in_file), owner_of(in_file)
    run, _ = log.begin(BEGUN, owner)
    for each in file.parent.glob("production.sqlite*"):
        each.unlink()
    with pytest.raises(RecordLostError, match=r"production\.sqlite is gone; restore a backup"):
        log.append(run, Interrupted("killed"), state_after([BEGUN]), owner)
    assert not file.exists()


def test_a_file_that_was_emptied_is_reported(in_file, file):
    log, owner = RunLog(in_file), owner_of(in_file)
    run, _ = log.begin(BEGUN, owner)
    file.write_bytes(b"")
    with pytest.raises(RecordLostError, match=r"production\.sqlite is empty; restore a backup"):
        log.append(run, Interrupted("killed"), state_after([BEGUN]), owner)


def test_a_file_that_was_damaged_is_reported(in_file, file):
    run, _ = RunLog(in_file).begin(BEGUN, owner_of(in_file))
    in_file.close()
    content = bytearray(file.read_bytes())
    content[4096:] = b"damaged " * ((len(content) - 4096) // 8)
    file.write_bytes(content)
    with pytest.raises(RecordLostError, match=r"cannot be used: .*malformed; restore a backup"):
        RunLog(in_file).state(run)


def test_a_file_that_was_put_in_place_of_the_database_is_used(in_file, file):
    log, owner = RunLog(in_file), owner_of(in_file)
    run, _ = log.begin(BEGUN, owner)
    in_file.close()
    copy = file.with_name("copy.sqlite")
    copy.write_bytes(file.read_bytes())
    log.append(run, Interrupted("killed"), state_after([BEGUN]), owner)
    for each in file.parent.glob("production.sqlite-*"):
        each.unlink()
    copy.replace(file)
    assert [kept.event for kept in log.events(run)] == [replace(BEGUN, serial="house-0001")]


def test_a_database_that_does_not_answer_counts_as_lost(in_file, monkeypatch):
    monkeypatch.setattr(production_database, "WAIT_S", 0)
    log, owner = RunLog(in_file), owner_of(in_file)
    with in_file.transaction() as connection:
        connection.execute(text("SELECT 1"))
        with pytest.raises(LostError, match="does not answer: database is locked"):
            log.begin(BEGUN, owner)


def test_a_task_is_one_cells_until_a_third_of_a_lease_after_it_ran_out(database):
    mine = TaskLeases(database, "house", "mine", 30.0, owner_of(database, "mine", "a"))
    other = TaskLeases(database, "house", "other", 30.0, owner_of(database, "other", "b"))
    assert mine.claim("W1").holding is Holding.MINE
    taken = other.claim("W1")
    assert (taken.holding, taken.cell) == (Holding.ELSEWHERE, "mine")
    assert mine.renew("W1")
    for since_s, holding in ((9.0, Holding.ELSEWHERE), (11.0, Holding.MINE_UNVERIFIED)):
        with database.transaction() as connection:
            until = database_time_s(connection) - since_s
            connection.execute(text(f"UPDATE tasks SET lease_until = {until} WHERE cell = 'mine'"))
        assert other.claim("W1").holding is holding
    assert not mine.renew("W1")
    other.give_back("W1")
    assert mine.claim("W1").holding is Holding.MINE
    with pytest.raises(OrderError, match="order house has no task W9"):
        mine.claim("W9")


def test_a_supervisor_that_was_replaced_neither_claims_nor_renews(database, url):
    old, new = (
        TaskLeases(database, "house", "cell", 30.0, owner_of(database, "cell")) for _ in range(2)
    )
    assert new.claim("W1").holding is Holding.MINE
    assert execute(url, "SELECT token FROM tasks ORDER BY id") == [(2,), (0,)]
    with pytest.raises(OwnerError, match=r"token 2; this one has 1"):
        old.claim("W2")
    assert not old.renew("W1")
    old.give_back("W1")
    assert new.renew("W1")


def test_a_restarted_supervisor_renews_the_task_of_its_predecessor(database, url):
    first = TaskLeases(database, "house", "cell", 30.0, owner_of(database, "cell"))
    first.claim("W1")
    second = TaskLeases(database, "house", "cell", 30.0, owner_of(database, "cell"))
    assert second.renew("W1")
    assert execute(url, "SELECT token FROM tasks ORDER BY id") == [(2,), (0,)]


LEASE_S = 60.0


@pytest.mark.parametrize("cells", [2, 8])
def test_cells_share_an_order_and_one_that_dies_loses_nothing(url, cells):
    """Each cell does tasks in threads of its own; the first dies holding one."""
    database = ProductionDatabase(url)
    order = long_order(24)
    database.add_order(order)
    done, lock = Counter(), threading.Lock()
    dead = TaskLeases(database, "long", "dead", LEASE_S, owner_of(database, "dead", "dead"))
    assert dead.claim("W3").holding is Holding.MINE
    # Others take its task over in a second, a third of a lease after this one has run out.
    before_s = 4 / 3 * LEASE_S - 1.0
    execute(url, f"UPDATE tasks SET lease_until = lease_until - {before_s} WHERE cell = 'dead'")
    names = [wire.name for wire in order.wires]

    def work(cell):
        own = ProductionDatabase(url)
        owner = owner_of(own, cell, cell)
        leases, log = TaskLeases(own, "long", cell, LEASE_S, owner), RunLog(own)
        begun = RunBegun("long", "cabinet", cell, tuple(names))
        (run, _), state = log.begin(begun, owner), state_after([begun])
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
                assert (holding is Holding.MINE_UNVERIFIED) == (name == "W3")
                with lock:
                    done[name] += 1
                begin = TaskBegun(name, 1, Part.WHOLE, name, "", 0.0)
                for event in (begin, TaskEnded(name, "finished", 1.0, True)):
                    state = log.append(run, event, state, owner)
        own.close()

    threads = [threading.Thread(target=work, args=(f"cell_{i}",)) for i in range(cells)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(90.0)
    assert not any(thread.is_alive() for thread in threads)
    assert done == Counter(dict.fromkeys(names, 1))
    database.close()
