"""Bring a database to this program's version: a new one from the models, others by migrations."""

from __future__ import annotations

from pathlib import Path

from sqlalchemy import inspect, text
from sqlalchemy.engine import Connection

from remodel_production.edge.database.production_models import Base
from remodel_production.errors import OrderError

NEWEST = "0008"
_VERSION_TABLE = "alembic_version"
_MIGRATIONS = Path(__file__).parent / "migrations"
# Any number that no other program takes a lock by, in one database.
_LOCK = 5_151_002


def version_of(connection: Connection) -> str | None:
    """Return the database's version; None if it has none."""
    if not inspect(connection).has_table(_VERSION_TABLE):
        return None
    version = connection.scalar(text(f"SELECT version_num FROM {_VERSION_TABLE}"))
    return None if version is None else str(version)


def upgrade(connection: Connection) -> None:
    """Bring a database to the newest version: an empty one, or of any version that is known.

    Args:
        connection: with a transaction that the migrations become part of.

    Raises:
        OrderError: if the database is of a version that this program does not know.
    """
    if connection.dialect.name == "postgresql":
        # One program at a time; the lock is given back at the transaction's end.
        connection.execute(text("SELECT pg_advisory_xact_lock(:key)"), {"key": _LOCK})
    version = version_of(connection)
    if version == NEWEST:
        return
    # Alembic takes longer to load than a database to open, and is needed once in its life.
    from alembic import command
    from alembic.config import Config
    from alembic.script import ScriptDirectory

    config = Config()
    config.set_main_option("script_location", str(_MIGRATIONS))
    config.attributes["connection"] = connection
    if version is None:
        Base.metadata.create_all(connection, checkfirst=False)
        command.stamp(config, "head")
        return
    known = {script.revision for script in ScriptDirectory.from_config(config).walk_revisions()}
    if version not in known:
        raise OrderError(
            f"is of version {version}; this program knows versions {', '.join(sorted(known))}: "
            "use the program that made it, or give another database (--database)"
        )
    command.upgrade(config, "head")
