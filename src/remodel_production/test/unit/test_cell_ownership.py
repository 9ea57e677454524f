"""One supervisor at a time owns a cell; others are refused with its name, or wait for its lease."""

import threading

import pytest
from sqlalchemy import text

from remodel_production.edge.database.cell_ownership import (
    CellOwnership,
    LiveOwner,
    Owned,
    Refused,
    database_time_s,
    live_owners,
)
from remodel_production.edge.database.production_database import ProductionDatabase


@pytest.fixture
def stations(database):
    """Return the ownership of one cell from two stations."""
    return tuple(
        CellOwnership(database, "cell", station, f"host {station}, pid 7", lease_s=30.0)
        for station in ("a", "b")
    )


def run_out(database):
    """Let the lease on every cell run out."""
    with database.transaction() as connection:
        connection.execute(
            text(f"UPDATE cells SET lease_until = {database_time_s(connection) - 0.1}")
        )


def test_the_second_station_is_refused_with_the_firsts_name(stations, database):
    first, second = stations
    assert first.acquire() == Owned(1)
    refused = second.acquire()
    assert isinstance(refused, Refused)
    assert refused.holder == "host a, pid 7"
    assert 25.0 < refused.left_s <= 30.0
    (owner,) = live_owners(database)
    assert owner == LiveOwner("cell", "host a, pid 7", owner.left_s)
    assert first.renew(1)


def test_a_station_takes_over_from_itself_at_once(stations):
    first, _ = stations
    assert [first.acquire(), first.acquire()] == [Owned(1), Owned(2)]
    assert not first.renew(1)
    assert first.renew(2)


def test_a_station_takes_over_when_the_lease_has_run_out(stations, database):
    first, second = stations
    first.acquire()
    run_out(database)
    assert first.renew(1), "no other supervisor has taken the cell over yet"
    run_out(database)
    assert live_owners(database) == ()
    assert second.acquire() == Owned(2)
    assert not first.renew(1)
    assert isinstance(first.acquire(), Refused)


def test_a_released_cell_is_free_at_once_and_not_renewed(stations):
    first, second = stations
    first.acquire()
    first.release(1)
    assert not first.renew(1)
    assert second.acquire() == Owned(2)
    first.release(1)
    assert second.renew(2), "an earlier owner cannot release the cell"


def test_cells_have_owners_of_their_own(stations, database):
    stations[0].acquire()
    other = CellOwnership(database, "other", "b", "host b", lease_s=30.0)
    assert other.acquire() == Owned(1)
    assert [owner.cell for owner in live_owners(database)] == ["cell", "other"]


def test_of_stations_that_come_at_once_one_gets_the_cell(url):
    ProductionDatabase(url).close()
    start, answers = threading.Barrier(4), []

    def acquire(station):
        database = ProductionDatabase(url)
        ownership = CellOwnership(database, "cell", station, station, lease_s=30.0)
        start.wait(20.0)
        answers.append(ownership.acquire())
        database.close()

    threads = [threading.Thread(target=acquire, args=(f"s{i}",)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60.0)
    assert [answer for answer in answers if isinstance(answer, Owned)] == [Owned(1)]
    assert sum(isinstance(answer, Refused) for answer in answers) == 3
