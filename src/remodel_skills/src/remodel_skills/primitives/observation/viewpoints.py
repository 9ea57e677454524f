"""Viewpoints: tool poses from which the wrist camera sees what an ability searches for."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from remodel_skills.primitives.motions import TRAVEL_Z, nearest_hand_yaw
from remodel_skills.robot_context import RobotContext
from remodel_states.core.codes import Code
from remodel_work.camera import Lens, View
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose, wrap_angle
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.fingers import CAMERA_MOUNT, PANDA_FINGERS

# The tool's height for an observation from the hand: the lens is 84 mm above the tool centre of
# the Panda's fingers.
CAMERA_Z = 0.12
# Places of the wrist camera beside a hidden end, x and y [m]: the lens is some 0.2 m high, where a
# wire 50 mm high moves by a third of that in the picture. Wires leave their terminals along x, so
# it is tried along y first.
ASIDE_M = ((0.0, 0.07), (0.0, -0.07), (0.07, 0.0), (-0.07, 0.0))
# The same beside a label, which lies nearer to the lens and stays in the picture so far.
LABEL_ASIDE_M = ((0.0, 0.045), (0.0, -0.045), (0.045, 0.0), (-0.045, 0.0))
DIAGONALS = ((1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0))
# Turns of a hand that holds a wire, for an observation of a component that it need not go to [rad].
EITHER_WAY = np.radians([0.0, 45.0, -45.0, 90.0, -90.0])
# A label that is hidden from one place of the lens is searched for from others, so far apart [m].
VIEWS_APART_M = 0.05
MAX_VIEWS = 4
# Another view with a wire in the hand begins so many of these places further on.
VIEWS_PER_OBSERVATION = 2
BORDER_PX = 30.0


@dataclass(frozen=True)
class Ring:
    """Places of the wrist camera around a point.

    Attributes:
        beside: x and y from the point, the best first [m].
        z: the tool's height with the Panda's fingers [m].
    """

    beside: tuple[tuple[float, float], ...]
    z: float


def _rings(aside: tuple[tuple[float, float], ...], far: float) -> tuple[Ring, ...]:
    """Return the views of a point: around it, diagonally from higher up, and further off.

    Each view sees past other obstacles; the higher ones stay in the picture further aside.
    """
    diagonal, reach = far * 0.6, far / max(max(place) for place in aside)
    return (
        Ring(((0.0, 0.0), *aside), CAMERA_Z),
        Ring(tuple((diagonal * x, diagonal * y) for x, y in DIAGONALS), 0.17),
        Ring(tuple((reach * x, reach * y) for x, y in aside), 0.20),
    )


# By the number of the view.
END_VIEWS = _rings(ASIDE_M, 0.10)
LABEL_VIEWS = _rings(LABEL_ASIDE_M, 0.075)


def views_around(
    context: RobotContext,
    point: Array,
    yaw: float,
    views: Sequence[Ring] = END_VIEWS,
    view: int = 0,
) -> list[ToolPose]:
    """Return tool poses that bring the wrist camera over a point (2,) [m], or beside it.

    `view` is taken modulo the number of views.
    """
    ring = views[view % len(views)]
    tools = [camera_above(context, point + aside, yaw, ring.z) for aside in ring.beside]
    return [tool for tool in tools if context.arm.reaches(tool)] or tools[:1]


def camera_above(context: RobotContext, point: Array, yaw: float, z: float = CAMERA_Z) -> ToolPose:
    """Return the tool pose that brings the wrist camera over a point (2,) [m].

    Args:
        context: of the robot that observes; a pose with room beside other robots is preferred.
        point: to be seen in the middle of the picture, world frame.
        yaw: preferred direction of the hand's x axis [rad]; turned by pi, or square to it, if
            need be.
        z: the tool's height with the Panda's fingers [m]; with longer ones the lens stays there.
    """
    z -= context.fingers.tool_m - PANDA_FINGERS.tool_m
    arm, near_yaw = context.arm, context.commanded.yaw
    reached = []
    for turn in (0.0, math.pi / 2):
        near = nearest_hand_yaw(arm, float(point[0]), float(point[1]), yaw + turn, near=near_yaw)
        for candidate in (near, near + math.pi):
            x, y = point - _camera_offset(candidate)
            tool = ToolPose(float(x), float(y), z, candidate)
            if arm.reaches(tool):
                reached.append(tool)
    if reached:
        return min(reached, key=lambda tool: not context.space.has_room(tool))
    x, y = point - _camera_offset(yaw)
    return ToolPose(float(x), float(y), z, yaw)


def _camera_offset(yaw: float) -> Array:
    """Return the lens's place from the tool axis for a hand yaw, (2,) [m].

    The hand's y axis points to its right.
    """
    x, y, _ = CAMERA_MOUNT
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([x * c + y * s, x * s - y * c])


def component_views(
    context: RobotContext, target: Array, socket_yaw: float | None, view: int = 0
) -> list[ToolPose]:
    """Return tool poses from which the wrist camera should see a component, the nearest first.

    Several, since a wire in the air may hide it from one of them. The empty hand goes
    straight over it, or beside it. With a wire in the hand the tool moves as little as it can and
    turns only the way it will turn to the socket: the wire may be fixed at its other end, and one
    that is bent away from where it goes twists out of the fingers.

    Args:
        context: the cell.
        target: corners of its label or its top, (4, 3) [m], world frame.
        socket_yaw: direction of the opening that a held end goes into [rad], world frame; None if
            that is not known.
        view: 0 for the usual places, more for others.

    Raises:
        AbilityError: UNREACHABLE when no posture sees it.
    """
    grip, now = context.belief.grip, context.commanded
    if grip is None:
        return views_around(context, target.mean(axis=0)[:2], 0.0, LABEL_VIEWS, view=view)
    turns = EITHER_WAY
    if socket_yaw is not None:
        turns = np.linspace(0.0, wrap_angle(socket_yaw - grip.flip - now.yaw), 5)
    views: list[ToolPose] = []
    for tool in _held_views(context, target, turns):
        if all(_lenses_apart(tool, other) >= VIEWS_APART_M for other in views):
            views.append(tool)
    if not views:
        raise AbilityError(
            Code.UNREACHABLE,
            f"from {now} no motion of up to 160 mm brings the component into the wrist camera's "
            "view; "
            "route the wire nearer to the component first",
        )
    first = view * VIEWS_PER_OBSERVATION % len(views)
    return [*views[first:], *views[:first]][:MAX_VIEWS]


def _held_views(context: RobotContext, target: Array, turns: Array) -> list[ToolPose]:
    """Return the tool poses near the hand's that bring a component into view, the nearest first."""
    now, lens = context.commanded, context.cameras.wrist_view.lens
    above = context.fingers.tool_m - CAMERA_MOUNT[2]
    looks: list[tuple[float, ToolPose]] = []
    for turn in turns:
        for dx in np.arange(-0.06, 0.061, 0.02):
            for dy in np.arange(-0.16, 0.161, 0.02):
                yaw = context.arm.canonical_yaw(now.x + dx, now.y + dy, now.yaw + turn)
                tool = ToolPose(now.x + dx, now.y + dy, TRAVEL_Z, now.yaw + turn)
                if yaw is None or abs(yaw - tool.yaw) > 1e-6 or not context.arm.reaches(tool):
                    continue
                if _view_from(tool, lens, above).sees(target, BORDER_PX):
                    looks.append((math.hypot(dx, dy) + 0.08 * abs(turn), tool))
    return [tool for _, tool in sorted(looks, key=lambda look: look[0])]


def _lenses_apart(first: ToolPose, second: ToolPose) -> float:
    places = [np.array([tool.x, tool.y]) + _camera_offset(tool.yaw) for tool in (first, second)]
    return float(np.linalg.norm(places[0] - places[1]))


def _view_from(tool: ToolPose, lens: Lens, above: float) -> View:
    """Return the wrist camera's view from a tool pose; the lens is `above` the tool [m]."""
    offset = _camera_offset(tool.yaw)
    c, s = math.cos(tool.yaw / 2), math.sin(tool.yaw / 2)
    # A hand that points down: half a turn about x, then its yaw.
    down = np.array([c, s, 0.0, 0.0])
    position = np.array([tool.x + offset[0], tool.y + offset[1], tool.z + above])
    return View(lens, Pose(position, down))
