"""What chaos.py does to a running order, and how long it takes to go on."""

from __future__ import annotations

import multiprocessing
import os
import shutil
import signal
import sqlite3
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass
from multiprocessing.managers import BaseManager
from pathlib import Path
from random import Random

import rospy

sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_planner/test/rostest"))
sys.path.insert(0, str(Path(__file__).parents[2] / "src/remodel_production/test"))
from databases import PROGRAMS
from databases import run as run_program
from motion_watch import MotionWatch
from order_client import OrderClient
from stack import LIMIT_S, Runs, Stack, wait_until

from remodel_supervision.core.runs.events import Commanded, Event, Interrupted
from remodel_supervision.core.runs.state import Stage

SUPERVISOR = "use_case_supervisor"
ENDED_POLITELY = (SUPERVISOR, SUPERVISOR, "behavior", "behavior_action_server")
NAMES = {
    SUPERVISOR: "supervisor",
    "behavior": "engine",
    "behavior_action_server": "action server",
    "synthesis_server": "synthesizer",
    "console": "console",
    **dict.fromkeys(("feeder", "eyes", "hand", "screwdriver"), "cell process"),
}
NODES = tuple(NAMES)
ALL, MASTER = "all", "ROS master"

# Kind -> how often it is drawn, beside the others.
WEIGHTS = {
    "kill": 6.0,
    "terminate": 3.0,
    "stall": 4.0,
    "pause": 3.0,
    "protective": 2.0,
    "skip": 2.0,
    "database": 1.5,
    "launch": 1.0,
    "master": 0.7,
}

# [s] wall time of a stall, of a long one, and of a database that takes no writes.
STALL_S, LONG_STALL_S, DATABASE_S = (2.0, 12.0), 45.0, (1.0, 8.0)
# Tasks that a run still has when one is skipped, so that it does not end before the retry.
LEFT_TO_SKIP = 6


@dataclass(frozen=True)
class Struck:
    """A disturbance that was caused.

    Attributes:
        kind: row of the table.
        resume_s: [s] wall time until the run went on.
        late: what began after a command was answered that stops all motion.
    """

    kind: str
    resume_s: float
    late: tuple[str, ...] = ()


class SqliteFile:
    """A database in a file; another program's writer can lock it."""

    def __init__(self, folder: Path) -> None:
        self._file = folder / "production.sqlite"
        self.url = f"sqlite:///{self._file}"

    def disturb(self, for_s: float) -> None:
        """Hold the lock of a writer for some time [s]."""
        with closing(sqlite3.connect(self._file, timeout=LIMIT_S, isolation_level=None)) as writer:
            writer.execute("BEGIN IMMEDIATE")
            time.sleep(for_s)
            writer.execute("ROLLBACK")

    def end(self) -> None:
        """Do nothing: there is no process."""


