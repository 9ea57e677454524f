"""The faults of chaos.py: what is done to a running order, and how long it takes to go on."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from concurrent.futures import TimeoutError as FutureTimeoutError
from dataclasses import dataclass
from multiprocessing.managers import BaseManager
from pathlib import Path
from random import Random

import rospy
from chaos_records import LIMIT_S, Records, Server, Struck
from remodel_msgs import msg
from remodel_msgs.msg import RunUseCaseAction, RunUseCaseActionGoal, RunUseCaseGoal
from remodel_msgs.srv import CommandRun, CommandTask
from stack import ORDER, Program, Stack, TroubleError, free_port, wait_until
from std_msgs.msg import Bool

from remodel_states.edge.exported_tables import read_abilities
from remodel_supervision.core.runs.events import Command, Commanded
from remodel_supervision.core.runs.state import Stage
from remodel_supervision.ros.action_server import ActionServer, Goal

SUPERVISOR = "use_case_supervisor"
_ENGINE, _ACTION_SERVER = "behavior", "behavior_action_server"
_GROUPS = {
    SUPERVISOR: "supervisor",
    _ENGINE: "engine",
    _ACTION_SERVER: "action server",
    "synthesis_server": "synthesizer",
    "console": "console",
    **dict.fromkeys(("feeder", "eyes", "hand", "screwdriver"), "cell process"),
}
NODES = tuple(_GROUPS)
_ALL, _MASTER = "all", "ROS master"

# Kind -> how often it is drawn, beside the others.
WEIGHTS = {
    "kill": 6.0,
    "terminate": 3.0,
    "stall": 4.0,
    "pause": 3.0,
    "protective": 2.0,
    "skip": 2.0,
    "duplicate": 1.0,
    "database": 1.5,
    "launch": 1.0,
    "master": 0.7,
    "station": 0.7,
}

# [s] wall time of a stall, of a long one, and of a database that takes no writes.
_STALL_S, _LONG_STALL_S, _DATABASE_S = (2.0, 12.0), 45.0, (1.0, 8.0)

# Tasks that a run still has when one is skipped, so that it does not end before the retry.
_LEFT_TO_SKIP = 6

# [s] wall time from the record of a protective stop by topic, which has no answer, to the rest.
_STOP_S = 0.5


@dataclass(frozen=True)
class Site:
    """What faults strike."""

    nodes: Stack
    server: Server
    bystander: BystanderProcess
    records: Records


class Faults:
    """Causes faults, drawn at random."""

    def __init__(self, site: Site, random: Random, *, long_stalls: bool) -> None:
        self._site = site
        self._nodes, self._records = site.nodes, site.records
        self._random = random
        self._long_stalls = long_stalls
        self._commands = ThreadPoolExecutor()
        self._stations = 0

    def strike(self, kind: str, run: int) -> Struck | None:
        """Cause a fault of a kind in a run; None if the run had ended before."""
        causes: dict[str, Callable[[int], Struck | None]] = {
            "kill": self._kill,
            "terminate": self._terminate,
            "stall": self._stall,
            "pause": self._pause,
            "protective": self._protective,
            "skip": self._skip,
            "duplicate": self._duplicate,
            "database": self._database,
            "launch": self._launch,
            "master": self._master,
            "station": self._station,
        }
        return causes[kind](run)

    # --- processes

    def _kill(self, run: int) -> Struck:
        node = self._random.choice((*NODES, _ALL))
        return self._signal(run, node, signal.SIGKILL)

    def _terminate(self, run: int) -> Struck:
        node = self._random.choice((SUPERVISOR, SUPERVISOR, _ENGINE, _ACTION_SERVER))
        return self._signal(run, node, self._random.choice((signal.SIGTERM, signal.SIGINT)))

    def _signal(self, run: int, node: str, number: signal.Signals) -> Struck:
        since = self._count(run)
        pids = self._nodes.kill(*(NODES if node == _ALL else (node,)), number=number)
        self._nodes.wait_for_others(pids, LIMIT_S)
        return self._struck(run, f"{number.name} {_GROUPS.get(node, node)}", since)

    def _stall(self, run: int) -> Struck:
        name = self._random.choice((*NODES, _MASTER))
        is_long = self._long_stalls and self._random.random() < 1 / 3
        for_s = _LONG_STALL_S if is_long else self._random.uniform(*_STALL_S)
        since = self._count(run)
        pid = self._nodes.master_pid() if name == _MASTER else self._nodes.pid(name)
        if pid == 0:
            raise TroubleError(f"{name} does not answer")
        os.kill(pid, signal.SIGSTOP)
        try:
            time.sleep(for_s)
        finally:
            os.kill(pid, signal.SIGCONT)
        length = f"{for_s:.0f} s" if is_long else "2 to 12 s"
        return self._struck(run, f"stall {length} {_GROUPS.get(name, name)}", since)

    def _launch(self, run: int) -> Struck:
        since = self._count(run)
        self._nodes.end_launch()
        self._start_launch()
        return self._struck(run, "Ctrl-C of roslaunch", since)

    def _master(self, run: int) -> Struck:
        since = self._count(run)
        number = self._random.choice((signal.SIGKILL, signal.SIGINT))
        self._nodes.end_master(number)
        time.sleep(self._random.uniform(0.5, 4.0))
        if self._random.random() < 0.5:
            self._nodes.end_launch()
            self._nodes.start_master()
        else:
            self._nodes.start_master()
            self._nodes.end_launch()
        self._start_launch()
        struck = self._struck(run, "restart of the ROS master", since)
        self._site.bystander.restart()
        return struck

    def _start_launch(self) -> None:
        time.sleep(self._random.uniform(0.0, 2.0))
        self._nodes.start_launch()
        self._nodes.wait_for(*NODES)

    def _database(self, run: int) -> Struck:
        since = self._count(run)
        self._site.server.disturb(self._random.uniform(*_DATABASE_S))
        return self._struck(run, "database", since)

    # --- others who want the cell

    def _station(self, run: int) -> Struck:
        since = self._count(run)
        self._stations += 1
        folder = Path(self._nodes.output / f"station_{self._stations}")
        station = SecondStation(folder, self._nodes.database)
        try:
            station.start()
            if self._random.random() < 0.5:
                self._nodes.wait_for_others(self._nodes.kill(SUPERVISOR), LIMIT_S)
            station.order()
        finally:
            station.end()
        return self._struck(run, "second station", since)

    def _duplicate(self, run: int) -> Struck | None:
        since = self._count(run)
        bystander = self._site.bystander.now
        bystander.latch_goal(ORDER, len(self._records.state(run).tasks))
        try:
            if self._random.random() < 0.5:
                self._nodes.wait_for_others(self._nodes.kill(SUPERVISOR), LIMIT_S)
            time.sleep(self._random.uniform(0.5, 2.0))
            newest = self._records.newest()
            if newest != run and not self._records.has_ended(run):
                raise TroubleError(f"run {newest} has begun beside run {run}")
        finally:
            bystander.unlatch_goal()
        return self._struck(run, "latched goal", since)

    # --- commands

    def _pause(self, run: int) -> Struck | None:
        answered = self._command("pause")
        if not answered.granted:
            return None
        since = self._count(run)
        is_killed = self._random.random() < 0.25
        late = self._late(answered.at_s, is_killed=is_killed)
        return self._go_on(run, "pause" + ", supervisor killed" * is_killed, since, late)

    def _protective(self, run: int) -> Struck | None:
        since = self._count(run)
        if self._random.random() < 0.5:
            answered = self._command("protective_stop")
            if not answered.granted:
                return None
            late = self._late(answered.at_s, is_killed=False)
            return self._go_on(run, "protective stop", since, late)
        bystander = self._site.bystander.now
        bystander.protective_stop(is_on=True)
        try:
            wait_until(
                lambda: self._stopped_s(run, since) > 0 or self._records.has_ended(run),
                LIMIT_S,
                "protective stop",
            )
            if self._records.has_ended(run):
                return None
            late = self._late(self._stopped_s(run, since) + _STOP_S, is_killed=False)
        finally:
            bystander.protective_stop(is_on=False)
        return self._go_on(run, "protective stop by topic", since, late)

    def _stopped_s(self, run: int, since: int) -> float:
        """Return when a protective stop was recorded, [s] since 1970; 0 if it is not."""
        for kept in self._records.events(run, since):
            event = kept.event
            if isinstance(event, Commanded) and event.command is Command.PROTECTIVE_STOP:
                return kept.at.timestamp()
        return 0.0

    def _skip(self, run: int) -> Struck | None:
        state = self._records.state(run)
        left = [name for name, task in state.tasks.items() if not task.stage.is_lasting]
        if len(left) < _LEFT_TO_SKIP:
            return None
        since = self._count(run)
        task = state.current or self._random.choice(left)
        if not self._command("skip", task).granted:
            return None
        lasting = (Stage.SET_ASIDE, Stage.DONE)

        def is_over() -> bool:
            return self._records.state(run).tasks[task].stage in lasting

        wait_until(is_over, LIMIT_S, f"{task} is skipped")
        since_retry = self._count(run)
        time.sleep(self._random.uniform(0.0, 1.0))
        if self._records.state(run).tasks[task].stage is Stage.SET_ASIDE:
            retried = self._command("retry", task)
            if not retried.granted and not self._records.has_ended(run):
                raise TroubleError(f"{task} cannot be retried: {retried.text}")
        resume_s = self._records.resumed_s(run, since_retry, "skip")
        return Struck("skip and retry", since, resume_s)

    def _late(self, at_s: float, *, is_killed: bool) -> tuple[str, ...]:
        """Return what is begun after all motion was to have ended, in some seconds."""
        if is_killed:
            self._nodes.wait_for_others(self._nodes.kill(SUPERVISOR), LIMIT_S)
        time.sleep(self._random.uniform(0.5, 2.5))
        goals = self._site.bystander.now.goals_after(at_s)
        return (*goals, *self._records.deeds_after(at_s))

    def _go_on(self, run: int, kind: str, since: int, late: tuple[str, ...]) -> Struck:
        at = self._count(run)
        end = time.monotonic() + LIMIT_S
        while not (answered := self._command("resume")).granted:
            if self._records.has_ended(run):
                break
            if time.monotonic() > end:
                raise TroubleError(f"{kind}: the run is not resumed: {answered.text}")
            time.sleep(0.1)
        return Struck(kind, since, self._records.resumed_s(run, at, kind), late)

    def _command(self, name: str, task: str = "") -> Answered:
        """Ask for a command, and return the answer; TroubleError without one."""
        asked = self._commands.submit(self._site.bystander.now.command, name, task)
        try:
            return asked.result(LIMIT_S)
        except FutureTimeoutError:
            raise TroubleError(f"{name} is not answered within {LIMIT_S:.0f} s") from None

    # --- the run

    def _count(self, run: int) -> int:
        return len(self._records.events(run))

    def _struck(self, run: int, kind: str, since: int) -> Struck:
        return Struck(kind, since, self._records.resumed_s(run, since, kind))


# What chaos.py needs of ROS, in a process of its own that ends with the ROS master it joined


_BY = "chaos"


@dataclass(frozen=True)
class Answered:
    """The supervisor's answer to a command.

    Attributes:
        granted: whether it is done.
        text: why not.
        at_s: [s] wall time of the answer, since 1970.
    """

    granted: bool
    text: str
    at_s: float


class Bystander:
    """Sends orders and commands, and notes every goal that any ability is sent."""

    def __init__(self) -> None:
        rospy.init_node("chaos", anonymous=True, disable_signals=True)
        self._server = ActionServer("remodel/run_use_case", RunUseCaseAction, "use_case_supervisor")
        self._sent: Goal | None = None
        self._goals: list[tuple[float, str]] = []
        self._latched: rospy.Publisher | None = None
        self._stop = rospy.Publisher("remodel/protective_stop", Bool, queue_size=1, latch=True)
        for ability in read_abilities():
            topic = f"remodel_abilities/{ability.lower()}/goal"
            rospy.Subscriber(topic, getattr(msg, f"{ability}ActionGoal"), self._on_goal)

    def order(self, order: str, tasks: int, limit_s: float) -> None:
        """Have an order done again, once the supervisor is there; LostError if it is not."""
        self._server.wait(limit_s)
        goal = RunUseCaseGoal(id="chaos", order=order, tasks=tasks, again=True)
        self._sent = self._server.send(goal)

    def refusal(self) -> str:
        """Return how the order's goal has ended; empty if it has not."""
        return self._sent.ending if self._sent is not None and self._sent.wait(0.0) else ""

    def command(self, name: str, task: str = "") -> Answered:
        """Ask for a command; of a task if one is named."""
        kind = CommandTask if task else CommandRun
        service = rospy.ServiceProxy(f"remodel/use_case/{name}", kind)
        try:
            answer = service(task=task, by=_BY) if task else service(by=_BY)
        except rospy.ServiceException as error:
            return Answered(False, str(error), time.time())
        return Answered(answer.success, answer.message, time.time())

    def protective_stop(self, *, is_on: bool) -> None:
        """Be a safety controller."""
        self._stop.publish(Bool(is_on))

    def latch_goal(self, order: str, tasks: int) -> None:
        """Publish a goal that every supervisor gets that connects."""
        topic = "remodel/run_use_case/goal"
        self._latched = rospy.Publisher(topic, RunUseCaseActionGoal, queue_size=1, latch=True)
        latched = RunUseCaseActionGoal(goal=RunUseCaseGoal(id="latched", order=order, tasks=tasks))
        latched.header.stamp = latched.goal_id.stamp = rospy.Time.now()
        latched.goal_id.id = f"latched {time.time()}"
        self._latched.publish(latched)

    def unlatch_goal(self) -> None:
        """Publish it no more."""
        if self._latched is not None:
            self._latched.unregister()
        self._latched = None

    def goals_after(self, at_s: float) -> list[str]:
        """Return the goals that were sent after a wall time [s] since 1970."""
        return [goal for sent_s, goal in self._goals if sent_s > at_s]

    def _on_goal(self, sent: object) -> None:
        goal = sent.goal.id  # type: ignore[attr-defined]
        self._goals.append((sent.header.stamp.to_sec(), goal))  # type: ignore[attr-defined]


