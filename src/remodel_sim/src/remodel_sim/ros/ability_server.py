"""The action server of one ability: every goal is looked at before anything moves."""

from __future__ import annotations

import traceback

import actionlib
import rospy
from actionlib import ServerGoalHandle
from actionlib_msgs.msg import GoalStatus
from genpy import Message

from remodel_sim.core.codes import Code
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.goals import Goal, require, require_number
from remodel_sim.ros.abilities import Ability
from remodel_sim.ros.job import Job, common_result
from remodel_sim.ros.owner import Owner

MAX_TIMEOUT_S = 3600.0


class AbilityServer:
    """Takes goals for one ability; the robot does one goal at a time, over all abilities."""

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
        station = self._owner.cell.station
        try:
            if self._owner.job is not None:
                raise AbilityError(
                    Code.BUSY, f"the robot is doing {self._owner.job}; wait for it or cancel it"
                )
            goal = self._checked(message)
        except AbilityError as error:
            self._refuse(handle, error.code, str(error))
            return
        except Exception as error:  # noqa: BLE001 - the owner's thread must live on
            rospy.logerr("%s: %s", self._ability.name, traceback.format_exc())
            self._refuse(handle, Code.INTERNAL, f"{type(error).__name__}: {error}")
            return
        handle.set_accepted()
        self._owner.job = Job(self._ability, goal, handle, station, self._owner.clock.now_s)

    def _checked(self, message: Message) -> Goal:
        """Return the goal of a message; raises AbilityError when it cannot be taken."""
        require(bool(message.id.strip()), "id is empty; it must name the goal")
        require_number("timeout", message.timeout, 0.1, MAX_TIMEOUT_S, "s")
        goal = self._ability.parse(message)
        station = self._owner.cell.station
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
        job = self._owner.job
        if job is not None and job.handle == handle:
            job.cancel()
