"""Back up and restore the production database, whole or not at all.

SQLite is copied by its online backup, PostgreSQL by pg_dump and psql. A restored database gives no
token that the lost one may have given: owners get numbers above the present time in seconds.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import sqlite3
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

from sqlalchemy.engine import make_url
from sqlalchemy.engine.url import URL

from remodel_production.edge.database.cell_ownership import LiveOwner, live_owners
from remodel_production.edge.database.production_database import NEWEST, ProductionDatabase
from remodel_production.edge.database.production_models import Base
from remodel_production.errors import BackupError, PlannerError

_TABLES = (*(table.name for table in Base.metadata.sorted_tables), "alembic_version")
_DUMP_BEGINS, _DUMP_ENDS = "-- PostgreSQL database dump", "-- PostgreSQL database dump complete"
# What stands for all cells of which the backup knows nothing.
_FLOOR = "(restored)"


def back_up(url: str, file: Path, *, replace: bool = False) -> None:
    """Write a backup of a database that may be in use.

    Raises:
        BackupError: if there is no such database, the file is there, or cannot be written.
    """
    if file.exists() and not replace:
        raise BackupError(f"{file} exists already: give another file, or --replace")
    source = make_url(url)
    with _beside(file) as new:
        if source.get_backend_name() == "sqlite":
            _copy_sqlite(_file_of(source), new)
            _verify_sqlite(new)
        else:
            names = [f"--table=public.{table}" for table in _TABLES]
            plain = ["--no-owner", "--no-privileges", *names, f"--file={new}"]
            _run("pg_dump", source, plain)
            _verify_dump(new)


def restore(url: str, file: Path, *, replace: bool = False) -> None:
    """Put a backup in the place of a database.

    Args:
        url: of the database.
        file: that `back_up` has written; it is verified first.
        replace: give up the database that is there.

    Raises:
        BackupError: if the file is no whole backup, a database is there, or a supervisor owns one
            of its cells.
    """
    target = make_url(url)
    if target.get_backend_name() == "sqlite":
        _verify_sqlite(file)
        database = _file_of(target)
        if database.exists():
            _require_replaceable(url, replace=replace)
        _restore_sqlite(file, database)
    else:
        _verify_dump(file)
        if _psql(target, "SELECT to_regclass('public.alembic_version')"):
            _require_replaceable(url, replace=replace)
        _restore_dump(file, target)


def _require_replaceable(url: str, *, replace: bool) -> None:
    if not replace:
        raise BackupError(
            "the database exists: back it up if it is of use, then give --replace to replace it"
        )
    for owner in _live_owners(url):
        raise BackupError(
            f"a supervisor owns cell {owner.cell}: {owner.holder}; stop it first (its lease runs "
            f"out in {owner.left_s:.0f} s)"
        )


def _live_owners(url: str) -> tuple[LiveOwner, ...]:
    """Return the owners of a database's cells; none if it is too damaged to be read."""
    target = make_url(url)
    if target.get_backend_name() == "sqlite" and not _file_of(target).stat().st_size:
        return ()  # opened, it would become a new database, which a waiting supervisor takes
    try:
        with contextlib.closing(ProductionDatabase(url)) as database:
            return live_owners(database)
    except PlannerError:
        return ()


def _file_of(url: URL) -> Path:
    if not url.database or url.database == ":memory:":
        raise BackupError("a database in memory has no backup")
    return Path(url.database)


@contextlib.contextmanager
def _beside(file: Path) -> Iterator[Path]:
    """Give the name of a new file that takes a file's place once it is complete."""
    new = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        yield new
        with open(new, "rb+") as written:
            os.fsync(written.fileno())
        new.replace(file)
    except OSError as error:
        raise BackupError(f"{file} cannot be written: {error.strerror}") from error
    finally:
        for each in (new, *(new.with_name(f"{new.name}{end}") for end in ("-wal", "-shm"))):
            each.unlink(missing_ok=True)


def _copy_sqlite(source: Path, copy: Path) -> None:
    """Copy a database as it is at one moment, whatever is written meanwhile."""
    if not source.is_file():
        raise BackupError(f"there is no database {source}")
    try:
        with _opened(source) as before, contextlib.closing(sqlite3.connect(copy)) as after:
            before.backup(after)
            # One file, without a log beside it.
            after.execute("PRAGMA journal_mode=DELETE")
    except sqlite3.Error as error:
        raise BackupError(f"{source} cannot be copied: {error}") from error


