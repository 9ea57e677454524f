"""What each ability asks of the world before it moves.

The answers are those of the simulated cell (remodel_skills.abilities); reach is left out. A check
raises AbilityError unless a cell can take a goal as the world is.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any, TypeAlias

from remodel_msgs.msg import ErrorCode

from remodel_states.core.ability_error import AbilityError
from remodel_states.testing.world import World, known

# A goal message, or anything with its fields: generated messages have no types.
Goal: TypeAlias = Any

ROBOTS = ("robot_1", "robot_2")

# [N] that an arm pushes at most: more than the simulated cell's grip holds, so that stiffer cells'
# charts can be run too; [m] from the tip to a grasp, as in the simulated cell.
MAX_FORCE_N = 60.0
GRASP_RANGE_M = (0.030, 0.080)


def check_demands(robots: Collection[str], forces_n: Mapping[str, float]) -> None:
    """Check that goals of an order can be done, before anything moves.

    Args:
        robots: that they name.
        forces_n: their greatest force limit [N], by the ability.
    """
    problems = [
        f"the order's goals name robot {robot!r}; the cell has {', '.join(ROBOTS)}"
        for robot in robots
        if robot not in ROBOTS
    ]
    force_n = forces_n.get("InsertCable", 0.0)
    if force_n > MAX_FORCE_N:
        problems.append(
            f"the use case has InsertCable push with up to {force_n:g} N; this cell's grip holds "
            f"at most {MAX_FORCE_N:g} N"
        )
    if problems:
        raise AbilityError(ErrorCode.INVALID_GOAL, "; ".join(problems))


def check_locate(world: World, _: str, goal: Goal) -> None:
    """Check that a component, and a terminal if the goal names one, can be located."""
    known(world.panel.components, goal.component_id, "component")
    if goal.terminal_id:
        _check_terminal(world, goal)


def check_connection(world: World, _: str, goal: Goal) -> None:
    """Check that an end can be inspected."""
    known(world.panel.wires, goal.cable_id, "wire")
    _check_terminal(world, goal)
    _check_end(goal)


def check_pick(world: World, cell: str, goal: Goal) -> None:
    """Check that an end can be picked."""
    _check_robot(goal)
    _check_end(goal)
    if goal.grasp_distance:
        _check_number("grasp_distance", goal.grasp_distance, *GRASP_RANGE_M)
    check_live(world, cell, goal)
    held = world.hands_in(cell).of(goal.robot_name)
    if held:
        raise AbilityError(
            ErrorCode.OTHER_CABLE_HELD,
            f"{goal.robot_name} holds end {held} of {goal.cable_id!r} already; place it first",
        )
    _check_hand(world, cell, goal)
    _check_loose(world, goal)


def check_carry(world: World, cell: str, goal: Goal) -> None:
    """Check that a held wire can be carried."""
    _check_robot(goal)
    poses = getattr(goal, "path", None)
    if poses is not None and not poses:
        raise AbilityError(ErrorCode.INVALID_GOAL, "path is empty; it must have one pose or more")
    check_live(world, cell, goal)
    _check_held(world, cell, goal)


def check_place(world: World, cell: str, goal: Goal) -> None:
    """Check that a held wire can be laid down."""
    if goal.cable_id:
        check_carry(world, cell, goal)
    else:
        _check_robot(goal)
        _check_held(world, cell, goal)


def check_discard(world: World, cell: str, goal: Goal) -> None:
    """Check that a wire can be discarded."""
    _check_robot(goal)
    if goal.cable_id:
        known(world.panel.wires, goal.cable_id, "wire")
    hands = world.hands_in(cell)
    for robot, end in hands.held.items():
        if robot != goal.robot_name or goal.cable_id not in ("", hands.live):
            raise AbilityError(
                ErrorCode.OTHER_CABLE_HELD,
                f"{robot} holds end {end} of {hands.live!r}; have it placed first",
            )
    for name, other in world.hands.items():
        if name != cell and other.held and other.live == goal.cable_id:
            raise AbilityError(
                ErrorCode.ROBOT_IN_THE_WAY,
                f"a robot of {name} holds {goal.cable_id!r}",
            )


def check_insert(world: World, cell: str, goal: Goal) -> None:
    """Check that an end can be inserted."""
    _check_robot(goal)
    _check_end(goal)
    _check_number("force_limit", goal.force_limit, 1.0, MAX_FORCE_N)
    check_live(world, cell, goal)
    _check_terminal(world, goal)
    held = world.hands_in(cell).of(goal.robot_name)
    if held and held != goal.cable_end:
        raise AbilityError(
            ErrorCode.OTHER_CABLE_HELD,
            f"{goal.robot_name} holds end {held}, not end {goal.cable_end}; place it first",
        )
    _check_hand(world, cell, goal)
    _check_loose(world, goal)
    occupant = world.occupant(terminal_of(goal))
    if occupant is not None:
        raise AbilityError(
            ErrorCode.TERMINAL_OCCUPIED, f"terminal {terminal_of(goal)!r} holds end {occupant!r}"
        )


def check_fix(world: World, cell: str, goal: Goal) -> None:
    """Check that a held end can be fixed."""
    _check_robot(goal)
    _check_number("pull_test_force", goal.pull_test_force, 0.0, MAX_FORCE_N)
    check_live(world, cell, goal)
    _check_terminal(world, goal)
    _check_held(world, cell, goal)


def check_extract(world: World, cell: str, goal: Goal) -> None:
    """Check that an end can be extracted."""
    _check_robot(goal)
    check_live(world, cell, goal)
    _check_terminal(world, goal)


def check_connector(world: World, _: str, goal: Goal) -> None:
    """Check that a connector can be mated."""
    _check_robot(goal)
    if not goal.connector_id:
        raise AbilityError(ErrorCode.UNKNOWN_NAME, "connector_id is empty")
    _check_number("force_limit", goal.force_limit, 1.0, math.inf)


def check_lay(world: World, cell: str, goal: Goal) -> None:
    """Check that a wire can be laid into its ducts by a robot that holds it and one that leads."""
    _check_robot(goal)
    known(ROBOTS, goal.guide_name, "robot")
    if goal.robot_name == goal.guide_name:
        text = f"robot_name and guide_name are both {goal.robot_name!r}; it takes two robots"
        raise AbilityError(ErrorCode.INVALID_GOAL, text)
    check_live(world, cell, goal)
    if not world.panel.ducts.get(goal.cable_id):
        text = f"the route of {goal.cable_id!r} passes no duct; carry it with RouteWire"
        raise AbilityError(ErrorCode.INVALID_GOAL, text)
    seats = {end: world.seat(goal.cable_id, end) for end in "ab"}
    loose = [end for end, seat in seats.items() if seat is None]
    if len(loose) != 1 or not any(seat.fixed for seat in seats.values() if seat is not None):
        raise AbilityError(
            ErrorCode.INVALID_GOAL,
            f"of {goal.cable_id!r}, one end must be fixed and the other one loose",
        )
    _check_held(world, cell, goal)
    led = world.hands_in(cell).of(goal.guide_name)
    if led:
        raise AbilityError(
            ErrorCode.OTHER_CABLE_HELD,
            f"{goal.guide_name}, which leads the wire, holds end {led}; place it first",
        )


def check_pin(_: World, __: str, goal: Goal) -> None:
    """Check that both robots exist."""
    for robot in (goal.robot_1_name, goal.robot_2_name):
        known(ROBOTS, robot, "robot")


def terminal_of(goal: Goal) -> str:
    """Return the terminal that a goal is about, as "component/terminal"."""
    return f"{goal.component_id}/{goal.terminal_id}"


def _check_robot(goal: Goal) -> None:
    known(ROBOTS, goal.robot_name, "robot")


def _check_end(goal: Goal) -> None:
    if goal.cable_end not in ("a", "b"):
        text = f"cable_end is {goal.cable_end!r}; allowed: 'a', 'b'"
        raise AbilityError(ErrorCode.INVALID_GOAL, text)


def _check_number(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        text = f"{name} is {value:g}; allowed: {low:g} to {high:g}"
        raise AbilityError(ErrorCode.INVALID_GOAL, text)


def _check_terminal(world: World, goal: Goal) -> None:
    known(world.panel.components, goal.component_id, "component")
    known(world.panel.openings, terminal_of(goal), "terminal")


def check_live(world: World, cell: str, goal: Goal) -> None:
    """Check that a wire is the one fed last."""
    known(world.panel.wires, goal.cable_id, "wire")
    live = world.hands_in(cell).live
    if live != goal.cable_id:
        raise AbilityError(
            ErrorCode.WIRE_NOT_FED,
            f"wire {goal.cable_id!r} is not the one fed last, which is {live or 'none'!r}; feed it "
            "first",
        )


def _check_held(world: World, cell: str, goal: Goal) -> None:
    if not world.hands_in(cell).of(goal.robot_name):
        text = f"the gripper of {goal.robot_name} is empty; pick the wire first"
        raise AbilityError(ErrorCode.NOTHING_HELD, text)


def _check_hand(world: World, cell: str, goal: Goal) -> None:
    """Check that no other robot holds the end that a goal is about."""
    for robot, end in world.hands_in(cell).others(goal.robot_name):
        if end == goal.cable_end:
            text = f"{robot} holds end {end}; have it placed first"
            raise AbilityError(ErrorCode.OTHER_CABLE_HELD, text)


def _check_loose(world: World, goal: Goal) -> None:
    seat = world.seat(goal.cable_id, goal.cable_end)
    if seat is not None:
        how = "fixed" if seat.fixed else "seated"
        raise AbilityError(
            ErrorCode.INVALID_GOAL,
            f"end {goal.cable_end} of {goal.cable_id!r} is {how} in a terminal; extract it first",
        )
