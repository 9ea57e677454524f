"""The production database of a benchmark, and what may happen to it: a lock, a restart."""

from __future__ import annotations

import os
import shutil
import sqlite3
import subprocess
import time
from contextlib import closing
from pathlib import Path
from typing import Protocol

_PROGRAMS = Path("/usr/lib/postgresql")
_LIMIT_S = 60.0


class Server(Protocol):
    """A production database.

    Attributes:
        url: at which the planner finds it.
    """

    url: str

    def disturb(self, for_s: float) -> None:
        """Have it take no writes for some wall time [s]."""

    def end(self) -> None:
        """End it, if it is a process."""


class SqliteFile:
    """A file; another program's writer can lock it."""

    def __init__(self, folder: Path) -> None:
        """Name the file; the first process that opens it creates it."""
        self._file = folder / "production.sqlite"
        self.url = f"sqlite:///{self._file}"

    def disturb(self, for_s: float) -> None:
        """Hold the lock of a writer."""
        with closing(sqlite3.connect(self._file, timeout=_LIMIT_S, isolation_level=None)) as writer:
            writer.execute("BEGIN IMMEDIATE")
            time.sleep(for_s)
            writer.execute("ROLLBACK")

    def end(self) -> None:
        """Do nothing: there is no process."""


class PostgresServer:
    """A PostgreSQL server that listens on a socket in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        """Make a cluster below a folder, and start its server."""
        self._programs = max(_PROGRAMS.glob("*/bin"))
        self._folder = folder
        folder.mkdir(parents=True)
        if os.geteuid() == 0:  # PostgreSQL refuses to be run by root
            for each in (folder, *folder.parents[:1]):
                shutil.chown(each, "postgres", "postgres")
        self.url = f"postgresql+psycopg2://test@/postgres?host={folder}"
        self._run("initdb", "-D", str(folder / "data"), "-U", "test", "-A", "trust", "-N")
        self._start()

    def disturb(self, for_s: float) -> None:
        """Restart it as after a crash, some time later."""
        self.end()
        time.sleep(for_s)
        self._start()

    def end(self) -> None:
        """End it without a word to its clients."""
        self._run("pg_ctl", "stop", "-w", "-m", "immediate", "-D", str(self._folder / "data"))

    def _start(self) -> None:
        settings = f"-c listen_addresses= -c unix_socket_directories={self._folder} -c fsync=off"
        line = ("start", "-w", "-D", str(self._folder / "data"), "-o", settings)
        self._run("pg_ctl", *line, "-l", str(self._folder / "log"))

    def _run(self, program: str, *arguments: str) -> None:
        user = {"user": "postgres", "group": "postgres", "extra_groups": []}
        subprocess.run(
            [str(self._programs / program), *arguments],
            check=True,
            timeout=_LIMIT_S,
            cwd=self._folder,
            stdout=subprocess.DEVNULL,
            **(user if os.geteuid() == 0 else {}),  # type: ignore[arg-type]
        )
