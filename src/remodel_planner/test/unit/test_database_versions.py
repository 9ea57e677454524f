"""Databases of all versions become those of this program, with their rows."""

import json

import pytest
from alembic import command
from alembic.autogenerate import compare_metadata
from alembic.config import Config
from alembic.migration import MigrationContext
from alembic.script import ScriptDirectory
from house import owner_of
from sqlalchemy import create_engine, inspect, text

from remodel_planner.core.production import Component, Side, Terminal, TerminalRef, Wire
from remodel_planner.core.run import Operation
from remodel_planner.core.supervision.event_form import data_of, kind_of
from remodel_planner.core.supervision.events import (
    Interrupted,
    OperationEnded,
    Part,
    Planned,
    RunBegun,
    TaskBegun,
)
from remodel_planner.core.supervision.fold import state_after
from remodel_planner.edge import database_versions
from remodel_planner.edge.production_database import ProductionDatabase
from remodel_planner.edge.production_models import Base
from remodel_planner.edge.run_log import RunLog
from remodel_planner.errors import OrderError

# What databases were before they had versions.
UNVERSIONED = """
CREATE TABLE orders (id INTEGER NOT NULL PRIMARY KEY, name VARCHAR NOT NULL UNIQUE,
  title VARCHAR NOT NULL, source VARCHAR NOT NULL);
CREATE TABLE components (id INTEGER NOT NULL PRIMARY KEY,
  order_id INTEGER NOT NULL REFERENCES orders, name VARCHAR NOT NULL,
  kind VARCHAR NOT NULL, UNIQUE (order_id, name));
CREATE TABLE notes (id INTEGER NOT NULL PRIMARY KEY, order_id INTEGER NOT NULL REFERENCES orders,
  text VARCHAR NOT NULL);
CREATE TABLE runs (id INTEGER NOT NULL PRIMARY KEY, order_id INTEGER NOT NULL REFERENCES orders,
  started TIMESTAMP NOT NULL);
CREATE TABLE terminals (id INTEGER NOT NULL PRIMARY KEY,
  component_id INTEGER NOT NULL REFERENCES components, name VARCHAR NOT NULL, side VARCHAR NOT NULL,
  point VARCHAR NOT NULL, UNIQUE (component_id, name));
CREATE TABLE wires (id INTEGER NOT NULL PRIMARY KEY, order_id INTEGER NOT NULL REFERENCES orders,
  name VARCHAR NOT NULL, a_terminal_id INTEGER NOT NULL UNIQUE REFERENCES terminals,
  b_terminal_id INTEGER NOT NULL UNIQUE REFERENCES terminals, colour VARCHAR NOT NULL,
  section_mm2 FLOAT NOT NULL, source VARCHAR NOT NULL, UNIQUE (order_id, name));
CREATE TABLE executions (id INTEGER NOT NULL PRIMARY KEY, run_id INTEGER NOT NULL REFERENCES runs,
  wire_id INTEGER NOT NULL REFERENCES wires, behavior VARCHAR NOT NULL, attempt INTEGER NOT NULL,
  outcome VARCHAR NOT NULL, placed BOOLEAN NOT NULL, started_s FLOAT NOT NULL,
  ended_s FLOAT NOT NULL);
CREATE TABLE ability_records (id INTEGER NOT NULL PRIMARY KEY,
  execution_id INTEGER NOT NULL REFERENCES executions, state_path VARCHAR NOT NULL,
  ability VARCHAR NOT NULL, outcome VARCHAR NOT NULL, error_code INTEGER NOT NULL,
  text VARCHAR NOT NULL, ended_s FLOAT NOT NULL, elapsed_s FLOAT NOT NULL);
INSERT INTO orders VALUES (7, 'house', 'A house', 'house.qet');
INSERT INTO components VALUES (3, 7, 'Q1', 'breaker'), (4, 7, 'Q2', 'switch');
INSERT INTO terminals VALUES (10, 3, 'B1', 'bottom', ''), (11, 4, 'T1', 'top', ''),
  (12, 3, 'B2', 'bottom', ''), (13, 4, 'T2', 'top', '');
INSERT INTO wires VALUES (20, 7, 'W1', 10, 11, 'BU', 1.5, 'line 1'),
  (21, 7, 'W2', 12, 13, 'BK', 2.5, 'line 2');
INSERT INTO notes VALUES (30, 7, 'a guess');
INSERT INTO runs VALUES (40, 7, '2026-01-02 03:04:05');
INSERT INTO executions VALUES (50, 40, 20, 'Place Wire W1', 1, 'failed', false, 1.0, 2.0),
  (51, 40, 20, 'Place Wire W1', 2, 'finished', true, 2.0, 3.0);
INSERT INTO ability_records VALUES
  (60, 51, '/InsertCable', 'InsertCable', 'inserted', 0, '', 3.0, 1.0);
"""


