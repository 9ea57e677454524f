"""PlacePin: two arms lay the live wire, its pins at two connectors and itself along the path.

A wire that is released with slack springs straight and takes its ends with it. So the arms draw it
taut, by the force at their wrists, before they release it.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np

from remodel_skills.abilities.ability import Done, ability
from remodel_skills.belief_state import BeliefState, EndState, Grip
from remodel_skills.goal_checks import (
    Message,
    check_reach,
    require,
    require_number,
)
from remodel_skills.parameters import Parameters
from remodel_skills.primitives.force_motion import ForceMotion
from remodel_skills.primitives.grasping import check_grip, pick_end, release
from remodel_skills.primitives.motions import disengage, park, rise, wait
from remodel_skills.primitives.observation.observing import (
    OverheadObservation,
    mark_end,
    observe_from_above,
)
from remodel_skills.primitives.pushing import tool_before
from remodel_skills.primitives.together import concurrently, move_together
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_vision.colour import ORANGE, Drawing
from remodel_vision.wire_ends import line_from
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, Pose
from remodel_work.layout import GRASP_DISTANCE_M
from remodel_work.panel import Panel, PanelWire, WireEnd
from remodel_work.robot.arm import ToolPose


@dataclass(frozen=True)
class PlacePinGoal:
    """Lay the live wire's two pins at two connectors, with two robots.

    The wire's pins are its two ferrules. They go to two neighbouring connectors, `connector_space`
    apart; poses of the path lie between them, `path_space` apart from the first connector on. The
    row runs along the panel's x axis, or along y when it is rotated, from the panel's origin, or
    with its middle there when it is centered.
    """

    robot_1: str
    robot_2: str
    path_space: float
    connector_space: float
    centered: bool
    rotate: bool
    show_in_tf: bool

    def __post_init__(self) -> None:
        """Refuse one robot twice."""
        require(
            self.robot_1 != self.robot_2,
            f"robot_1_name and robot_2_name are both {self.robot_1!r}; it takes two robots",
        )

    def check(self, panel: Panel, belief: BeliefState, parameters: Parameters) -> None:
        """Raise when a robot cannot lay the live wire there; asked for each of the two."""
        wires = parameters.wire
        require_number("path_space", self.path_space, *wires.path_space_range_m, "m")
        require_number("connector_space", self.connector_space, *wires.connector_space_range_m, "m")
        require(
            self.path_space <= self.connector_space,
            f"path_space is {self.path_space:g} m; allowed: up to connector_space, "
            f"{self.connector_space:g} m",
        )
        if belief.feed is None:
            raise AbilityError(Code.WIRE_NOT_FED, "no wire has been fed; feed one first")
        wire = panel.wire(belief.feed.wire_id)
        for end, state in belief.ends.items():
            if state is not EndState.LOOSE:
                raise AbilityError(
                    Code.INVALID_GOAL,
                    f"end {end.value} of {wire.id!r} is {state.value} in a terminal; extract it "
                    "first",
                )
        self._check_length(wire, wires.pin_slack_range_m)
        for name, pose in pin_row(self, wire, panel).items():
            self._check_place(name, pose, panel, parameters.tool.finger_room_m)
            if name.startswith("pin"):
                x, y, z = (float(v) for v in pose.position - pose.rotation[:, 0] * GRASP_DISTANCE_M)
                check_reach(belief.arm, ToolPose(x, y, z, pose.yaw))

    def _check_length(self, wire: PanelWire, slacks: tuple[float, float]) -> None:
        least, most = (round(wire.length - slack, 4) for slack in reversed(slacks))
        require(
            least <= self.connector_space <= most,
            f"connector_space is {self.connector_space:g} m; {wire.id!r} is {wire.length:g} m "
            f"long, allowed: {least:g} to {most:g} m",
        )

    def _check_place(self, name: str, pose: Pose, panel: Panel, room_m: float) -> None:
        x, y, _ = (float(v) for v in panel.world_from_panel.inverse().apply(pose.position))
        require(
            abs(x) <= panel.size[0] / 2 and abs(y) <= panel.size[1] / 2,
            f"{name} would lie beyond the plate, at x {x:.3f}, y {y:.3f} m; allowed: "
            f"{panel.size[0] / 2:g} and {panel.size[1] / 2:g} m; rotate or center the row",
        )
        for component in panel.components:
            local = component.panel_from_component.inverse().apply(np.array([x, y, 0.0]))
            beside = np.abs(local[:2]) - np.array(component.size[:2]) / 2
            require(
                float(beside.max()) > room_m,
                f"{name} would lie at x {x:.3f}, y {y:.3f} m of the panel, nearer than "
                f"{room_m * 1e3:.0f} mm to component {component.id!r}; rotate or center the row",
            )


def pin_row(goal: PlacePinGoal, wire: PanelWire, panel: Panel) -> dict[str, Pose]:
    """Return the poses by name, in the world: pin_1, path_1 to path_n, pin_2.

    The pins' x axes point out of the wire, those of the path from the first pin to the second.
    """
    start = -goal.connector_space / 2 if goal.centered else 0.0
    axis = np.array([0.0, 1.0, 0.0]) if goal.rotate else np.array([1.0, 0.0, 0.0])
    yaw = math.pi / 2 if goal.rotate else 0.0

    def at(along: float, turn: float = 0.0) -> Pose:
        place: Array = (start + along) * axis
        return panel.world_from_panel @ Pose.level(place[0], place[1], wire.radius, yaw + turn)

    between = math.ceil(goal.connector_space / goal.path_space - 1e-9) - 1
    path = {f"path_{k}": at(k * goal.path_space) for k in range(1, between + 1)}
    return {"pin_1": at(0.0, math.pi), **path, "pin_2": at(goal.connector_space)}


@dataclass(frozen=True)
class Hand:
    """One arm's part: which end it lays, and where that pin goes, x out of the wire."""

    context: RobotContext
    end: WireEnd
    pin: Pose


