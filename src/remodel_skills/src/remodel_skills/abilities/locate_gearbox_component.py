"""LocateGearboxComponent: find a component by its label or shape, from above and from the hand."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from remodel_skills.abilities.ability import ability
from remodel_skills.goal_checks import Message
from remodel_skills.goals import LocateGoal
from remodel_skills.primitives.motions import disengage, park
from remodel_skills.primitives.observation.observing import go_and_see
from remodel_skills.primitives.observation.views import (
    ComponentViews,
    component_views,
    expected_place,
    find_panel,
    to_be_seen,
)
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.colour import ORANGE, Drawing
from remodel_vision.device_pose import ComponentObservation, stands_there
from remodel_work.camera import Picture
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import Component, unit_x


@dataclass(frozen=True, eq=False)
class ComponentLocated:
    """A component as seen.

    Attributes:
        message: for a person.
        component_pose: its frame in the world.
        socket_pose: the frame of the requested terminal's opening; None when none was requested.
        residual: RMS distance of the edges seen, of the label or the device, from those of the
            pose [m].
    """

    message: str
    component_pose: Pose
    socket_pose: Pose | None
    residual: float


def _goal(message: Message, board: Pose) -> LocateGoal:
    return LocateGoal(message.component_id, message.terminal_id, message.view)


@ability("LocateGearboxComponent", _goal)
def locate_gearbox_component(context: RobotContext, goal: LocateGoal) -> Steps[ComponentLocated]:
    """Observe the component from above when the hand is empty, then with the wrist camera.

    Without labels, the view from above shows where the panel lies, and that a device stands there.
    The answer is what the hand's camera saw from two places; one is enough with a wire in the hand.
    """
    component = context.panel.component(goal.component_id)
    yield from disengage(context)
    code, above = Code.COMPONENT_OCCLUDED, None
    if context.belief.grip is None:
        context.report("observing from above", 0.05)
        yield from park(context)
        drawn = context.panel.world_from_panel @ component.panel_from_component
        above = context.cameras.take_overhead_picture(drawn.position[None])
        yield
        if not context.cell.labels:
            find_panel(context, above)
    coarse = expected_place(context, component)
    if above is not None and context.cell.labels:
        seen = _see(context, "overhead", above, ComponentViews(context, component), goal, coarse)
        code = Code.COMPONENT_NOT_FOUND if seen is None else code
        coarse = coarse if seen is None else seen.world_from_component
    context.report("observing from the hand", 0.4)
    observation = yield from _observe_from_hand(context, component, goal, coarse)
    if above is not None and not context.cell.labels:
        place = coarse if observation is None else observation.world_from_component
        if not stands_there(above, component, place):
            code, observation = Code.COMPONENT_NOT_FOUND, None
    if observation is None:
        raise AbilityError(
            code,
            f"{_what(context, component)} is not seen, or not well, near "
            f"{coarse.position[0] * 1e3:.0f}, {coarse.position[1] * 1e3:.0f} mm",
        )
    pose = observation.world_from_component
    context.belief.seen[component.id] = pose
    socket = None
    if goal.terminal_id:
        socket = pose @ component.terminal(goal.terminal_id).component_from_socket
        _check_level(component, socket, context.parameters.terminal.level_rad)
    x, y, _ = pose.position
    message = (
        f"{component.id} located at x {x * 1e3:.1f}, y {y * 1e3:.1f} mm, "
        f"{math.degrees(pose.yaw):.2f} deg"
    )
    return ComponentLocated(message, pose, socket, observation.residual)


def _observe_from_hand(
    context: RobotContext, component: Component, goal: LocateGoal, coarse: Pose
) -> Steps[ComponentObservation | None]:
    """Return what the wrist camera observes; None when that is not clear or not certain."""
    target, goes_to = coarse.apply(to_be_seen(context, component)), None
    if goal.terminal_id:
        goes_to = (coarse @ component.terminal(goal.terminal_id).component_from_socket).yaw
    observation: ComponentObservation | None = None
    views = ComponentViews(context, component)
    for tool in component_views(context, target, goes_to, goal.view):
        picture = yield from go_and_see(context, tool)
        seen = _see(context, "wrist", picture, views, goal, coarse)
        observation = seen or observation
        if (
            len(views) >= context.parameters.looking.enough_views
            and observation is not None
            and observation.reliable
        ):
            return observation
    # The empty hand reaches other places; one that holds a wire may reach but one.
    is_only = context.belief.grip is not None and len(views) == 1
    return observation if is_only and observation is not None and observation.reliable else None


def _see(
    context: RobotContext,
    camera: str,
    picture: Picture,
    views: ComponentViews,
    goal: LocateGoal,
    near: Pose,
) -> ComponentObservation | None:
    """Locate a component by a picture and earlier views; None when it is not clearly visible."""
    drawing = Drawing(picture.rgb, picture.view)
    component = views.component
    observation = views.add(picture, near)
    if observation is None:
        drawing.title(f"{_what(context, component)} not seen well")
    else:
        _draw(drawing, component, observation, goal)
    context.cameras.show(camera, picture, drawing.image)
    if observation is not None:
        _check_place(context, component, observation)
    return observation


def _what(context: RobotContext, component: Component) -> str:
    """Return what is searched for, for a person."""
    if context.cell.labels:
        return f"label {component.marker_id} of {component.id!r}"
    return f"outline with the screws of {component.id!r}"


def _draw(
    drawing: Drawing, component: Component, observation: ComponentObservation, goal: LocateGoal
) -> None:
    drawing.outline(observation.corners)
    pose = observation.world_from_component
    top = Pose(pose.apply(np.array([0, 0, component.size[2]])), pose.quaternion)
    drawing.axes(top)
    view = drawing.view
    drawing.note(component.id, view.project(top.position)[0])
    drawing.title(f"{component.id} found, residual {observation.residual * 1e3:.2f} mm")
    if goal.terminal_id:
        terminal = component.terminal(goal.terminal_id)
        socket = pose @ terminal.component_from_socket
        # The opening is on the side; it is shown on the component's upper edge.
        above = socket.position + np.array([0, 0, component.size[2] - terminal.mouth[2]])
        start = above - socket.rotation[:, 0] * 0.018
        drawing.arrow(view.project(start)[0], view.project(above)[0], ORANGE)
        drawing.note(f"{component.id}/{terminal.id}", view.project(start)[0], ORANGE)


def _check_level(component: Component, socket: Pose, most_rad: float) -> None:
    """Raise COMPONENT_DISPLACED when an opening is tilted by so much: hands push level only."""
    tilt = math.asin(float(np.clip(unit_x(socket)[2], -1, 1)))
    if abs(tilt) >= most_rad:
        raise AbilityError(
            Code.COMPONENT_DISPLACED,
            f"{component.id!r} leans: its openings are tilted by {math.degrees(tilt):.1f} deg, "
            f"allowed: {math.degrees(most_rad):.0f} deg; put it upright, or observe it again",
        )


def _check_place(
    context: RobotContext, component: Component, observation: ComponentObservation
) -> None:
    """Raise COMPONENT_DISPLACED when a component is far from where the panel has it."""
    looking = context.parameters.looking
    nominal = context.panel.world_from_panel @ component.panel_from_component
    pose = observation.world_from_component
    away = float(np.linalg.norm(pose.position - nominal.position))
    cosine = (np.trace(nominal.rotation.T @ pose.rotation) - 1) / 2
    turned = math.acos(float(np.clip(cosine, -1, 1)))
    if away > looking.displaced_m or turned > looking.displaced_rad:
        raise AbilityError(
            Code.COMPONENT_DISPLACED,
            f"{component.id!r} is {away * 1e3:.0f} mm and {math.degrees(turned):.0f} deg from "
            "its place on the panel, "
            f"allowed: {looking.displaced_m * 1e3:.0f} mm and "
            f"{math.degrees(looking.displaced_rad):.0f} deg",
        )
