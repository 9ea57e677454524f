"""CheckConnection: check whether one end of a wire sits in a terminal.

Neither ground truth nor the belief state decides, only what cameras show of the opening. An empty
hand observes it from several places; a hand that holds a wire stays where it is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from remodel_skills.abilities.ability import ability
from remodel_skills.goal_checks import Message, parse_end
from remodel_skills.goals import CheckGoal
from remodel_skills.primitives.grasping import holds
from remodel_skills.primitives.motions import park
from remodel_skills.primitives.observation.observing import go_and_see
from remodel_skills.primitives.observation.views import ComponentViews, camera_above, expected_place
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.colour import ORANGE, Drawing
from remodel_vision.device_pose import ComponentObservation
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
from remodel_work.panel import Component
from remodel_work.robot.arm import ToolPose


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


def _goal(message: Message, board: Pose) -> CheckGoal:
    return CheckGoal(
        message.cable_id, parse_end(message.cable_end), message.component_id, message.terminal_id
    )


@ability("CheckConnection", _goal)
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