def _goal(message: Message, board: Pose) -> PlacePinGoal:
    return PlacePinGoal(
        robot_1=message.robot_1_name,
        robot_2=message.robot_2_name,
        path_space=message.path_space,
        connector_space=message.connector_space,
        centered=message.centered,
        rotate=message.rotate,
        show_in_tf=message.show_in_TF,
    )


@ability("PlacePin", _goal)
def place_pin(one: RobotContext, two: RobotContext, goal: PlacePinGoal) -> Steps[Done]:
    """Pick both ends, carry them together, lay them down together, and observe them."""
    motion = one.parameters.motion
    row = pin_row(goal, one.wire, one.panel)
    if goal.show_in_tf:
        one.observers.show_frames({f"placepin/{name}": pose for name, pose in row.items()})
    hands = _share_out((one, two), row)
    yield from concurrently(*(disengage(hand.context) for hand in hands))
    if one.belief.grip is None and two.belief.grip is None:
        one.report("searching for both pins", 0.05)
        yield from concurrently(park(one), park(two))
        yield from observe_from_above(one)
    one.report("picking both ends", 0.1)
    yield from concurrently(*(_pick(hand) for hand in hands))
    one.device.magazine.move_fork(*one.parameters.fixture.feeder_fork_away_m)
    one.report("carrying both ends to their connectors", 0.5)
    yield from move_together(
        [(hand.context, _above(hand)) for hand in hands], motion.carry_speed_m_s
    )
    for hand in hands:
        check_grip(hand.context)
    one.report("laying both pins down", 0.65)
    yield from move_together(
        [(hand.context, _lying(hand)) for hand in hands], motion.approach_speed_m_s
    )
    one.report("drawing the wire taut", 0.7)
    yield from concurrently(*(_draw(hand) for hand in hands))
    yield from concurrently(*(_release(hand) for hand in hands))
    one.report("observing the pins from above", 0.8)
    yield from concurrently(park(one), park(two))
    above = yield from observe_from_above(one)
    worst = _judge(one, above, hands, row)
    return Done(
        f"pins of {one.wire.id} lie {goal.connector_space * 1e3:.0f} mm apart, within "
        f"{worst * 1e3:.1f} mm of their places"
    )


def _share_out(contexts: tuple[RobotContext, RobotContext], row: dict[str, Pose]) -> list[Hand]:
    """Return which robot lays which end where: as they hold them, else by the shortest distances.

    The wire is not turned round: the end that lies nearer to a pin goes there.
    """
    options = []
    for first, pins in itertools.product(
        (WireEnd.A, WireEnd.B), (("pin_1", "pin_2"), ("pin_2", "pin_1"))
    ):
        ends = (first, first.other)
        hands = [
            Hand(context, end, row[pin])
            for context, end, pin in zip(contexts, ends, pins, strict=True)
        ]
        if all(h.context.belief.grip is None or h.context.belief.grip.end is h.end for h in hands):
            options.append((sum(_distance(hand) for hand in hands), hands))
    return min(options, key=lambda option: option[0])[1]


