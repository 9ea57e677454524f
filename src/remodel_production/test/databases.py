"""Databases for tests: SQLite in a file, and PostgreSQL on a server of its own."""

import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import pytest
from sqlalchemy import create_engine, text

PROGRAMS = Path("/usr/lib/postgresql")


def execute(url, *statements):
    """Execute statements, and return the rows of the last one."""
    engine = create_engine(url)
    with engine.begin() as connection:
        for statement in statements:
            result = connection.execute(text(statement))
        rows = [tuple(row) for row in result] if result.returns_rows else []
    engine.dispose()
    return rows


def run(folder, *line):
    """Run a program of PostgreSQL, which refuses to be run by root."""
    as_postgres = {"user": "postgres", "group": "postgres", "extra_groups": []}
    user = as_postgres if os.geteuid() == 0 else {}
    subprocess.run(line, check=True, timeout=60, cwd=folder, stdout=subprocess.DEVNULL, **user)


@pytest.fixture(scope="session")
def postgres_url():
    """Start a server that listens on a socket in a folder of its own, and end it afterwards."""
    programs = max(PROGRAMS.glob("*/bin"))
    folder = Path(tempfile.mkdtemp(prefix="remodel_pg_"))
    if os.geteuid() == 0:
        shutil.chown(folder, "postgres", "postgres")
    data = str(folder / "data")
    settings = f"-c listen_addresses= -c unix_socket_directories={folder} -c fsync=off"
    try:
        run(folder, programs / "initdb", "-D", data, "-U", "test", "-A", "trust", "-N")
        log = str(folder / "log")
        run(folder, programs / "pg_ctl", "start", "-w", "-D", data, "-l", log, "-o", settings)
        try:
            yield f"postgresql+psycopg2://test@/postgres?host={folder}"
        finally:
            run(folder, programs / "pg_ctl", "stop", "-w", "-m", "immediate", "-D", data)
    finally:
        shutil.rmtree(folder)


@pytest.fixture(params=["sqlite", "postgresql"])
def url(request, tmp_path):
    """Return the URL of an empty database, of each kind in turn."""
    if request.param == "sqlite":
        return f"sqlite:///{tmp_path}/production.sqlite"
    url = request.getfixturevalue("postgres_url")
    execute(url, "DROP SCHEMA public CASCADE", "CREATE SCHEMA public")
    return url
