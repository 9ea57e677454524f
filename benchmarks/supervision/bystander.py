"""What chaos.py needs of ROS, in a process of its own that ends with the ROS master it joined."""

from __future__ import annotations

import multiprocessing
import time
from dataclasses import dataclass
from multiprocessing.managers import BaseManager

import rospy
from remodel_msgs import msg
from remodel_msgs.msg import RunUseCaseAction, RunUseCaseActionGoal, RunUseCaseGoal
from remodel_msgs.srv import CommandRun, CommandTask
from std_msgs.msg import Bool

from remodel_states.edge.exported_tables import read_abilities
from remodel_supervision.ros.action_server import ActionServer, Goal

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
        """Join ROS."""
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
        """Start the first."""
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
