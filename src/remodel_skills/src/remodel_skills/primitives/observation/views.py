"""Where an observation is made from: tool poses, clear sight, and what they show of a component."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from remodel_skills.parameters import LookingParameters
from remodel_skills.primitives.motions import move_to, nearest_hand_yaw, rise
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.device_pose import (
    ComponentObservation,
    DeviceView,
    locate_device,
    search_device,
)
from remodel_vision.label_pose import LabelView, locate_component
from remodel_vision.labels import find_labels, search_label
from remodel_vision.panel_pose import register_panel
from remodel_work.camera import Lens, Picture, View
from remodel_work.component_shape import label_corners
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose, wrap_angle
from remodel_work.panel import Component
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.arm_volume import Volume, gap_between, volume_of
from remodel_work.robot.fingers import CAMERA_MOUNT, PANDA_FINGERS


@dataclass(frozen=True)
class Ring:
    """Places of the wrist camera around a point.

    Attributes:
        beside: x and y from the point, the best first [m].
        z: the tool's height with the Panda's fingers [m].
    """

    beside: tuple[tuple[float, float], ...]
    z: float


def _rings(
    looking: LookingParameters, aside: tuple[tuple[float, float], ...], far: float
) -> tuple[Ring, ...]:
    """Return the views of a point: around it, diagonally from higher up, and further off.

    Each view sees past other obstacles; the higher ones stay in the picture further aside.
    """
    diagonal, reach = far * looking.diagonal_share, far / max(max(place) for place in aside)
    diagonals = ((1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0))
    return (
        Ring(((0.0, 0.0), *aside), looking.camera_z_m),
        Ring(tuple((diagonal * x, diagonal * y) for x, y in diagonals), looking.diagonal_z_m),
        Ring(tuple((reach * x, reach * y) for x, y in aside), looking.far_z_m),
    )


def views_around(
    context: RobotContext,
    point: Array,
    yaw: float,
    views: Sequence[Ring] | None = None,
    view: int = 0,
) -> list[ToolPose]:
    """Return tool poses that bring the wrist camera over a point (2,) [m], or beside it.

    `view` is taken modulo the number of views; None: those of an end.
    """
    looking = context.parameters.looking
    views = views or _rings(looking, looking.end_aside_m, looking.end_far_m)
    ring = views[view % len(views)]
    tools = [camera_above(context, point + aside, yaw, ring.z) for aside in ring.beside]
    return [tool for tool in tools if context.arm.reaches(tool)] or tools[:1]


def camera_above(
    context: RobotContext, point: Array, yaw: float, z: float | None = None
) -> ToolPose:
    """Return the tool pose that brings the wrist camera over a point (2,) [m].

    Args:
        context: of the robot that observes; a pose with room beside other robots is preferred.
        point: to be seen in the middle of the picture, world frame.
        yaw: preferred direction of the hand's x axis [rad]; turned by pi, or square to it, if
            need be.
        z: the tool's height with the Panda's fingers [m]; with longer ones the lens stays there;
            None: for an observation from the hand.
    """
    z = context.parameters.looking.camera_z_m if z is None else z
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
    grip, now, looking = context.belief.grip, context.commanded, context.parameters.looking
    if grip is None:
        least = _least_z(context, target)
        rings = _rings(looking, looking.label_aside_m, looking.label_far_m)
        rings = tuple(replace(ring, z=max(ring.z, least)) for ring in rings)
        return views_around(context, target.mean(axis=0)[:2], 0.0, rings, view=view)
    turns = np.array(looking.held_turns_rad)
    if socket_yaw is not None:
        turns = np.linspace(
            0.0, wrap_angle(socket_yaw - grip.flip - now.yaw), looking.held_turn_steps
        )
    views: list[ToolPose] = []
    for tool in _held_views(context, target, turns):
        if all(_lenses_apart(tool, other) >= looking.views_apart_m for other in views):
            views.append(tool)
    if not views:
        raise AbilityError(
            Code.UNREACHABLE,
            f"from {now} no motion of up to "
            f"{max(looking.held_reach_m) * 1e3:.0f} mm brings the component into the wrist "
            "camera's view; route the wire nearer to the component first",
        )
    first = view * looking.views_per_observation % len(views)
    return [*views[first:], *views[:first]][: looking.most_views]


def _least_z(context: RobotContext, target: Array) -> float:
    """Return how high the tool is for a picture of a whole label or device [m].

    That is with the Panda's fingers; with longer ones the lens stays there. A long device is found
    by both its ends: between them its screws repeat.

    Args:
        context: the cell.
        target: what of it is to be in the picture, (n, 3) [m].
    """
    lens, looking = context.cameras.wrist_view.lens, context.parameters.looking
    half = float(np.abs(target - target.mean(axis=0))[:, :2].max())
    if not context.cell.labels:
        half /= looking.device_in_view_share
    above = half * lens.focal_px / (min(lens.width, lens.height) / 2 - looking.border_px)
    return float(target[:, 2].max()) + above - (PANDA_FINGERS.tool_m - CAMERA_MOUNT[2])


def _held_views(context: RobotContext, target: Array, turns: Array) -> list[ToolPose]:
    """Return the tool poses near the hand's that bring a component into view, the nearest first."""
    now, lens = context.commanded, context.cameras.wrist_view.lens
    above = context.fingers.tool_m - CAMERA_MOUNT[2]
    looking = context.parameters.looking
    least = _least_z(context, target) - (context.fingers.tool_m - PANDA_FINGERS.tool_m)
    z = max(context.parameters.motion.travel_z_m, least)
    (far_x, far_y), step = looking.held_reach_m, looking.held_step_m
    looks: list[tuple[float, ToolPose]] = []
    for turn in turns:
        for dx in np.arange(-far_x, far_x + step / 20, step):
            for dy in np.arange(-far_y, far_y + step / 20, step):
                yaw = context.arm.canonical_yaw(now.x + dx, now.y + dy, now.yaw + turn)
                tool = ToolPose(now.x + dx, now.y + dy, z, now.yaw + turn)
                if yaw is None or abs(yaw - tool.yaw) > 1e-6 or not context.arm.reaches(tool):
                    continue
                if _view_from(tool, lens, above).sees(target, looking.border_px):
                    looks.append((math.hypot(dx, dy) + looking.held_turn_cost_m * abs(turn), tool))
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