class _Manager(BaseManager):
    pass


_Manager.register("Bystander", Bystander)


class BystanderProcess:
    """The process; started again for each ROS master."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Start one that joins the present ROS master; end the one before."""
        self.end()
        self._manager = _Manager(ctx=multiprocessing.get_context("spawn"))
        self._manager.start()
        self.now: Bystander = self._manager.Bystander()  # type: ignore[attr-defined]

    def end(self) -> None:
        """End it."""
        if hasattr(self, "_manager"):
            self._manager.shutdown()


# A second station that claims the same cell: a ROS master and a supervisor of its own


_LIMIT_S = 60.0
_REFUSAL = "is owned by another station"


class SecondStation:
    """Runs beside the first; whatever it does to the cell is a violation."""

    def __init__(self, folder: Path, database: str) -> None:
        """Prepare it.

        Args:
            folder: of its logs; made.
            database: URL of the first station's database.
        """
        folder.mkdir(parents=True)
        self._database = database
        self._log = folder / "supervisor.log"
        port = str(free_port())
        self._environment = {
            **os.environ,
            "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
            "ROS_LOG_DIR": str(folder),
        }
        environment = self._environment
        self._master = Program(["roscore", "-p", port], folder / "master.log", environment)
        line = ["rosrun", "remodel_planner", "use_case_supervisor", "--unattended"]
        line += ["--database", database, "--output", str(folder)]
        self._supervisor = Program(line, self._log, environment)

    def start(self) -> None:
        """Start it, and return when it has been refused the cell; TroubleError if it is not."""
        self._master.start()
        self._supervisor.start()
        wait_until(lambda: _REFUSAL in self._log.read_text(), _LIMIT_S, "refusal of a station")

    def order(self) -> None:
        """Order something of it; TroubleError unless that is refused in words."""
        line = ["remodel", "run", ORDER, "--wires", "2"]
        line += ["--database", self._database, "--output", str(self._log.parent)]
        ordered = subprocess.run(
            line,
            env=self._environment,
            capture_output=True,
            text=True,
            timeout=_LIMIT_S,
            check=False,
        )
        if ordered.returncode != 3 or _REFUSAL not in ordered.stderr:
            raise TroubleError(f"the second station takes an order: {ordered}")

    def end(self) -> None:
        """End it; TroubleError if it ever resumed a run."""
        self._supervisor.end(signal.SIGINT)
        self._master.end(signal.SIGINT)
        if "resuming run" in self._log.read_text():
            raise TroubleError(f"the second station resumed a run; see {self._log}")
