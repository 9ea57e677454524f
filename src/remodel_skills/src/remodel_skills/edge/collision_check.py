"""Whether a motion would touch an obstacle, by Bullet's nearest points of a second, still world.

A shadow of the arm, with its meshes and fingers, is put into the postures along a path. Where
nothing is near, the next posture is as far along the path as the free distance allows.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Sequence, Set
from pathlib import Path
from typing import Any

import numpy as np

from remodel_skills.space import HeldTip, Touch
from remodel_work.edge.bullet import add_static, connect
from remodel_work.edge.robot_description import FINGERS, HAND, robot_description
from remodel_work.geometry import Pose, turn_between
from remodel_work.obstacles import WIRES, Obstacles
from remodel_work.robot.arm import Kinematics, ToolPose

# Nearest points are searched for within this distance [m]: more takes longer.
SIGHT_M = 0.015
# Postures are at least so far apart along the path [m]; of the distance that is free, this share
# is used: some of the arm moves faster than the tool.
STEP_M = 0.004
FREE_SHARE = 0.7
# A motion may begin where something is nearer than the clearance, and come this much nearer [m].
NEARER_M = 0.0005
# Within this distance of where it begins and ends, a motion may touch wires: they yield [m].
AMONG_WIRES_M = 0.04
# A part of the robot, what it is near to, and Bullet's nearest points of both, with these fields.
NearPoint = tuple[str, Obstacles, tuple[Any, ...]]
LINK_A, ON_B, DISTANCE = 3, 6, 8


class BulletCollisionCheck:
    """A shadow of an arm among obstacles. Only the thread that made it may use it."""

    def __init__(self, arm: Kinematics, clearance: float) -> None:
        """Load the shadow; `clearance` is kept to every obstacle [m]."""
        self._bullet = connect()
        self._arm, self._clearance = arm, clearance
        base = arm.world_from_base
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "arm.urdf"
            path.write_text(robot_description(arm))
            self._body = self._bullet.loadURDF(
                str(path), base.position.tolist(), base.quaternion.tolist(), useFixedBase=True
            )
        count = self._bullet.getNumJoints(self._body)
        links = [self._bullet.getJointInfo(self._body, i)[12].decode() for i in range(count)]
        self._fingers = [links.index(finger) for finger in FINGERS]
        self._parts = {i: _part(name) for i, name in enumerate(links)}
        self._solids: list[tuple[Obstacles, int]] = []
        self._held: tuple[HeldTip, int] | None = None

    def first_touch(
        self,
        path: Callable[[float], ToolPose],
        length: float,
        *,
        obstacles: Sequence[Obstacles],
        finger_gap: float,
        held: HeldTip | None = None,
        allowed: Set[str] = frozenset(),
    ) -> Touch | None:
        """Return where a path comes too near to an obstacle first; see the port for the arguments.

        What the arm is too near to at the beginning counts only if it comes nearer. Wires count
        only away from both ends of the path: a hand that grasps or inserts works among them.
        """
        self._put_obstacles([each for each in obstacles if each.solids])
        if not self._solids:
            return None
        self._put_held(held)
        half = [[finger_gap / 2]] * 2
        self._bullet.resetJointStatesMultiDof(self._body, self._fingers, half)
        length = max(length, STEP_M)
        share, tool = 0.0, path(0.0)
        least, points = STEP_M / length, self._points(tool)
        at_first = {pair: gap - NEARER_M for pair, gap in self._too_near(points, allowed).items()}
        while share < 1.0:
            gap = min((point[DISTANCE] for _, _, point in points), default=SIGHT_M)
            share = min(1.0, share + max(least, FREE_SHARE * (gap - self._clearance) / length))
            tool = path(share)
            points = self._points(tool)
            is_among = min(share, 1.0 - share) * length < AMONG_WIRES_M
            touchable = allowed | {WIRES} if is_among else allowed
            for (part, solid), gap in self._too_near(points, touchable).items():
                if gap < at_first.get((part, solid), self._clearance):
                    return Touch(part, solid, tool, gap)
        return None

    def _too_near(self, points: list[NearPoint], allowed: Set[str]) -> dict[tuple[str, str], float]:
        """Return what is nearer than the clearance: part and solid, and the gap [m]."""
        gaps: dict[tuple[str, str], float] = {}
        for part, obstacles, point in points:
            if point[DISTANCE] >= self._clearance:
                continue
            pair = part, obstacles.nearest(np.array(point[ON_B]))
            if pair[1] not in allowed:
                gaps[pair] = min(gaps.get(pair, self._clearance), point[DISTANCE])
        return gaps

    def _points(self, tool: ToolPose) -> list[NearPoint]:
        """Return Bullet's nearest points within SIGHT_M at a tool pose, each with the part."""
        joints = self._arm.joints_for(tool)
        indices = list(range(len(joints)))
        self._bullet.resetJointStatesMultiDof(self._body, indices, [[v] for v in joints])
        found = [
            (self._parts[point[LINK_A]], obstacles, point)
            for obstacles, solid in self._solids
            for point in self._bullet.getClosestPoints(self._body, solid, SIGHT_M)
            if point[LINK_A] >= 0
        ]
        if self._held is not None:
            held, body = self._held
            self._bullet.resetBasePositionAndOrientation(body, *_held_place(held, tool))
            found += [
                (f"the held end of {held.name!r}", obstacles, point)
                for obstacles, solid in self._solids
                for point in self._bullet.getClosestPoints(body, solid, SIGHT_M)
            ]
        return found

    def _put_obstacles(self, wanted: Sequence[Obstacles]) -> None:
        """Put the wanted obstacles there, a body each, and take the others away."""
        for _, solid in [there for there in self._solids if there[0] not in wanted]:
            self._bullet.removeBody(solid)
        self._solids = [there for there in self._solids if there[0] in wanted]
        known = [obstacles for obstacles, _ in self._solids]
        for obstacles in [each for each in wanted if each not in known]:
            boxes = [solid.box for solid in obstacles.solids]
            body = add_static(self._bullet, boxes, Pose.level(0.0, 0.0, 0.0))
            self._solids.append((obstacles, body))

    def _put_held(self, held: HeldTip | None) -> None:
        if self._held is not None and self._held[0] == held:
            return
        if self._held is not None:
            self._bullet.removeBody(self._held[1])
        self._held = None
        if held is not None:
            length = max(held.distance - 2 * held.radius, 1e-4)
            shape = self._bullet.createCollisionShape(
                self._bullet.GEOM_CAPSULE, radius=held.radius, height=length
            )
            self._held = held, self._bullet.createMultiBody(0.0, shape)

    def close(self) -> None:
        """Leave PyBullet."""
        self._bullet.disconnect()


def _held_place(held: HeldTip, tool: ToolPose) -> tuple[list[float], list[float]]:
    """Return where the capsule of a held end is, position and quaternion; it lies along its z."""
    yaw = tool.yaw + held.flip
    along = np.array([math.cos(yaw), math.sin(yaw), 0.0])
    middle = tool.position + held.distance / 2 * along + np.array([0.0, 0.0, held.height])
    return middle.tolist(), turn_between(np.array([0.0, 0.0, 1.0]), along).tolist()


def _part(link: str) -> str:
    """Return what people call a link."""
    if link == HAND:
        return "the hand"
    return "a finger" if link in FINGERS else f"the arm's link {link}"