def execute(url, *statements):
    """Execute statements, and return the rows of the last one."""
    engine = create_engine(url)
    with engine.begin() as connection:
        for statement in statements:
            result = connection.execute(text(statement))
        rows = [tuple(row) for row in result] if result.returns_rows else []
    engine.dispose()
    return rows


def open_and_close(url):
    ProductionDatabase(url).close()


def test_the_migrations_make_what_the_models_say(url):
    open_and_close(url)
    engine = create_engine(url)
    with engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        assert compare_metadata(context, Base.metadata) == []
        checks = {
            table: {check["name"] for check in inspect(connection).get_check_constraints(table)}
            for table in Base.metadata.tables
        }
    engine.dispose()
    assert "ck_clips_place" in checks["clips"]
    assert "ck_wires_section" in checks["wires"]


def test_the_newest_version_is_that_of_the_last_migration():
    config = Config()
    folder = database_versions.__file__.replace("database_versions.py", "migrations")
    config.set_main_option("script_location", folder)
    assert ScriptDirectory.from_config(config).get_current_head() == database_versions.NEWEST


def test_an_unversioned_database_keeps_its_orders_and_records(url):
    execute(url, *filter(str.strip, UNVERSIONED.split(";")))
    database = ProductionDatabase(url)
    order = database.order("house")
    assert order.components == (
        Component("Q1", "breaker", (Terminal("B1", Side.BOTTOM), Terminal("B2", Side.BOTTOM))),
        Component("Q2", "switch", (Terminal("T1", Side.TOP), Terminal("T2", Side.TOP))),
    )
    assert order.wires == (
        Wire("W1", TerminalRef("Q1", "B1"), TerminalRef("Q2", "T1"), "BU", 1.5, "line 1"),
        Wire("W2", TerminalRef("Q1", "B2"), TerminalRef("Q2", "T2"), "BK", 2.5, "line 2"),
    )
    assert (order.title, order.source, order.notes) == ("A house", "house.qet", ("a guess",))
    states = execute(url, "SELECT w.name, t.state FROM tasks t JOIN wires w ON w.id = t.wire_id")
    assert sorted(states) == [("W1", "done"), ("W2", "open")]
    assert execute(
        url,
        "SELECT w.name, e.attempt, r.ability FROM ability_records r"
        " JOIN executions e ON e.id = r.execution_id JOIN tasks t ON t.id = e.task_id"
        " JOIN wires w ON w.id = t.wire_id",
    ) == [("W1", 2, "InsertCable")]
    begun = RunBegun("house", "switchgear", "cell", ("W1", "W2"))
    run, completed = RunLog(database).begin(begun, owner_of(database))
    assert (run, completed.serial) == (41, "house-0001")
    database.close()
    assert execute(url, "SELECT max(id) FROM runs") == [(41,)]


def test_a_database_of_a_newer_program_is_refused_and_left_alone(url):
    open_and_close(url)
    execute(url, "UPDATE alembic_version SET version_num = '0999'")
    with pytest.raises(
        OrderError, match=r"is of version 0999; .* versions 0001, 0002, 0003, 0004, 0005, 0006"
    ):
        ProductionDatabase(url)
    assert execute(url, "SELECT version_num FROM alembic_version") == [("0999",)]


def test_a_migration_that_fails_changes_nothing(url):
    statements = [*filter(str.strip, UNVERSIONED.split(";"))]
    # No order has this number, so that the new rows cannot refer to it.
    orphan = "INSERT INTO notes VALUES (31, 8, 'an orphan')"
    unchecked = [s.replace(" REFERENCES orders", "") for s in statements]
    execute(url, *unchecked, orphan)
    with pytest.raises(OrderError):
        ProductionDatabase(url)
    assert execute(url, "SELECT count(*) FROM notes WHERE order_id = 7") == [(1,)]