def clear_sight(context: RobotContext, points: Array) -> Steps[None]:
    """Move the empty hand out of the overhead camera's lines of sight to points (n, 3) [m].

    Raises:
        AbilityError: UNREACHABLE when no place was found.
    """
    if _sees_past(context, context.commanded, points):
        return
    yield from rise(context, context.parameters.looking.aside_z_m)
    for place in _aside(context, points):
        if _sees_past(context, place, points) and _has_room(context, place):
            try:
                yield from move_to(context, place, context.parameters.motion.free_speed_m_s)
            except AbilityError as error:
                if error.code is not Code.UNREACHABLE:
                    raise
            else:
                return
    raise AbilityError(
        Code.UNREACHABLE,
        f"{context.name} finds no place from which it does not hide the board from the overhead "
        f"camera; it stands at {context.commanded}",
    )


def _aside(context: RobotContext, points: Array) -> Iterator[ToolPose]:
    """Yield tool poses beside points that the robot reaches, the nearest first."""
    looking = context.parameters.looking
    now, middle = context.commanded, points.mean(axis=0)
    reach = float(np.linalg.norm((points - middle)[:, :2], axis=1).max())
    for away in looking.out_of_sight_m:
        for angle in np.arange(looking.aside_directions) * (2 * math.pi / looking.aside_directions):
            x = float(middle[0] + (reach + away) * math.cos(angle))
            y = float(middle[1] + (reach + away) * math.sin(angle))
            place = ToolPose(x, y, max(looking.aside_z_m, now.z), now.yaw)
            if context.arm.reaches(place):
                yield place


def _sees_past(context: RobotContext, place: ToolPose, points: Array) -> bool:
    eye = context.cameras.overhead_view(points).world_from_camera.position
    lines = Volume(
        np.tile(eye, (len(points), 1)),
        points,
        np.full(len(points), context.parameters.looking.sight_radius_m),
    )
    return gap_between(volume_of(context.arm, context.arm.joints_for(place)), lines) > 0


def _has_room(context: RobotContext, place: ToolPose) -> bool:
    here = volume_of(context.arm, context.arm.joints_for(place))
    others = [volume_of(c.arm, c.arm.joints_for(c.commanded)) for c in context.peers]
    return all(
        gap_between(here, other) > context.parameters.motion.robots_apart_m for other in others
    )


class ComponentViews:
    """The pictures that show one component well.

    Attributes:
        component: that is searched for.
    """

    def __init__(self, context: RobotContext, component: Component) -> None:
        """Begin without pictures."""
        self._context = context
        self.component = component
        self._labels: list[LabelView] = []
        self._devices: list[DeviceView] = []

    def __len__(self) -> int:
        """Return the number of pictures."""
        return len(self._labels) + len(self._devices)

    def add(self, picture: Picture, near: Pose) -> ComponentObservation | None:
        """Locate the component by a picture and the earlier ones; None: this one is left out.

        Args:
            picture: that may show it.
            near: about where it stands, world frame.
        """
        component, panel = self.component, self._context.panel
        if not self._context.cell.labels:
            device = search_device(picture, panel, component, near)
            if device is None:
                return None
            devices = [*self._devices, device]
            observation = locate_device(component, devices)
            self._devices = devices if observation.clear else self._devices
            return observation if observation.clear else None
        corners = find_labels(picture, panel.components).get(component.marker_id)
        if corners is None and picture.view.sees(near.apply(label_corners(component)), 0.0):
            corners = search_label(picture, component, near)
        if corners is None:
            return None
        labels = [*self._labels, LabelView(picture, corners)]
        observation = locate_component(component, labels)
        self._labels = labels if observation.clear else self._labels
        return observation if observation.clear else None


def to_be_seen(context: RobotContext, component: Component) -> Array:
    """Return what of a component pictures should show, (4, 3) [m], component frame."""
    if context.cell.labels:
        return label_corners(component)
    depth, width, height = component.size
    corners = np.array([[-depth, width], [depth, width], [depth, -width], [-depth, -width]])
    return np.column_stack(
        [context.parameters.looking.device_in_view_share * corners / 2, np.full(4, height)]
    )


def expected_place(context: RobotContext, component: Component) -> Pose:
    """Return where a component should stand, world frame.

    In a cell without labels it follows from where the panel lies, by the camera from above.
    """
    if context.cell.labels:
        return context.panel.world_from_panel @ component.panel_from_component
    if not context.belief.panel_at:
        drawn = context.panel.world_from_panel @ component.panel_from_component
        find_panel(context, context.cameras.take_overhead_picture(drawn.position[None]))
    return context.belief.panel_at[-1] @ component.panel_from_component


def find_panel(context: RobotContext, picture: Picture) -> None:
    """Note where the panel lies, by a picture with depth from above.

    Raises COMPONENT_NOT_FOUND when it does not show the panel.
    """
    found = register_panel(picture, context.panel)
    if found is None:
        raise AbilityError(
            Code.COMPONENT_NOT_FOUND,
            f"the depth camera does not show panel {context.panel.name!r} within 12 mm and 3 deg "
            "of its place; put it there, and clear the view",
        )
    context.belief.panel_at[:] = [found]