class PostgresServer:
    """A PostgreSQL server that listens on a socket in a folder of its own."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._data = folder, str(folder / "data")
        folder.mkdir(parents=True)
        if os.geteuid() == 0:  # PostgreSQL refuses to be run by root
            for each in (folder, folder.parent):
                shutil.chown(each, "postgres", "postgres")
        self.url = f"postgresql+psycopg2://test@/postgres?host={folder}"
        self._run("initdb", "-U", "test", "-A", "trust", "-N")
        self._start()

    def disturb(self, for_s: float) -> None:
        """Restart it as after a crash, some time [s] later."""
        self.end()
        time.sleep(for_s)
        self._start()

    def end(self) -> None:
        """End it without a word to its clients."""
        self._run("pg_ctl", "stop", "-w", "-m", "immediate")

    def _start(self) -> None:
        settings = f"-c listen_addresses= -c unix_socket_directories={self._folder} -c fsync=off"
        self._run("pg_ctl", "start", "-w", "-l", str(self._folder / "log"), "-o", settings)

    def _run(self, program: str, *arguments: str) -> None:
        path = max(PROGRAMS.glob("*/bin")) / program
        run_program(self._folder, path, *arguments, "-D", self._data)


class Bystander(OrderClient):
    """Orders, commands and watches, in a process that ends with the ROS master it joined."""

    def __init__(self, output: Path) -> None:
        rospy.init_node("chaos", anonymous=True, disable_signals=True)
        super().__init__(output)
        self._watch = MotionWatch(self.world)
        self._sent = None

    def order(self, tasks: int) -> None:
        """Have tasks done again."""
        self._sent = self.send(tasks)

    def refusal(self) -> str:
        """Return what is said of the order's goal."""
        return "" if self._sent is None else str(self._sent.get_goal_status_text())

    def ask(self, name: str, task: str = "") -> tuple[bool, str, float]:
        """Return success, message and wall time [s] of the answer to a command."""
        try:
            granted, text = self.command(name, **({"task": task} if task else {}))
        except (rospy.ServiceException, rospy.ROSException) as error:
            return False, str(error), time.time()
        return granted, text, time.time()

    def begun_after(self, at_s: float, window_s: float) -> tuple[str, ...]:
        """Return what moves although all was to rest at a wall time [s], within a window [s]."""
        return tuple(motion.what for motion in self._watch.after(at_s, window_s))


class _Manager(BaseManager):
    pass


_Manager.register("Bystander", Bystander)