def test_an_open_database_is_opened_again_without_migrating(url, monkeypatch):
    open_and_close(url)
    monkeypatch.setattr("remodel_planner.edge.production_database.upgrade", None)
    open_and_close(url)


def test_every_table_and_column_has_a_comment():
    for table in Base.metadata.tables.values():
        assert table.comment, table.name
        assert all(column.comment for column in table.columns), table.name


def upgrade_to(url, revision):
    """Bring a new database to an older version."""
    engine = create_engine(url)
    with engine.begin() as connection:
        config = Config()
        folder = database_versions.__file__.replace("database_versions.py", "migrations")
        config.set_main_option("script_location", folder)
        config.attributes["connection"] = connection
        command.upgrade(config, revision)
    engine.dispose()


# A run of version 0004 that was cut short, of an order of version 0001's design.
RUN = """
INSERT INTO products VALUES (1, '', 'house.qet');
INSERT INTO components (id, product_id, name, kind, role, part_number, mount) VALUES
  (3, 1, 'Q1', 'fuse', 'device', '', 'plate'), (4, 1, 'Q2', 'relay', 'device', '', 'plate');
INSERT INTO terminals (id, component_id, name, side, point, kind) VALUES
  (10, 3, 'B1', 'bottom', '', ''), (11, 4, 'T1', 'top', '', '');
INSERT INTO wires (id, product_id, name, a_terminal_id, b_terminal_id, colour, section_mm2, core,
  source) VALUES (20, 1, 'W1', 10, 11, 'BU', 1.5, '', 'line 1');
INSERT INTO orders VALUES (1, 'house', 1);
INSERT INTO tasks VALUES (5, 1, 20, 'begun', 'cell', NULL);
INSERT INTO runs VALUES (1, 1, '2026-01-02 03:04:05', 'cell', false);
INSERT INTO executions VALUES (50, 1, 5, 'Place Wire W1', 1, 'interrupted', false, 1.0, 2.0);
INSERT INTO ability_records (id, execution_id, state_path, ability, outcome, error_code, text,
  ended_s, elapsed_s, goal_id, parameters, measurements) VALUES (60, 50, '/a', 'InsertCable',
  'failed', 301, 'jam', 2.0, 1.0, 'g1', '[["force_limit", "8.0"]]', '[["depth", "0.004"]]');
"""


def test_runs_of_version_4_keep_their_events_and_records(url):
    upgrade_to(url, "0004")
    execute(url, *filter(str.strip, RUN.split(";")))
    jam = Operation("/a", "InsertCable", "failed", 301, "jam", 2.0, 1.0, "g1")
    events = (
        RunBegun("house", "switchgear", "cell", ("W1",)),
        Planned(("W1",), "the run begins"),
        TaskBegun("W1", 1, Part.WHOLE, "Place Wire W1", "<chart>Ü</chart>", 1.0),
        OperationEnded("W1", jam),
        Interrupted("killed"),
        TaskBegun("W1", 1, Part.CLEAR, "Place Wire W1 Clear", "<chart>Ü</chart>", 3.0),
    )
    engine = create_engine(url)
    with engine.begin() as connection:
        add = text(
            "INSERT INTO run_events (run_id, position, at, kind, data) "
            "VALUES (1, :position, '2026-01-02 03:04:05', :kind, :data)"
        )
        for position, event in enumerate(events):
            data = json.dumps(data_of(event))
            connection.execute(add, {"position": position, "kind": kind_of(event), "data": data})
    engine.dispose()

    database = ProductionDatabase(url)
    log, owner = RunLog(database), owner_of(database)
    assert [kept.event for kept in log.events(1)] == list(events)
    assert log.state(1) == state_after(events)
    (call,) = database.ability_calls()
    assert (call.ability, call.parameters) == ("InsertCable", {"force_limit": 8.0})
    assert execute(url, "SELECT count(*) FROM charts") == [(1,)]
    log.take_up(1, owner)
    log.append(1, Interrupted("again"), log.state(1), owner)
    assert [kept.event for kept in log.events(1, 5)] == [events[5], Interrupted("again")]
    database.close()
