"""LocateGearboxComponent: find a component by its label, from above and then from the hand."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from remodel_sim.abilities.ability import ability
from remodel_sim.abilities.execution.robot_context import Station, Steps
from remodel_sim.abilities.primitives.motions import disengage, park
from remodel_sim.abilities.primitives.observing import go_and_see
from remodel_sim.abilities.primitives.viewpoints import label_views
from remodel_sim.core.camera import Picture
from remodel_sim.core.errors import AbilityError
from remodel_sim.core.geometry import Pose
from remodel_sim.core.goals import LocateGoal
from remodel_sim.core.vision.drawing import ORANGE, Drawing
from remodel_sim.core.vision.label_pose import ComponentSighting, Look, locate_component
from remodel_sim.core.vision.labels import find_labels, search_label
from remodel_sim.core.workpiece.component_shape import label_corners
from remodel_sim.core.workpiece.layout import WORLD_FROM_PANEL
from remodel_sim.core.workpiece.panel import Component
from remodel_states.core.codes import Code

# Further than this from its place on the panel, something is wrong with the panel or the component.
DISPLACED_M = 0.030
DISPLACED_RAD = math.radians(15.0)
# One look does not tell reliably whether a component stands upright.
LOOKS = 2


@dataclass(frozen=True, eq=False)
class ComponentLocated:
    """A component as seen.

    Attributes:
        message: for a person.
        component_pose: its frame in the world.
        socket_pose: the mouth of the terminal asked for; None when none was.
        residual: RMS distance of the label's edges, as seen, from those of the pose [m].
    """

    message: str
    component_pose: Pose
    socket_pose: Pose | None
    residual: float


def _goal(message: Any) -> LocateGoal:  # noqa: ANN401 - messages have no types
    return LocateGoal(message.component_id, message.terminal_id, message.view)


@ability("LocateGearboxComponent", _goal)
def locate_gearbox_component(station: Station, goal: LocateGoal) -> Steps[ComponentLocated]:
    """Look from above when the hand is empty, then from the hand.

    The answer is what the hand's camera saw from two places; one is enough with a wire in the hand.
    """
    component = station.panel.component(goal.component_id)
    coarse = WORLD_FROM_PANEL @ component.panel_from_component
    yield from disengage(station)
    code = Code.COMPONENT_OCCLUDED
    if station.book.grip is None:
        station.report("looking from above", 0.05)
        yield from park(station)
        picture = station.look_overhead()
        yield
        above = _see(station, "overhead", picture, component, goal, coarse, [])
        if above is None:
            code = Code.COMPONENT_NOT_FOUND
        else:
            coarse = above.world_from_component
    station.report("looking from the hand", 0.4)
    sighting = yield from _look_from_hand(station, component, goal, coarse)
    if sighting is None:
        raise AbilityError(
            code,
            f"label {component.marker_id} of {component.id!r} is not seen, or not well, near "
            f"{coarse.position[0] * 1e3:.0f}, {coarse.position[1] * 1e3:.0f} mm",
        )
    pose = sighting.world_from_component
    station.book.seen[component.id] = pose
    socket = None
    if goal.terminal_id:
        socket = pose @ component.terminal(goal.terminal_id).component_from_socket
    x, y, _ = pose.position
    message = (
        f"{component.id} seen at x {x * 1e3:.1f}, y {y * 1e3:.1f} mm, "
        f"{math.degrees(pose.yaw):.2f} deg"
    )
    return ComponentLocated(message, pose, socket, sighting.residual)


def _look_from_hand(
    station: Station, component: Component, goal: LocateGoal, coarse: Pose
) -> Steps[ComponentSighting | None]:
    """Look with the wrist camera; return what was seen, None when the label was not seen well."""
    label, goes_to = coarse.apply(label_corners(component)), None
    if goal.terminal_id:
        goes_to = (coarse @ component.terminal(goal.terminal_id).component_from_socket).yaw
    sighting: ComponentSighting | None = None
    looks: list[Look] = []
    for tool in label_views(station, label, goes_to, goal.view):
        picture = yield from go_and_see(station, tool)
        seen = _see(station, "wrist", picture, component, goal, coarse, looks)
        sighting = seen or sighting
        if len(looks) == LOOKS:
            return sighting
    # The empty hand reaches other places; one that holds a wire may reach but one.
    return None if station.book.grip is None else sighting


def _see(
    station: Station,
    camera: str,
    picture: Picture,
    component: Component,
    goal: LocateGoal,
    near: Pose,
    looks: list[Look],
) -> ComponentSighting | None:
    """Return what a picture and earlier looks tell of a component; None when it is not seen well.

    A picture that shows the label well is added to the looks.
    """
    drawing = Drawing(picture.rgb, picture.view)
    sighting = None
    corners = find_labels(picture, station.panel.components).get(component.marker_id)
    if corners is None:
        corners = search_label(picture, component, near)
    if corners is not None:
        looks.append(Look(picture, corners))
        sighting = locate_component(component, looks)
    if sighting is not None and not sighting.clear:
        looks.pop()
        sighting = None
    if sighting is None:
        drawing.title(f"{component.id} (label {component.marker_id}) not seen well")
    else:
        _draw(drawing, component, sighting, goal)
    station.show(camera, picture, drawing.image)
    if sighting is not None:
        _check_place(component, sighting)
    return sighting


def _draw(
    drawing: Drawing, component: Component, sighting: ComponentSighting, goal: LocateGoal
) -> None:
    drawing.outline(sighting.corners)
    pose = sighting.world_from_component
    top = Pose(pose.apply(np.array([0, 0, component.size[2]])), pose.quaternion)
    drawing.axes(top)
    view = drawing.view
    drawing.note(component.id, view.project(top.position)[0])
    drawing.title(f"{component.id} found, residual {sighting.residual * 1e3:.2f} mm")
    if goal.terminal_id:
        terminal = component.terminal(goal.terminal_id)
        socket = pose @ terminal.component_from_socket
        # The mouth is on the side; it is shown on the component's upper edge.
        above = socket.position + np.array([0, 0, component.size[2] - terminal.mouth[2]])
        start = above - socket.rotation[:, 0] * 0.018
        drawing.arrow(view.project(start)[0], view.project(above)[0], ORANGE)
        drawing.note(f"{component.id}/{terminal.id}", view.project(start)[0], ORANGE)


def _check_place(component: Component, sighting: ComponentSighting) -> None:
    """Raise COMPONENT_DISPLACED when a component is far from where the panel has it."""
    nominal = WORLD_FROM_PANEL @ component.panel_from_component
    pose = sighting.world_from_component
    away = float(np.linalg.norm(pose.position - nominal.position))
    cosine = (np.trace(nominal.rotation.T @ pose.rotation) - 1) / 2
    turned = math.acos(float(np.clip(cosine, -1, 1)))
    if away > DISPLACED_M or turned > DISPLACED_RAD:
        raise AbilityError(
            Code.COMPONENT_DISPLACED,
            f"{component.id!r} is {away * 1e3:.0f} mm and {math.degrees(turned):.0f} deg from "
            "its place on the panel, "
            f"allowed: {DISPLACED_M * 1e3:.0f} mm and {math.degrees(DISPLACED_RAD):.0f} deg",
        )
