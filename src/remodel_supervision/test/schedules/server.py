"""A simulated ability server."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

from remodel_msgs.msg import ErrorCode

from remodel_states.core.ability_error import AbilityError
from remodel_states.core.contract import owner_of
from remodel_states.serving import admitted
from remodel_states.testing.faults import Behaves, InjectedFault, at_goal
from remodel_states.testing.operations import operation_of, perform
from remodel_supervision.core.run import Operation
from schedules.node import Node
from schedules.simulation import Simulation
from schedules.site import Motion, Site

# [s] between two reports of an idle server.
_REPORT_S = 0.2

# [s] that an operation takes.
_TAKES_S = (0.3, 2.5)

# Goals of one owner for a server that is down, after which no client waits for it any more: the one
# under way when it was lost or the first after a restart of the engine, and one that tries again.
_MISSES = 3


@dataclass
class Goal:
    """A goal of any ability."""

    id: str = ""
    cable_id: str = ""
    cable_end: str = ""
    component_id: str = ""
    terminal_id: str = ""
    robot_name: str = "robot_1"
    force_limit: float = 10.0
    pull_test_force: float = 5.0
    grasp_distance: float = 0.0
    view: int = 0
    timeout: float = 10.0
    path: tuple[int, ...] = (0,)


@dataclass(frozen=True)
class Result:
    """How a goal ended: code 0 and success, or not."""

    success: bool
    code: int
    text: str = ""
    found: dict[str, object] = field(default_factory=dict)
    refused: bool = False


Reply = Callable[[Result], None]


@dataclass
class _Job:
    goal: Goal
    reply: Reply
    motion: Motion
    fault: InjectedFault | None
    found: dict[str, object] = field(default_factory=dict)
    is_over: bool = False


class Server(Node):
    """Serves one ability of one cell.

    Attributes:
        listeners: called with each motion that has ended, and its result.
    """

    def __init__(self, simulation: Simulation, site: Site, station: str, cell: str, ability: str):
        super().__init__(simulation, f"{station}/{ability}")
        self.ability = ability
        self.listeners: list[Callable[[Motion, Operation], None]] = []
        self._site = site
        self._station = station
        self._cell = cell
        self._job: _Job | None = None
        self._changed_s = 0.0
        self._phase_s = simulation.random.uniform(0.0, _REPORT_S)
        self._missed: Counter[int] = Counter()

    @property
    def is_busy(self) -> bool:
        return self._job is not None

    def rests(self, since_s: float, owner: int | None = None) -> bool:
        """Return whether it has reported since then [s] that it rests, or serves another owner."""
        heard_s = self.heard_s - 0.003
        tick_s = self.reported_s(heard_s - math.fmod(heard_s + self._phase_s, _REPORT_S))
        is_foreign = self._job is not None and owner not in (None, self._job.motion.owner)
        if self._changed_s <= heard_s:
            return (self._job is None or is_foreign) and max(tick_s, self._changed_s) >= since_s
        # What it does now it began, or ended, after its last report.
        return self._job is not None and tick_s >= since_s

    def miss(self, goal: Goal) -> None:
        """Count a goal that was sent while this server was down; its sender is to wait for it."""
        owner = owner_of(goal.id)
        self._missed[owner] += 1
        if self._missed[owner] >= _MISSES:
            self.simulation.violated(
                f"{goal.id} is one of {_MISSES} goals for a server that is down"
            )

    def on_goal(self, goal: Goal, reply: Reply) -> None:
        site = self._site
        if site.locks.get(self._cell) is not None:
            reply(Result(False, ErrorCode.BUSY, "the robot is busy", refused=True))
            return
        operation = operation_of(self.ability)
        try:
            site.admit(self._cell, owner_of(goal.id))
            operation.check(site.world, self._cell, goal)
        except AbilityError as error:
            self.simulation.note(self.name, "refuses {}: {}", goal.id, error)
            reply(Result(False, error.code, str(error), refused=True))
            return
        included = operation.includes(site.world, self._cell, goal)
        site.faults, fault = at_goal(site.faults, self.ability, goal, included)
        self._begin(goal, reply, fault)

    def _begin(self, goal: Goal, reply: Reply, fault: InjectedFault | None) -> None:
        owner = owner_of(goal.id)
        motion = Motion(
            self._station,
            self._cell,
            owner,
            f"{self.ability} {goal.id}",
            wire=goal.cable_id,
            begun_s=self.simulation.now_s,
        )
        self.simulation.note(self.name, "begins {}{}", goal.id, f", {fault.name}" if fault else "")
        self._job = job = _Job(goal, reply, motion, fault)
        self._changed_s = self.simulation.now_s
        self._site.locks[self._cell] = job
        self._site.begin(motion)
        random = self.simulation.random
        takes_s = random.uniform(*_TAKES_S)
        behaves = fault.behaves if fault else None
        happens = behaves is None or random.random() < 0.5
        effect_s = random.uniform(0.0, takes_s)
        self.deliver(effect_s, self._take_effect, job, happens, takes_s - effect_s)
        self.deliver(goal.timeout, self._time_out, job)

    def _take_effect(self, job: _Job, happens: bool, left_s: float) -> None:
        if job.is_over:
            return
        site, goal, fault = self._site, job.goal, job.fault
        behaves = fault.behaves if fault else None
        try:
            if happens:
                admitted(site.owners, self._cell, owner_of(goal.id))
                code = fault.code if fault and behaves is None else 0
                effect = perform(self.ability, site.world, self._cell, goal, code=code)
                site.world = effect.world
                job.found = dict(effect.found)
                for entry in effect.entries:
                    site.write(entry)
        except AbilityError as error:
            self._end(job, Result(False, error.code, str(error)))
            return
        if behaves is Behaves.DIES:
            self.kill(self.simulation.random.uniform(0.5, 3.0))
        elif behaves is not Behaves.HANGS:
            self.deliver(left_s, self._complete, job)

    def _complete(self, job: _Job) -> None:
        fault = job.fault
        if fault is None:
            self._end(job, Result(True, 0, "done", job.found))
        elif fault.behaves is Behaves.CONTRADICTS:
            self._end(job, Result(True, ErrorCode.INTERNAL, fault.name))
        else:
            self._end(job, Result(False, fault.code, f"{fault.name}, strike {fault.struck}"))

    def _time_out(self, job: _Job) -> None:
        if not (job.fault and job.fault.behaves is Behaves.HANGS):
            self._end(job, Result(False, ErrorCode.TIMEOUT, "not done in time"))

    def on_cancel(self, goal_id: str = "", owner: int | None = None) -> None:
        """Cancel a goal, an owner's, or whatever there is; the arm stops a little later."""
        job = self._job
        if job is None or owner not in (None, job.motion.owner):
            return
        if goal_id in ("", job.goal.id):
            stopped = Result(False, ErrorCode.PREEMPTED, "cancelled")
            self.deliver(self.simulation.random.uniform(0.0, 0.4), self._end, job, stopped)

    def _end(self, job: _Job, result: Result) -> None:
        if job.is_over:
            return
        self._release(job)
        self.simulation.note(self.name, "ended {}: {} {}", job.goal.id, result.code, result.text)
        self._site.on_result(job.motion, result.code)
        job.reply(result)
        self._publish(job, result)

    def _publish(self, job: _Job, result: Result) -> None:
        """Publish a result to the subscribers of its topic."""
        now_s = self.simulation.now_s
        took_s = now_s - job.motion.begun_s
        text, goal_id = result.text, job.goal.id
        heard = Operation(
            "",
            self.ability,
            "",
            result.code,
            text=text,
            ended_s=now_s,
            elapsed_s=took_s,
            goal_id=goal_id,
        )
        for listener in self.listeners:
            self.simulation.after(self.simulation.latency_s(), listener, job.motion, heard)

    def _release(self, job: _Job) -> None:
        job.is_over = True
        self._job = None
        self._changed_s = self.simulation.now_s
        self._site.locks[self._cell] = None
        self._site.end(job.motion)

    def died(self) -> None:
        """Stop, and free the robot."""
        if self._job is not None:
            self._release(self._job)
        self._changed_s = self.simulation.now_s

    def restarted(self) -> None:
        """Report the first time."""
        self._changed_s = self.simulation.now_s
        self._missed.clear()