class Disturbances:
    """Causes disturbances, drawn at random.

    Attributes:
        bystander: in a process of its own, started again for each ROS master.
    """

    def __init__(
        self,
        nodes: Stack,
        server: SqliteFile | PostgresServer,
        runs: Runs,
        random: Random,
        *,
        long_stalls: bool,
    ) -> None:
        self._nodes, self._server, self._runs, self._random = nodes, server, runs, random
        self._long_stalls = long_stalls
        self._commands = ThreadPoolExecutor()
        self._join()

    def strike(self, kind: str, run: int) -> Struck | None:
        """Disturb a run in a way of some kind; None if the run had ended before."""
        return getattr(self, f"_{kind}")(run)

    def end(self) -> None:
        """End the bystander."""
        self._manager.shutdown()

    def _join(self) -> None:
        self._manager = _Manager(ctx=multiprocessing.get_context("spawn"))
        self._manager.start()
        self.bystander: Bystander = self._manager.Bystander(self._nodes.output)  # type: ignore[attr-defined]

    # --- processes

    def _kill(self, run: int) -> Struck:
        return self._signal(run, self._random.choice((*NODES, ALL)), signal.SIGKILL)

    def _terminate(self, run: int) -> Struck:
        number = self._random.choice((signal.SIGTERM, signal.SIGINT))
        return self._signal(run, self._random.choice(ENDED_POLITELY), number)

    def _signal(self, run: int, node: str, number: signal.Signals) -> Struck:
        since = self._count(run)
        self._nodes.kill(*(NODES if node == ALL else (node,)), number=number)
        return self._struck(run, f"{number.name} {NAMES.get(node, node)}", since)

    def _stall(self, run: int) -> Struck:
        name = self._random.choice((*NODES, MASTER))
        is_long = self._long_stalls and self._random.random() < 1 / 3
        for_s = LONG_STALL_S if is_long else self._random.uniform(*STALL_S)
        since = self._count(run)
        pid = self._nodes.master_pid() if name == MASTER else self._nodes.pid(name)
        assert pid, f"{name} does not answer"
        os.kill(pid, signal.SIGSTOP)
        try:
            time.sleep(for_s)
        finally:
            os.kill(pid, signal.SIGCONT)
        length = f"{for_s:.0f} s" if is_long else "2 to 12 s"
        return self._struck(run, f"stall {length} {NAMES.get(name, name)}", since)

    def _launch(self, run: int) -> Struck:
        since = self._count(run)
        self._nodes.end_launch()
        self._start_launch()
        return self._struck(run, "Ctrl-C of roslaunch", since)

    def _master(self, run: int) -> Struck:
        since = self._count(run)
        self._nodes.end_master(self._random.choice((signal.SIGKILL, signal.SIGINT)))
        time.sleep(self._random.uniform(0.5, 4.0))
        steps = [self._nodes.end_launch, self._nodes.start_master]
        self._random.shuffle(steps)
        for step in steps:
            step()
        self._start_launch()
        struck = self._struck(run, "restart of the ROS master", since)
        self._manager.shutdown()
        self._join()
        return struck

    def _start_launch(self) -> None:
        time.sleep(self._random.uniform(0.0, 2.0))
        self._nodes.start_launch()
        self._nodes.wait_for(*NODES)

    def _database(self, run: int) -> Struck:
        since = self._count(run)
        self._server.disturb(self._random.uniform(*DATABASE_S))
        return self._struck(run, "database", since)

    # --- commands

    def _pause(self, run: int) -> Struck | None:
        granted, _, at_s = self._command("pause")
        if not granted:
            return None
        if is_killed := self._random.random() < 0.25:
            self._nodes.kill(SUPERVISOR)
        return self._go_on(run, "pause" + ", supervisor killed" * is_killed, at_s)

    def _protective(self, run: int) -> Struck | None:
        granted, _, at_s = self._command("protective_stop")
        return self._go_on(run, "protective stop", at_s) if granted else None

    def _skip(self, run: int) -> Struck | None:
        state = self._runs.state(run)
        left = [name for name, task in state.tasks.items() if not task.stage.is_lasting]
        if len(left) < LEFT_TO_SKIP:
            return None
        task = state.current or self._random.choice(left)
        if not self._command("skip", task)[0]:
            return None

        def stage() -> Stage:
            return self._runs.state(run).tasks[task].stage

        wait_until(lambda: stage() in (Stage.SET_ASIDE, Stage.DONE), f"{task} skipped", LIMIT_S)
        since = self._count(run)
        time.sleep(self._random.uniform(0.0, 1.0))
        if stage() is Stage.SET_ASIDE:
            granted, text, _ = self._command("retry", task)
            assert granted or self._runs.has_ended(run), f"{task} cannot be retried: {text}"
        return self._struck(run, "skip and retry", since)

    def _go_on(self, run: int, kind: str, at_s: float) -> Struck:
        """Watch a run for a while that is to rest since a wall time [s], and resume it."""
        late = self.bystander.begun_after(at_s, self._random.uniform(0.5, 2.5))
        since, end = self._count(run), time.monotonic() + LIMIT_S
        while not (answer := self._command("resume"))[0] and not self._runs.has_ended(run):
            assert time.monotonic() < end, f"{kind}: the run is not resumed: {answer[1]}"
            time.sleep(0.1)
        return self._struck(run, kind, since, late)

    def _command(self, name: str, task: str = "") -> tuple[bool, str, float]:
        """Return success, message and wall time [s] of the answer to a command."""
        return self._commands.submit(self.bystander.ask, name, task).result(LIMIT_S)

    # --- the run

    def _count(self, run: int) -> int:
        return len(self._runs.events(run))

    def _struck(self, run: int, kind: str, since: int, late: tuple[str, ...] = ()) -> Struck:
        """Return what was done, when the run has gone on since a position."""
        begun = time.monotonic()

        def has_gone_on() -> bool:
            return bool(news(self._runs, run, since)) or self._runs.has_ended(run)

        if has_gone_on():
            return Struck(kind, 0.0, late)
        wait_until(has_gone_on, f"news of run {run}: {kind}", LIMIT_S)
        return Struck(kind, time.monotonic() - begun, late)


def news(runs: Runs, run: int, since: int) -> list[Event]:
    """Return the events since a position by which a run went on."""
    events = (kept.event for kept in runs.events(run, since))
    return [event for event in events if not isinstance(event, (Interrupted, Commanded))]
