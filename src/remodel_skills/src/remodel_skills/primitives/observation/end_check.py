"""Check from above whether a fixed end is still in its terminal, as steps of an ability."""

from __future__ import annotations

from remodel_skills.primitives.observation.route_check import observe_board
from remodel_skills.primitives.observation.views import ComponentViews
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.drawing import ORANGE, Drawing
from remodel_vision.opening_occupancy import is_seen_empty
from remodel_work.errors import AbilityError
from remodel_work.panel import WireEnd


def check_end(context: RobotContext, end: WireEnd) -> Steps[None]:
    """Check whether an end of the live wire is still where it was fixed, the hand where it is.

    Where the picture does not show the terminal's component and its opening, the end counts as
    being there.

    Raises:
        AbilityError: CAME_OUT; the end counts as loose from then on.
    """
    belief, wire = context.belief, context.wire
    ((component_id, terminal_id),) = [
        key for key, fixed in belief.occupied.items() if fixed == (wire.id, end)
    ]
    component = context.panel.component(component_id)
    drawn = context.panel.world_from_panel @ component.panel_from_component
    near = belief.seen.get(component_id, drawn)
    seen = yield from observe_board(context, near.position[None])
    found = ComponentViews(context, component).add(seen.picture, near)
    if found is None:
        return
    socket = found.world_from_component @ component.terminal(terminal_id).component_from_socket
    if not is_seen_empty(seen.picture, socket, wire):
        return
    where = f"'{component_id}/{terminal_id}'"
    drawing = Drawing(seen.picture.rgb, seen.picture.view)
    drawing.circle(seen.picture.view.project(socket.position)[0], 6, ORANGE)
    drawing.title(f"{wire.id}: end {end.value} is not in {where}")
    context.cameras.show("overhead", seen.picture, drawing.image)
    belief.loosen(end)
    raise AbilityError(
        Code.CAME_OUT,
        f"end {end.value} of {wire.id!r} was fixed in {where}, and nothing is seen there any more; "
        "discard the wire and place a new piece",
    )
