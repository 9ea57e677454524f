"""The space that a robot claims among the others of its cell."""

from __future__ import annotations

from collections.abc import Collection

from remodel_skills.traffic import Traffic
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.arm_volume import volume_of
from remodel_work.robot.kinematics import Kinematics


class Space:
    """What one robot claims; a cell of one robot has it all."""

    def __init__(
        self, name: str, arm: Kinematics, traffic: Traffic, robots: Collection[str]
    ) -> None:
        """Claim nothing yet; `robots` are the names of all of the cell."""
        self._name, self._arm, self._traffic, self._robots = name, arm, traffic, robots

    def claim(self, postures: Array) -> str | None:
        """Claim the space of a path, (n, joints); return which robot is in the way, if any."""
        if len(self._robots) == 1:
            return None
        return self._traffic.claim(self._name, volume_of(self._arm, postures))

    def take(self, postures: Array) -> None:
        """Claim the space of a path, (n, joints), which its caller has seen to be free."""
        self._traffic.stand(self._name, volume_of(self._arm, postures))

    def has_room(self, tool: ToolPose) -> bool:
        """Return whether no other robot obstructs the arm at a tool pose."""
        return self.has_way(self._arm.joints_for(tool))

    def has_way(self, postures: Array) -> bool:
        """Return whether no other robot obstructs the arm in postures, (joints,) or (n, joints)."""
        if len(self._robots) == 1:
            return True
        return self._traffic.in_the_way(self._name, volume_of(self._arm, postures)) is None

    def check(self, tool: ToolPose, now_at: ToolPose) -> None:
        """Raise ROBOT_IN_THE_WAY when another robot obstructs the arm at a tool pose."""
        if len(self._robots) > 1:
            here = volume_of(self._arm, self._arm.joints_for(tool))
            other = self._traffic.in_the_way(self._name, here)
            if other is not None:
                raise AbilityError(
                    Code.ROBOT_IN_THE_WAY,
                    f"{other} is in the way of {self._name}, which stands at {now_at}",
                )

    def stand(self, tool: ToolPose) -> None:
        """Release all claimed space but that of the arm at a tool pose."""
        self._traffic.stand(self._name, volume_of(self._arm, self._arm.joints_for(tool)))

    def wait_for(self, other: str | None) -> None:
        """Note which robot this one waits for."""
        self._traffic.waits_for.pop(self._name, None)
        if other is not None:
            self._traffic.waits_for[self._name] = other

    def waits_for(self, other: str) -> bool:
        """Return whether the robot waits for another one."""
        return self._traffic.waits_for.get(self._name) == other
