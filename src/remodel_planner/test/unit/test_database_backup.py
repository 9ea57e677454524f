"""A backup holds the whole database; a restore replaces one only on request and when it is free."""

import shutil
import sqlite3
import subprocess
import threading

import pytest
from house import HOUSE, owner_of
from sqlalchemy import text

from remodel_planner.commands import backup, restore
from remodel_production.edge.database import database_backup
from remodel_production.edge.database.cell_ownership import CellOwnership
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_supervision.core.runs.event_table import state_after
from remodel_supervision.core.runs.events import Interrupted, RunBegun
from remodel_supervision.edge.run_log import RunLog

BEGUN = RunBegun("house", "cabinet", "cell", ("W1", "W2"))


@pytest.fixture
def database(url):
    database = ProductionDatabase(url)
    database.add_order(HOUSE)
    yield database
    database.close()


@pytest.fixture
def file(tmp_path):
    return tmp_path / "backup"


@pytest.fixture
def used(database):
    """Return the log of a database with a run, and the run's owner."""
    log, owner = RunLog(database), owner_of(database)
    log.begin(BEGUN, owner)
    return log, owner


def free(database):
    """Stop the supervisor."""
    CellOwnership(database, "cell", "station", "", lease_s=60.0).release(1)


def test_a_restored_database_is_that_of_the_backup(used, database, url, file, capsys):
    log, owner = used
    assert backup.main([str(file), "--database", url]) == 0
    log.append(1, Interrupted("after the backup"), state_after([BEGUN]), owner)
    free(database)
    assert restore.main([str(file), "--replace", "--database", url]) == 0
    assert "restored from" in capsys.readouterr().out
    again = ProductionDatabase(url)
    assert again.order("house") == HOUSE
    assert len(list(RunLog(again).events(1))) == 1
    again.close()


def test_owners_after_a_restore_are_newer_than_all_before(used, database, url, file):
    backup.main([str(file), "--database", url])
    free(database)
    given = [owner_of(database), owner_of(database, "later")]
    for cell in ("cell", "later"):
        CellOwnership(database, cell, "station", "", lease_s=60.0).release(given[0])
        CellOwnership(database, cell, "station", "", lease_s=60.0).release(given[1])
    assert restore.main([str(file), "--replace", "--database", url]) == 0
    again = ProductionDatabase(url)
    assert min(owner_of(again, "cell", "b"), owner_of(again, "later", "b")) > 1_700_000_000
    again.close()


def test_a_database_is_replaced_only_on_request(used, database, url, file, capsys):
    backup.main([str(file), "--database", url])
    free(database)
    assert restore.main([str(file), "--database", url]) == 1
    assert "the database exists: " in capsys.readouterr().err
    assert backup.main([str(file), "--database", url]) == 1
    assert f"{file} exists already" in capsys.readouterr().err
    assert backup.main([str(file), "--replace", "--database", url]) == 0


def test_a_database_whose_cell_is_owned_is_not_replaced(used, url, file, capsys):
    log, owner = used
    backup.main([str(file), "--database", url])
    log.append(1, Interrupted("after the backup"), state_after([BEGUN]), owner)
    assert restore.main([str(file), "--replace", "--database", url]) == 1
    assert "a supervisor owns cell cell: supervisor at station; stop it" in capsys.readouterr().err
    assert len(list(log.events(1))) == 2


def test_a_backup_of_a_database_in_use_is_whole(used, database, url, file):
    """Events are kept while the backup is made; what it has is a beginning of them."""
    log, owner = used
    over = threading.Event()

    def work():
        state = state_after([BEGUN])
        while not over.is_set():
            state = log.append(1, Interrupted("again"), state, owner)

    thread = threading.Thread(target=work)
    thread.start()
    try:
        assert backup.main([str(file), "--database", url]) == 0
    finally:
        over.set()
        thread.join(60.0)
    free(database)
    kept = len(list(log.events(1)))
    assert restore.main([str(file), "--replace", "--database", url]) == 0
    again = ProductionDatabase(url)
    assert 1 <= len(list(RunLog(again).events(1))) <= kept
    again.close()


def test_what_is_no_whole_backup_is_refused(used, database, url, file, capsys):
    backup.main([str(file), "--database", url])
    free(database)
    whole = file.read_bytes()
    for content in (whole[: len(whole) // 2], b"", b"no backup"):
        file.write_bytes(content)
        assert restore.main([str(file), "--replace", "--database", url]) == 1
        assert "restore: " in capsys.readouterr().err
        assert database.order_names() == ("house",)
    file.unlink()
    assert restore.main([str(file), "--replace", "--database", url]) == 1


def test_a_backup_of_a_newer_program_is_refused(database, url, file, capsys):
    with database.transaction() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '0999'"))
    assert backup.main([str(file), "--database", url]) == 1
    assert "was made by a newer program (version 0999)" in capsys.readouterr().err
    assert not file.exists()


def test_a_file_that_is_gone_or_damaged_is_replaced(tmp_path, file):
    production = tmp_path / "production.sqlite"
    url = f"sqlite:///{production}"
    database = ProductionDatabase(url)
    database.add_order(HOUSE)
    backup.main([str(file), "--database", url])
    database.close()
    production.unlink()
    assert restore.main([str(file), "--database", url]) == 0
    production.write_bytes(b"damaged " * 1000)
    assert restore.main([str(file), "--replace", "--database", url]) == 0
    with sqlite3.connect(production) as restored:
        assert restored.execute("SELECT name FROM orders").fetchall() == [("house",)]
    restored.close()
    assert [each.name for each in tmp_path.iterdir() if each.name.startswith(".")] == []


def test_an_emptied_file_does_not_become_a_database_before_it_is_replaced(
    tmp_path, file, monkeypatch
):
    url = f"sqlite:///{tmp_path}/production.sqlite"
    database = ProductionDatabase(url)
    assert backup.main([str(file), "--database", url]) == 0
    database.close()
    emptied = tmp_path / "production.sqlite"
    emptied.write_bytes(b"")
    sizes, connect = [], sqlite3.connect

    def connected(*args, **kwargs):
        sizes.append(emptied.stat().st_size)
        return connect(*args, **kwargs)

    monkeypatch.setattr(sqlite3, "connect", connected)
    assert restore.main([str(file), "--replace", "--database", url]) == 0
    assert set(sizes) == {0}


def test_a_database_that_is_not_there_has_no_backup(tmp_path, file, capsys):
    assert backup.main([str(file), "--database", f"sqlite:///{tmp_path}/none.sqlite"]) == 1
    assert f"there is no database {tmp_path}/none.sqlite" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_without_the_programs_of_postgresql_that_is_reported(monkeypatch, file, capsys):
    monkeypatch.setattr(shutil, "which", lambda _: None)
    assert backup.main([str(file), "--database", "postgresql+psycopg2://cell@host/x"]) == 1
    assert "pg_dump is not installed: install PostgreSQL's client" in capsys.readouterr().err


def test_a_password_is_not_shown_to_other_processes(monkeypatch, file, capsys):
    seen = []

    def run(line, env, **_):
        seen.append((line, env["PGPASSWORD"]))
        return subprocess.CompletedProcess(line, 1, "", "no route to host")

    monkeypatch.setattr(database_backup.subprocess, "run", run)
    assert backup.main([str(file), "--database", "postgresql+psycopg2://cell:secret@h/x"]) == 1
    ((line, password),) = seen
    assert password == "secret"
    assert not any("secret" in argument for argument in line)
    assert "pg_dump: no route to host" in capsys.readouterr().err
