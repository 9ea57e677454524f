"""The action server of one ability of a fake cell."""

from __future__ import annotations

import os
import signal
from dataclasses import dataclass
from random import Random

from genpy import Message
from remodel_msgs.msg import ErrorCode

from remodel_states.ability_server import AbilityServer, Done
from remodel_states.core.ability_error import AbilityError
from remodel_states.core.ability_tables import Ability
from remodel_states.core.goal_owner import owner_of
from remodel_states.serving.ownership import admitted
from remodel_states.serving.robot import Robot
from remodel_states.serving.running_goal import RunningGoal
from remodel_states.testing.course import Course, CourseOfGoal
from remodel_states.testing.faults import Behaves, InjectedFault, at_goal
from remodel_states.testing.operations import Effect, operation_of, perform
from remodel_states.testing.panel import result_fields
from remodel_states.testing.robot_lock import RobotLock
from remodel_states.testing.world_file import WorldFile


@dataclass(frozen=True)
class Site:
    """What the processes of a fake cell share.

    Attributes:
        file: the world.
        lock_path: file that the robot's goals lock.
        cell: name of the cell.
        duration_s: [s] wall time that an operation takes, on average.
        seed: of all that is random.
    """

    file: WorldFile
    lock_path: str
    cell: str
    duration_s: float
    seed: int

    def random(self, ability: str, number: int) -> Random:
        """Return the random numbers of an ability's n-th goal."""
        return Random(f"{self.seed} {self.cell} {ability} {number}")

    def admit(self, owner: int) -> None:
        """Check the token of a supervisor, and remember it if it is the newest; 0 is not checked.

        Raises:
            AbilityError: if it is stale.
        """
        if owner:
            with self.file.change() as draft:
                draft.owners = admitted(draft.owners, self.cell, owner)


class CellRobot(Robot):
    """The robot of a fake cell; several processes may serve its abilities."""

    def __init__(self, site: Site) -> None:
        """Take the site's lock."""
        super().__init__()
        self._site, self._file_lock = site, RobotLock(site.lock_path)

    def begin(self, owner: int) -> None:
        """Lock the robot, and check the token."""
        if not self._file_lock.take():
            raise AbilityError(ErrorCode.BUSY, "the robot is doing another goal; wait for it")
        try:
            self._site.admit(owner)
        except BaseException:
            self.end()
            raise

    def end(self) -> None:
        """Free the robot."""
        self._file_lock.free()


class CellAbility(AbilityServer):
    """Serves one ability; the robot does one goal at a time, over all abilities of the cell."""

    def __init__(self, ability: Ability, site: Site) -> None:
        """Start to serve, on the ability's usual topic."""
        self._site = site
        self._operation = operation_of(ability.name)
        self._fault: InjectedFault | None = None
        self._random = Random()
        super().__init__(ability, CellRobot(site))

    def check(self, goal: Message) -> None:
        """Count a goal that can be done, and choose the fault that strikes it, if any."""
        name = self.ability.name
        with self._site.file.change() as draft:
            self._operation.check(draft.world, self._site.cell, goal)
            included = self._operation.includes(draft.world, self._site.cell, goal)
            draft.faults, self._fault = at_goal(draft.faults, name, goal, included)
            number = draft.goals[name] = draft.goals.get(name, 0) + 1
        self._random = self._site.random(name, number)

    def perform(self, running: RunningGoal) -> Done:
        """Do the goal, as far as its fault lets it."""
        fault, random = self._fault, self._random
        course = Course.drawn(random, self._site.duration_s)
        goal = CourseOfGoal(running, course)
        behaves = fault.behaves if fault else None
        happens = behaves is None or random.random() < 0.5
        goal.wait_until(course.effect_s)
        code = fault.code if fault and behaves is None else 0
        effect = self._take_effect(running.goal, code) if happens else None
        if behaves is Behaves.DIES:
            os.kill(os.getpid(), signal.SIGKILL)
        if behaves is Behaves.HANGS:
            goal.hang()
        goal.wait_until(course.end_s)
        if fault and behaves is None:
            raise AbilityError(fault.code, f"{fault.name}, strike {fault.struck}")
        said = effect.said if effect else ""
        found = {**self.ability.fake, **result_fields(effect.found if effect else {})}
        if fault:
            contradiction = {"success": True, "message": said}
            raise AbilityError(ErrorCode.INTERNAL, fault.name, {**found, **contradiction})
        return Done(said, found)

    def _take_effect(self, goal: Message, code: int) -> Effect:
        cell = self._site.cell
        with self._site.file.change() as draft:
            admitted(draft.owners, cell, owner_of(goal.id))  # it may have lost the cell since
            effect = perform(self.ability.name, draft.world, cell, goal, code=code)
            draft.world = effect.world
            draft.entries += effect.entries
        return effect
