"""Orders go into the database and come back equal."""

import pytest
from sqlalchemy import create_engine, text

from remodel_planner.core.production import Component, Order, Side, Terminal, TerminalRef, Wire
from remodel_planner.core.run import Execution, Operation
from remodel_planner.edge.production_database import ProductionDatabase
from remodel_planner.errors import OrderError

ORDER = Order(
    "house",
    "A house",
    "house.qet",
    (
        Component("Q1", "breaker", (Terminal("B1", Side.BOTTOM), Terminal("B2", Side.BOTTOM))),
        Component("Q2", "switch", (Terminal("T1", Side.TOP), Terminal("T2", Side.TOP))),
    ),
    (
        Wire("W1", TerminalRef("Q1", "B1"), TerminalRef("Q2", "T1"), "BU", 1.5, "line 1"),
        Wire("W2", TerminalRef("Q1", "B2"), TerminalRef("Q2", "T2"), "BK", 2.5, "line 2"),
    ),
    ("a guess",),
)


@pytest.fixture
def url(tmp_path):
    return f"sqlite:///{tmp_path}/production.sqlite"


@pytest.fixture
def database(url):
    database = ProductionDatabase(url)
    yield database
    database.close()


def rows(url, query):
    engine = create_engine(url)
    with engine.connect() as connection:
        found = [tuple(row) for row in connection.execute(text(query))]
    engine.dispose()
    return found


def test_an_order_comes_back_equal(database):
    database.add_order(ORDER)
    assert database.order("house") == ORDER


def test_an_order_survives_its_process(database, url):
    database.add_order(ORDER)
    database.close()
    again = ProductionDatabase(url)
    assert again.order("house") == ORDER
    again.close()


def test_a_second_order_of_the_same_name_is_refused_whole(database, url):
    database.add_order(ORDER)
    with pytest.raises(OrderError, match="an order house already"):
        database.add_order(ORDER)
    assert rows(url, "SELECT count(*) FROM wires") == [(2,)]


def test_an_unknown_order_is_refused_with_those_there_are(database):
    database.add_order(ORDER)
    with pytest.raises(OrderError, match="no order hosue; it has: house"):
        database.order("hosue")


def test_no_database_at_the_url_is_an_order_error():
    with pytest.raises(OrderError, match="unable to open database file"):
        ProductionDatabase("sqlite:////nonexistent/folder/production.sqlite")


def test_what_was_done_is_kept(database, url):
    database.add_order(ORDER)
    run = database.start_run(database.order("house").first(1))
    operation = Operation("/Connect a/InsertCable", "InsertCable", "failed", 301, "jam", 2.0, 1.0)
    database.add_execution(
        run, Execution("W1", "Place Wire W1", 2, "failed", False, 1.0, 3.0, (operation,))
    )
    assert rows(url, "SELECT outcome, placed, ended_s FROM executions") == [("failed", 0, 3.0)]
    assert rows(url, "SELECT state_path, error_code, text FROM ability_records") == [
        ("/Connect a/InsertCable", 301, "jam")
    ]


def test_the_first_wires_take_only_the_terminals_they_need():
    first = ORDER.first(1)
    assert [wire.name for wire in first.wires] == ["W1"]
    assert [[t.name for t in c.terminals] for c in first.components] == [["B1"], ["T1"]]
