"""Drive and judge an order of a launched stack over a fake cell, from a test or a benchmark."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from xmlrpc.client import ServerProxy

import actionlib
import rosgraph
import rospy
from remodel_msgs.msg import RunUseCaseAction, RunUseCaseGoal, UseCaseState
from remodel_msgs.srv import CommandRun, CommandTask, GetTasks

from flexbe_core.ros.master import drop_dead
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_states.testing.world import Account, account
from remodel_states.testing.world_file import WorldFile
from remodel_supervision.core.runs.events import Event
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.edge.run_log import RunLog
from remodel_supervision.ros.server.state_publisher import STATE

ORDER = "house"
DESIGN = "/usr/share/qelectrotech/examples/tableau_domestique.qet"

SUPERVISOR = "use_case_supervisor"

# [s] wall time for what must happen; beyond it something hangs.
LIMIT_S = 120.0

# [s] wall time between two checks of what no node reports.
_CHECK_S = 0.01

_FREE = (UseCaseState.IDLE, UseCaseState.ENDED)


def wait_until(holds: Callable[[], object], what: str, limit_s: float = LIMIT_S) -> None:
    """Return when something holds; AssertionError if it does not within a wall time [s]."""
    end = time.monotonic() + limit_s
    while not holds():
        if time.monotonic() > end:
            raise AssertionError(f"{what}: not within {limit_s:.0f} s")
        time.sleep(_CHECK_S)


def planner(*line: str, database: str) -> subprocess.CompletedProcess[str]:
    """Run a command of the planner to its end."""
    command = ["remodel", *line, "--database", database]
    return subprocess.run(command, capture_output=True, text=True, timeout=LIMIT_S, check=False)


def import_order(database: str) -> None:
    """Store the order in a production database, which is made."""
    imported = planner("import", DESIGN, "--order", ORDER, database=database)
    assert imported.returncode == 0, imported.stderr


class OrderClient:
    """A client of the use case supervisor, which also reads its database and the cell's world.

    Attributes:
        database: URL of the production database, in the launched folder.
        world: of the cell, in the launched folder.
    """

    def __init__(self, output: Path) -> None:
        """Connect, once the node is initialized.

        Args:
            output: folder of the launched stack: production.sqlite with the order, world.sqlite.
        """
        self.database = f"sqlite:///{output}/production.sqlite"
        self.world = WorldFile(output / "world.sqlite")
        self.state = UseCaseState()
        self._master = rosgraph.Master("/test")
        self._client = actionlib.ActionClient("remodel/run_use_case", RunUseCaseAction)
        rospy.Subscriber(STATE, UseCaseState, self._on_state, tcp_nodelay=True)

    # --- orders

    def send(self, tasks: int, *, again: bool = True) -> actionlib.ClientGoalHandle:
        """Send a goal of tasks for robots as soon as there is a supervisor, whatever it does."""
        # ROS time may jump ahead in a test, so that its limits pass at once.
        drop_dead(self._client.pub_goal)
        wait_until(lambda: self._client.wait_for_server(rospy.Duration(0.5)), "a supervisor")
        goal = RunUseCaseGoal(id="test", order=ORDER, tasks=tasks, again=again)
        return self._client.send_goal(goal)

    def start(self, tasks: int, *, again: bool = True) -> int:
        """Have the first tasks of the order done, and return the number of the run once it runs."""
        wait_until(lambda: self.is_free, "the supervisor is free")
        before = self.state.run
        handle = self.send(tasks, again=again)
        wait_until(lambda: self.state.run > before or _is_over(handle), "the run begins")
        assert self.state.run > before, handle.get_goal_status_text()
        return int(self.state.run)

    @property
    def is_free(self) -> bool:
        """Whether the supervisor takes goals."""
        return self.state.phase in _FREE and not self.state.message.startswith("protective")

    def wait_for_phase(self, phase: str, limit_s: float = LIMIT_S) -> None:
        """Wait until the supervisor has published a phase."""
        try:
            wait_until(lambda: self.state.phase == phase, f"phase {phase}", limit_s)
        except AssertionError as error:
            raise AssertionError(f"{error}; the state is {self.state}") from None

    def wait_for_end(self, run: int, limit_s: float = 2 * LIMIT_S) -> RunState:
        """Return how a run has ended."""

        def is_over() -> bool:
            return self.state.phase == UseCaseState.ENDED and self.state.run == run

        wait_until(is_over, f"the end of run {run}", limit_s)
        return self.run_state(run)

    def command(self, name: str, **request: str) -> tuple[bool, str]:
        """Call a command of the supervisor, such as pause or skip; return success and message."""
        service = f"remodel/use_case/{name}"
        rospy.wait_for_service(service, LIMIT_S)
        kind = CommandTask if "task" in request else CommandRun
        response = rospy.ServiceProxy(service, kind)(**request, by="the test")
        return response.success, response.message

    def require(self, name: str, **request: str) -> None:
        """Call a command that must be granted."""
        granted, text = self.command(name, **request)
        assert granted, f"{name}: {text}"

    def task_states(self, run: int) -> dict[str, str]:
        """Return the state of each task, as the supervisor returns them."""
        service = "remodel/use_case/tasks"
        rospy.wait_for_service(service, LIMIT_S)
        tasks = rospy.ServiceProxy(service, GetTasks)(run=run).tasks
        return {task.name: task.state for task in tasks}

    # --- what was recorded, and what was done

    def run_state(self, run: int) -> RunState:
        """Return what is known of a run."""
        with _RunLogOf(self.database) as log:
            return log.state(run)

    def events(self, run: int) -> list[Event]:
        """Return the events of a run."""
        with _RunLogOf(self.database) as log:
            return [kept.event for kept in log.events(run)]

    def runs(self) -> tuple[int, ...]:
        """Return the numbers of all runs, the latest first."""
        with _RunLogOf(self.database) as log:
            return tuple(head.number for head in log.heads())

    def account(self, run: int) -> Account:
        """Return what the ledger says about the wires of a run."""
        return account(self.world.ledger(), list(self.run_state(run).tasks))

    @property
    def held(self) -> str:
        """Ends that robots hold, by the cell's world; empty if none."""
        cells = self.world.read().world.hands.values()
        return "".join(end for hands in cells for end in hands.held.values())

    # --- processes

    def pid(self, node: str) -> int:
        """Return a node's process; 0 if it does not answer."""
        try:
            return int(ServerProxy(self._master.lookupNode(f"/{node}")).getPid("/test")[2])
        except (OSError, rosgraph.MasterError):
            return 0

    def end_process(self, node: str, number: signal.Signals = signal.SIGKILL) -> None:
        """Send a signal that ends a node, and return when roslaunch has started it again."""
        before = self.pid(node)
        assert before, f"{node} runs"
        os.kill(before, number)
        wait_until(lambda: self.pid(node) not in (0, before), f"{node} respawns")

    def _on_state(self, state: UseCaseState) -> None:
        self.state = state


class _RunLogOf:
    """The log of a database, which is closed at the end of a `with` block."""

    def __init__(self, url: str) -> None:
        self._database = ProductionDatabase(url)

    def __enter__(self) -> RunLog:
        return RunLog(self._database)

    def __exit__(self, *_: object) -> None:
        self._database.close()


def _is_over(handle: actionlib.ClientGoalHandle) -> bool:
    return bool(handle.get_comm_state() == actionlib.CommState.DONE)
