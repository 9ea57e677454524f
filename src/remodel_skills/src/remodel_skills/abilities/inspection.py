"""What cameras show of a component and of its terminals: LocateGearboxComponent, CheckConnection.

LocateGearboxComponent finds a component by its label or shape, from above and from the hand.

CheckConnection checks whether one end of a wire sits in a terminal. Neither ground truth nor the
belief state decides, only what cameras show of the opening. An empty hand observes it from several
places; a hand that holds a wire stays where it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from remodel_skills.abilities.ability import ability
from remodel_skills.belief_state import BeliefState
from remodel_skills.goal_checks import (
    Message,
    check_clamp,
    parse_end,
)
from remodel_skills.parameters import Parameters
from remodel_skills.primitives.grasping import holds
from remodel_skills.primitives.motions import disengage, park
from remodel_skills.primitives.observation.observing import go_and_see
from remodel_skills.primitives.observation.views import (
    ComponentViews,
    camera_above,
    component_views,
    expected_place,
    find_panel,
    to_be_seen,
)
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.colour import ORANGE, Drawing
from remodel_vision.device_pose import ComponentObservation, stands_there
from remodel_vision.opening_occupancy import (
    Occupancy,
    OpeningObservation,
    combine,
    light_on,
    observe_opening,
)
from remodel_work.camera import Picture
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose
from remodel_work.panel import Component, Panel, WireEnd, unit_x
from remodel_work.robot.arm import ToolPose


@dataclass(frozen=True)
class LocateGoal:
    """Find a component and, unless the id is empty, one of its terminals.

    `view` 0 is the usual viewpoint, more are others.
    """

    component_id: str
    terminal_id: str
    view: int = 0

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when a name is unknown."""
        component = panel.component(self.component_id)
        if self.terminal_id:
            component.terminal(self.terminal_id)


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


def _locate_goal(message: Message, board: Pose) -> LocateGoal:
    return LocateGoal(message.component_id, message.terminal_id, message.view)


@ability("LocateGearboxComponent", _locate_goal)
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


