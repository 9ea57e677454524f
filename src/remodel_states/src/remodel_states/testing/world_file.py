"""The world on disk: one SQLite file that the fake cell's processes share, and that outlives them.

A change is one transaction: whenever a process dies, what it did is there whole or not at all.
"""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path

from msgspec.json import decode, encode

from remodel_states.edge.write_ahead import write_ahead
from remodel_states.testing.faults import Faults
from remodel_states.testing.world import Deed, Entry, Panel, World

# [s] Wall time to wait for another process's change.
_BUSY_S = 10.0

_TABLES = """
CREATE TABLE IF NOT EXISTS part (name TEXT PRIMARY KEY, content TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS ledger (
    number INTEGER PRIMARY KEY AUTOINCREMENT, deed TEXT NOT NULL, cell TEXT NOT NULL,
    wire TEXT NOT NULL, end TEXT NOT NULL, terminal TEXT NOT NULL, goal TEXT NOT NULL,
    at_s REAL NOT NULL);
"""


@dataclass
class Draft:
    """A change that is being made.

    Attributes:
        world: see World; its panel is written only if it is another.
        faults: those caused so far.
        goals: ability -> how many goals it took.
        owners: cell -> newest token of a supervisor that it has seen; a new panel keeps it.
        entries: for the ledger.
    """

    world: World
    faults: Faults
    goals: dict[str, int]
    owners: dict[str, int] = field(default_factory=dict)
    entries: list[Entry] = field(default_factory=list)


class WorldFile:
    """The file."""

    def __init__(self, path: Path | str) -> None:
        """Make the file, unless it is there."""
        self._path = str(path)
        # Never closed: with the last connection SQLite clears its log, at the cost of five changes.
        self._anchor = self._connect()
        write_ahead(self._anchor, _BUSY_S)
        self._anchor.executescript(_TABLES)

    @contextmanager
    def change(self) -> Iterator[Draft]:
        """Give the world to be changed; it is kept unless an exception leaves the block."""
        with closing(self._connect()) as connection:
            connection.execute("BEGIN IMMEDIATE")
            before = _read(connection)
            draft = Draft(before.world, before.faults, dict(before.goals), before.owners)
            yield draft
            _write(connection, before, draft)
            connection.execute("COMMIT")

    def read(self) -> Draft:
        """Return everything but the ledger, as it is now."""
        with closing(self._connect()) as connection:
            connection.execute("BEGIN")
            return _read(connection)

    def ledger(self) -> tuple[Entry, ...]:
        """Return all that was ever done, in order."""
        names = "deed, cell, wire, end, terminal, goal, at_s"
        with closing(self._connect()) as connection:
            rows = connection.execute(f"SELECT {names} FROM ledger ORDER BY number").fetchall()
        return tuple(Entry(Deed(deed), *others) for deed, *others in rows)

    def _connect(self) -> sqlite3.Connection:
        connection = sqlite3.connect(self._path, timeout=_BUSY_S, isolation_level=None)
        connection.execute("PRAGMA synchronous = NORMAL")
        return connection


def _read(connection: sqlite3.Connection) -> Draft:
    parts = dict(connection.execute("SELECT name, content FROM part").fetchall())
    owners = decode(parts.get("owners", "{}"), type=dict[str, int])
    if "panel" not in parts:
        return Draft(World(), (), {}, owners)
    faults = decode(parts.get("faults", "[]"), type=Faults)
    world = replace(decode(parts["world"], type=World), panel=_panel(parts["panel"]))
    goals = decode(parts.get("goals", "{}"), type=dict[str, int])
    return Draft(world, faults, goals, owners)


def _write(connection: sqlite3.Connection, before: Draft, after: Draft) -> None:
    if after.world.panel is not before.world.panel:
        _keep(connection, "panel", after.world.panel)
    if after.world is not before.world:
        _keep(connection, "world", replace(after.world, panel=Panel()))
    if after.faults != before.faults:
        _keep(connection, "faults", after.faults)
    if after.goals != before.goals:
        _keep(connection, "goals", after.goals)
    if after.owners != before.owners:
        _keep(connection, "owners", after.owners)
    now = time.time()
    connection.executemany(
        "INSERT INTO ledger (deed, cell, wire, end, terminal, goal, at_s) VALUES (?,?,?,?,?,?,?)",
        [(e.deed.value, e.cell, e.wire, e.end, e.terminal, e.goal, now) for e in after.entries],
    )


def _keep(connection: sqlite3.Connection, name: str, content: object) -> None:
    connection.execute(
        "INSERT OR REPLACE INTO part (name, content) VALUES (?, ?)",
        (name, encode(content).decode()),
    )


@lru_cache(maxsize=1)
def _panel(text: str) -> Panel:
    """Return the panel of its JSON, the same object for the same text: it hardly ever changes."""
    return decode(text, type=Panel)