def _distance(hand: Hand) -> float:
    """Return how far an arm goes to its end's place, and that end to its pin's [m]."""
    belief, pin = hand.context.belief, hand.pin.position[:2]
    if belief.grip is not None:
        return float(np.linalg.norm(hand.context.commanded.position[:2] - pin))
    lies = belief.expected[hand.end][:2]
    reach = np.linalg.norm(hand.context.home.position[:2] - lies)
    return float(reach + 2 * np.linalg.norm(lies - pin))


def _pick(hand: Hand) -> Steps[None]:
    if hand.context.belief.grip is None:
        yield from pick_end(hand.context, hand.end, 0.0, hand.pin, shares=(0.1, 0.45))


def _grip(hand: Hand) -> Grip:
    grip = hand.context.belief.grip
    if grip is None:
        raise AbilityError(Code.NOTHING_HELD, f"{hand.context.name} holds nothing; try again")
    return grip


def _above(hand: Hand) -> ToolPose:
    return tool_before(hand.pin, _grip(hand), 0.0).at(z=hand.context.parameters.motion.carry_z_m)


def _lying(hand: Hand) -> ToolPose:
    tool = tool_before(hand.pin, _grip(hand), 0.0)
    return tool.at(
        z=max(tool.z, hand.context.fingers.below + hand.context.parameters.tool.floor_clearance_m)
    )


def _draw(hand: Hand) -> Steps[None]:
    """Draw an end out along the row until the wire pulls back."""
    context, out = hand.context, hand.pin.rotation[:, 0]
    wire = context.parameters.wire
    yield from wait(context, context.parameters.motion.force_still_s)
    # Both arms pull at the wire, which is as if it were twice as stiff.
    motion = ForceMotion(
        context, out, wire.taut_n, 2 * wire.grip_stiffness_n_m, context.device.arm.force
    )
    while not motion.met_limit and motion.travel < context.parameters.motion.draw_m:
        yield from motion.advance(context.parameters.motion.draw_speed_m_s)
    motion.stop()
    check_grip(context)


def _release(hand: Hand) -> Steps[None]:
    belief = hand.context.belief
    belief.expected[hand.end] = hand.pin.position.copy()
    belief.tips.pop(hand.end, None)
    yield from release(hand.context, hand.context.parameters.tool.open_m)
    yield from rise(hand.context)


def _judge(
    context: RobotContext, above: OverheadObservation, hands: list[Hand], row: dict[str, Pose]
) -> float:
    """Return how far the worse pin is from its place [m]; raise when it or the wire is too far."""
    terminal = context.parameters.terminal
    drawing = Drawing(above.picture.rgb, above.picture.view)
    away: dict[WireEnd, float] = {}
    for hand in hands:
        if hand.end in above.ends:
            tip = above.ends[hand.end].tip.tip
            away[hand.end] = float(np.linalg.norm(tip[:2] - hand.pin.position[:2]))
            mark_end(drawing, above.ends[hand.end], f"{away[hand.end] * 1e3:.1f} mm")
    for pose in row.values():
        drawing.circle(above.picture.view.project(pose.position)[0], 6, ORANGE)
    drawing.title(f"PlacePin: {len(away)} of 2 pins seen")
    context.cameras.show("overhead", above.picture, drawing.image)
    for hand in hands:
        if away.get(hand.end, math.inf) > terminal.pin_tolerance_m:
            found = f"{away[hand.end] * 1e3:.0f} mm away" if hand.end in away else "not seen"
            raise AbilityError(
                Code.NOT_SEATED,
                f"pin {hand.end.value} of {context.wire.id!r} is {found}, allowed: "
                f"{terminal.pin_tolerance_m * 1e3:.0f} mm from its "
                "place; place it again",
            )
    _judge_path(context, above, [pose for name, pose in row.items() if name.startswith("path")])
    return max(away.values())


def _judge_path(context: RobotContext, above: OverheadObservation, path: list[Pose]) -> None:
    wire = context.wire
    lines = [
        above.picture.view.on_plane(line_from(observation, above.lines), wire.radius)
        for observation in above.ends.values()
    ]
    line: Array = np.concatenate(lines)[:, :2]
    for i, pose in enumerate(path, 1):
        away = float(np.linalg.norm(line - pose.position[:2], axis=1).min())
        if away > context.parameters.wire.path_tolerance_m:
            raise AbilityError(
                Code.OUT_OF_DUCT,
                f"{wire.id!r} passes {away * 1e3:.0f} mm beside pose {i} of the path, allowed: "
                f"{context.parameters.wire.path_tolerance_m * 1e3:.0f} mm; place it again",
            )
