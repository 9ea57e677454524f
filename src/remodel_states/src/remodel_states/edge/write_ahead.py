"""SQLite's write-ahead log, with which readers do not wait for writers."""

from __future__ import annotations

import sqlite3
import time

# [s] wall time between two attempts.
_RETRY_S = 0.02


def write_ahead(connection: sqlite3.Connection, limit_s: float) -> None:
    """Switch a database to the write-ahead log; it stays so.

    A new database changes its mode alone, and SQLite does not wait for other connections
    then, whatever its timeout is. So this function waits.

    Args:
        connection: to the database, outside a transaction.
        limit_s: [s] wall time to wait for other connections.

    Raises:
        sqlite3.OperationalError: if the others still use it then.
    """
    late_s = time.monotonic() + limit_s
    while True:
        try:
            connection.execute("PRAGMA journal_mode = WAL")
        except sqlite3.OperationalError as error:
            if "locked" not in str(error) or time.monotonic() > late_s:
                raise
            time.sleep(_RETRY_S)
        else:
            return