def _opened(file: Path) -> contextlib.closing[sqlite3.Connection]:
    """Open a database to read it only."""
    return contextlib.closing(sqlite3.connect(f"{file.absolute().as_uri()}?mode=ro", uri=True))


def _verify_sqlite(file: Path) -> None:
    if not file.is_file():
        raise BackupError(f"there is no file {file}")
    try:
        with _opened(file) as backup:
            (found,) = backup.execute("PRAGMA integrity_check(1)").fetchone()
            version = backup.execute("SELECT version_num FROM alembic_version").fetchone()
    except sqlite3.Error as error:
        raise BackupError(f"{file} is no backup of a production database: {error}") from error
    if found != "ok":
        raise BackupError(f"{file} is damaged: {found}")
    if version is None or version[0] > NEWEST:
        raise BackupError(f"{file} was made by a newer program (version {version and version[0]})")


def _restore_sqlite(file: Path, database: Path) -> None:
    with _beside(database) as new:
        _copy_sqlite(file, new)
        with contextlib.closing(sqlite3.connect(new, isolation_level=None)) as restored:
            has_cells = restored.execute(
                "SELECT count(*) FROM sqlite_master WHERE name = 'cells'"
            ).fetchone()
            for statement in _without_owners("cells") if has_cells[0] else ():
                restored.execute(statement)
        for end in ("-wal", "-shm"):
            database.with_name(f"{database.name}{end}").unlink(missing_ok=True)


def _without_owners(cells: str) -> tuple[str, ...]:
    """Return statements after which no cell has an owner, and all tokens to come are new."""
    floor = int(time.time())
    return (
        f"DELETE FROM {cells} WHERE name = '{_FLOOR}'",
        f"UPDATE {cells} SET lease_until = NULL",
        f"UPDATE {cells} SET token = {floor} WHERE token < {floor}",
        f"INSERT INTO {cells} (name, token, station, holder) VALUES "
        f"('{_FLOOR}', {floor}, '', 'no supervisor: a backup was restored')",
    )


def _verify_dump(file: Path) -> None:
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise BackupError(f"{file} cannot be read: {error}") from error
    if _DUMP_BEGINS not in text[:200] or _DUMP_ENDS not in text[-200:]:
        raise BackupError(f"{file} is no whole dump of PostgreSQL")
    _, _, after = text.partition("COPY public.alembic_version (version_num) FROM stdin;\n")
    version = after.partition("\n")[0]
    if not version:
        raise BackupError(f"{file} is no backup of a production database")
    if version > NEWEST:
        raise BackupError(f"{file} was made by a newer program (version {version})")


def _restore_dump(file: Path, target: URL) -> None:
    drop = f"DROP TABLE IF EXISTS {', '.join(f'public.{table}' for table in _TABLES)} CASCADE"
    owners = "; ".join(_without_owners("public.cells"))
    # A version without owners has none to remove.
    guarded = (
        f"DO $$ BEGIN IF to_regclass('public.cells') IS NOT NULL THEN {owners}; END IF; END $$"
    )
    steps = [f"--command={drop}", f"--file={file}", f"--command={guarded}"]
    _run("psql", target, ["--quiet", "--single-transaction", "-v", "ON_ERROR_STOP=1", *steps])


def _psql(target: URL, query: str) -> str:
    return _run("psql", target, ["--tuples-only", "--no-align", f"--command={query}"]).strip()


def _run(program: str, url: URL, arguments: list[str]) -> str:
    """Run a program of PostgreSQL, and return what it prints; the password is not shown to `ps`."""
    if url.get_backend_name() != "postgresql":
        raise BackupError(f"databases of {url.get_backend_name()} are not backed up here")
    if shutil.which(program) is None:
        raise BackupError(f"{program} is not installed: install PostgreSQL's client programs")
    bare = URL.create(
        "postgresql",
        username=url.username,
        host=url.host,
        port=url.port,
        database=url.database,
        query=url.query,
    ).render_as_string()
    password = {"PGPASSWORD": url.password} if url.password else {}
    done = subprocess.run(
        [program, "--no-password", f"--dbname={bare}", *arguments],
        env=os.environ | password,
        capture_output=True,
        text=True,
    )
    if done.returncode:
        first = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[0]
        raise BackupError(f"{program}: {first}")
    return done.stdout
