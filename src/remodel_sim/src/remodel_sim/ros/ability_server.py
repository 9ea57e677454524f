"""The action server of one ability: every goal is looked at before anything moves."""

from __future__ import annotations

import traceback
from collections.abc import Sequence

import actionlib
import rospy
from actionlib import ServerGoalHandle
from actionlib_msgs.msg import GoalStatus
from genpy import Message

from remodel_sim.abilities.station import Station
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.goals import Goal, require, require_number
from remodel_sim.core.ownership import owner_of
from remodel_sim.ros.abilities import Ability
from remodel_sim.ros.job import Job, common_result
from remodel_sim.ros.owner import Owner
from remodel_states.core.codes import Code

MAX_TIMEOUT_S = 3600.0
# The fields of goals that name a robot.
ROBOT_FIELDS = ("robot_name", "robot_1_name", "robot_2_name")


class AbilityServer:
    """Takes goals for one ability; a robot does one goal at a time, over all abilities."""

    def __init__(self, ability: Ability, owner: Owner) -> None:
        """Start to listen."""
        self._ability = ability
        self._owner = owner
        self._server = actionlib.ActionServer(
            ability.topic,
            ability.message("Action"),
            lambda handle: owner.post(lambda: self._take(handle)),
            self._cancel,
            auto_start=False,
        )
        self._server.start()

    def _take(self, handle: ServerGoalHandle) -> None:
        message = handle.get_goal()
        if handle.get_goal_status().status == GoalStatus.RECALLING:
            handle.set_canceled(self._refusal(message, Code.PREEMPTED, "cancelled before it began"))
            return
        try:
            self._owner.cell.admit(owner_of(message.id))
            stations = self._stations(message)
            goal = self._checked(message, stations)
        except AbilityError as error:
            self._refuse(handle, error.code, str(error))
            return
        except Exception as error:  # noqa: BLE001 - the owner's thread must live on
            rospy.logerr("%s: %s", self._ability.name, traceback.format_exc())
            self._refuse(handle, Code.INTERNAL, f"{type(error).__name__}: {error}")
            return
        handle.set_accepted()
        now_s, keep = self._owner.clock.now_s, self._owner.cell.keep
        self._owner.jobs.append(Job(self._ability, goal, handle, stations, now_s, keep))

    def _stations(self, message: Message) -> list[Station]:
        """Return the robots that a goal names, or the one that is free for it when it names none.

        Raises UNKNOWN_NAME, or BUSY when one of them does another goal.
        """
        cell = self._owner.cell
        fields = [field for field in ROBOT_FIELDS if field in message.__slots__]
        if fields:
            stations = [cell.station_of(getattr(message, field)) for field in fields]
        else:
            stations = [self._free_station()]
        for station in stations:
            job = self._owner.job_of(station.name)
            if job is not None:
                text = f"{station.name} is doing {job}; wait for it or cancel it"
                raise AbilityError(Code.BUSY, text)
            if station.busy:
                raise AbilityError(
                    Code.BUSY, f"{station.name} is making way for another robot; try again"
                )
        return stations

    def _free_station(self) -> Station:
        """Return a robot for a look: one that does nothing, rather with an empty hand."""

        def rank(station: Station) -> tuple[bool, bool]:
            return station.busy, station.book.grip is not None

        return min(self._owner.cell.stations.values(), key=rank)

    def _checked(self, message: Message, stations: Sequence[Station]) -> Goal:
        """Return the goal of a message; raises AbilityError when it cannot be taken."""
        require(bool(message.id.strip()), "id is empty; it must name the goal")
        require_number("timeout", message.timeout, 0.1, MAX_TIMEOUT_S, "s")
        goal = self._ability.parse(message)
        for station in stations:
            goal.check(station.panel, station.book)
        return goal

    def _refuse(self, handle: ServerGoalHandle, code: Code, text: str) -> None:
        message = handle.get_goal()
        rospy.logwarn(
            "%s (goal %r) refused: %s: %s", self._ability.name, message.id, code.name, text
        )
        handle.set_rejected(self._refusal(message, code, text), text)

    def _refusal(self, message: Message, code: Code, text: str) -> Message:
        result = common_result(self._ability, message.id, 0.0)
        result.message = f"{self._ability.name}: {code.name}"
        result.error_code, result.error_message = int(code), text
        return result

    def _cancel(self, handle: ServerGoalHandle) -> None:
        for job in tuple(self._owner.jobs):
            if job.handle == handle:
                job.cancel()
