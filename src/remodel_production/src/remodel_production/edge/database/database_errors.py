"""What the database's driver reports, as errors that a person can act on."""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterator
from contextlib import contextmanager

from sqlalchemy.exc import DBAPIError, InterfaceError, OperationalError
from sqlalchemy.exc import TimeoutError as PoolTimeoutError

from remodel_production.errors import LostError, RecordLostError

# Texts of OperationalError that waiting does not help against: SQLite's of a table or file that is
# missing, replaced or damaged, PostgreSQL's of a dropped database.
_GONE = (
    "no such table",
    "no such column",
    "malformed",
    "not a database",
    "disk I/O error",
    "readonly database",
    "does not exist",
)


@contextmanager
def reported() -> Iterator[None]:
    """Report what goes wrong inside in the planner's errors.

    Raises:
        LostError: if the database does not answer; it may answer later.
        RecordLostError: if tables, rows or the whole file are missing or damaged.
    """
    try:
        yield
    except PoolTimeoutError as error:
        raise LostError(f"the production database does not answer: {error}") from error
    except DBAPIError as error:
        line = str(error.orig).strip().splitlines()[0] if str(error.orig).strip() else str(error)
        if _may_come_back(error, line):
            raise LostError(f"the production database does not answer: {line}") from error
        raise record_lost(f"cannot be used: {line}") from error
    except (json.JSONDecodeError, UnicodeDecodeError, zlib.error) as error:
        raise record_lost(f"has a damaged entry: {error}") from error


def record_lost(what: str) -> RecordLostError:
    """Return the error about a production database that, for instance, "has no run 12"."""
    return RecordLostError(
        f"the production database {what}; restore a backup (remodel restore FILE)"
    )


def _may_come_back(error: DBAPIError, line: str) -> bool:
    silent = isinstance(error, OperationalError | InterfaceError) or error.connection_invalidated
    return silent and not any(text in line for text in _GONE)