@dataclass(frozen=True)
class CheckGoal:
    """See whether an end of a wire sits in a terminal; any wire of the panel, fed or not."""

    cable_id: str
    end: WireEnd
    component_id: str
    terminal_id: str

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when a name is unknown."""
        panel.wire(self.cable_id)
        check_clamp(self.component_id, self.terminal_id, panel)


@dataclass(frozen=True)
class ConnectionChecked:
    """What was seen of an end.

    Attributes:
        message: for a person.
        connected: whether the end sits in the terminal.
    """

    message: str
    connected: bool


@dataclass(frozen=True, eq=False)
class Shot:
    """A picture that may show the opening.

    Attributes:
        camera: "overhead" or "wrist".
        picture: what it saw.
        component: as located in that picture; None when it is not seen well.
    """

    camera: str
    picture: Picture
    component: ComponentObservation | None


def _check_goal(message: Message, board: Pose) -> CheckGoal:
    return CheckGoal(
        message.cable_id, parse_end(message.cable_end), message.component_id, message.terminal_id
    )


@ability("CheckConnection", _check_goal)
def check_connection(context: RobotContext, goal: CheckGoal) -> Steps[ConnectionChecked]:
    """Observe the opening until the pictures prove what sits in it."""
    where = f"'{goal.component_id}/{goal.terminal_id}'"
    what = f"end {goal.end.value} of {goal.cable_id}"
    shots: list[Shot] = []
    occupancy = Occupancy.UNCLEAR
    for i, take in enumerate(_views(context, goal)):
        context.report(f"observing {where}", i / (1 + len(context.parameters.looking.lens_at_m)))
        camera, picture = yield from take
        shots.append(Shot(camera, picture, _component_in(context, goal, picture)))
        yield
        occupancy = combine(_observations(context, goal, shots))
        _show(context, goal, shots, occupancy)
        if occupancy is not Occupancy.UNCLEAR:
            break
    if occupancy is Occupancy.UNCLEAR:
        raise _undecided(context, goal, shots)
    connected = occupancy is Occupancy.WIRE
    verb = "sits" if connected else "does not sit"
    return ConnectionChecked(f"{what} {verb} in {where}: {occupancy.value}", connected)


def _views(context: RobotContext, goal: CheckGoal) -> Iterator[Steps[tuple[str, Picture]]]:
    """Yield the steps of each possible observation, the best first."""
    component = context.panel.component(goal.component_id)
    place = (context.panel.world_from_panel @ component.panel_from_component).position
    if context.belief.grip is not None or holds(context):
        yield _from_above(context, place)
        yield _from_here(context)
        return
    drawn = context.panel.world_from_panel @ context.panel.panel_from_socket(
        goal.component_id, goal.terminal_id
    )
    for out, across in context.parameters.looking.lens_at_m:
        lens = drawn.apply(np.array([-out, across, 0.0]))[:2]
        tool = camera_above(context, lens, context.commanded.yaw)
        if context.arm.reaches(tool):
            yield _from_hand(context, tool)
    yield _from_above(context, place)


def _from_hand(context: RobotContext, tool: ToolPose) -> Steps[tuple[str, Picture]]:
    picture = yield from go_and_see(context, tool)
    return "wrist", picture


def _from_here(context: RobotContext) -> Steps[tuple[str, Picture]]:
    picture = context.cameras.take_wrist_picture()
    yield
    return "wrist", picture


def _from_above(context: RobotContext, place: Array) -> Steps[tuple[str, Picture]]:
    if context.belief.grip is None and not holds(context):
        yield from park(context)
    picture = context.cameras.take_overhead_picture(place[None])
    yield
    return "overhead", picture


def _component_in(
    context: RobotContext, goal: CheckGoal, picture: Picture
) -> ComponentObservation | None:
    """Return the component as a picture shows it; None when it is not seen well."""
    component = context.panel.component(goal.component_id)
    near = context.belief.seen.get(component.id) or expected_place(context, component)
    return ComponentViews(context, component).add(picture, near)


def _observations(
    context: RobotContext, goal: CheckGoal, shots: list[Shot]
) -> list[OpeningObservation]:
    """Return what each picture shows of the opening.

    A picture in which the component is hidden borrows its place from one in which it is not.
    """
    component = context.panel.component(goal.component_id)
    places = [shot.component.world_from_component for shot in shots if shot.component is not None]
    if not places:
        return []
    return [_observation(context, goal, component, shot, elsewhere=places[-1]) for shot in shots]


def _observation(
    context: RobotContext, goal: CheckGoal, component: Component, shot: Shot, elsewhere: Pose
) -> OpeningObservation:
    seen = shot.component
    pose = elsewhere if seen is None else seen.world_from_component
    terminal = component.terminal(goal.terminal_id)
    return observe_opening(
        shot.picture,
        pose @ terminal.component_from_socket,
        context.panel.wire(goal.cable_id),
        light_on(shot.picture, component, pose, label=context.cell.labels),
    )


def _show(context: RobotContext, goal: CheckGoal, shots: list[Shot], occupancy: Occupancy) -> None:
    shot = shots[-1]
    drawing = Drawing(shot.picture.rgb, shot.picture.view)
    title = f"{goal.cable_id} end {goal.end.value} in {goal.component_id}/{goal.terminal_id}: "
    if shot.component is not None:
        drawing.outline(shot.component.corners)
        terminal = context.panel.component(goal.component_id).terminal(goal.terminal_id)
        socket = shot.component.world_from_component @ terminal.component_from_socket
        axis = shot.picture.view.project(socket.apply(np.array([[-0.02, 0, 0], [0, 0, 0]])))
        drawing.arrow(axis[0], axis[1], ORANGE)
    drawing.title(title + occupancy.value)
    context.cameras.show(shot.camera, shot.picture, drawing.image)


def _undecided(context: RobotContext, goal: CheckGoal, shots: list[Shot]) -> AbilityError:
    """Return why the pictures do not decide it."""
    where = f"'{goal.component_id}/{goal.terminal_id}'"
    holding = context.belief.grip is not None or holds(context)
    remedy = "place what the hand holds and check again" if holding else "clear the view"
    if all(shot.component is None for shot in shots):
        return AbilityError(
            Code.COMPONENT_OCCLUDED,
            f"component {goal.component_id!r} is not seen, or not well, in {len(shots)} "
            f"pictures; {remedy}",
        )
    return AbilityError(
        Code.CABLE_OCCLUDED,
        f"{len(shots)} pictures do not show whether end {goal.end.value} of {goal.cable_id!r} "
        f"sits in {where}; {remedy}",
    )
