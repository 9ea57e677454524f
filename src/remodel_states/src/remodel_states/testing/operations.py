"""What each ability asks of the world before it moves, and does to it.

The answers are those of the simulated cell (remodel_sim.core.goals, remodel_sim.abilities); forces,
shapes and reach are left out. A goal is anything with the fields of the ability's goal message.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from remodel_msgs.msg import ErrorCode

from remodel_states.testing.ledger import Deed, Entry
from remodel_states.testing.world import Place, Seat, World, WorldError, known

ROBOTS = ("robot_1", "robot_2")

# [N] that an arm pushes at most: more than the simulated cell's grip holds, so that stiffer cells'
# charts can be run too; [m] from the tip to a grasp, as in the simulated cell.
MAX_FORCE_N = 60.0
GRASP_RANGE_M = (0.030, 0.080)

# What is measured where nothing is: [m] an end is deep, [N] it took, [m] between the pads.
DEPTH_M = 0.012
PUSH_N = 5.0
GRIP_M = 0.003


@dataclass(frozen=True)
class Effect:
    """What an ability did.

    Attributes:
        world: afterwards.
        said: for a person.
        entries: for the ledger.
        found: result field -> value; places stand for poses.
    """

    world: World
    said: str
    entries: tuple[Entry, ...] = ()
    found: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Operation:
    """One ability.

    Attributes:
        check: raises WorldError unless a cell can take a goal as the world is.
        do: returns the effect; raises WorldError when it fails.
    """

    check: Callable[[World, str, Any], None]
    do: Callable[[World, str, Any], Effect]


def fail(world: World, cell: str, ability: str, code: int, goal: Any) -> World:  # noqa: ANN401
    """Return the world after an ability failed with a code."""
    if code == ErrorCode.GRASP_SLIPPED:
        return _let_go(world, cell)
    if ability == "InsertCable" and code < ErrorCode.UNKNOWN_NAME:
        return world.with_hand(cell, held=goal.cable_end)  # it was picked, or held before
    if ability == "PickCable" and code == ErrorCode.TWO_CABLES_HELD:
        return world.with_hand(cell, held=goal.cable_end)
    return world


# --- what is asked


def _check_locate(world: World, _: str, goal: Any) -> None:  # noqa: ANN401
    known(world.panel.components, goal.component_id, "component")
    if goal.terminal_id:
        _check_terminal(world, goal)


def _check_connection(world: World, _: str, goal: Any) -> None:  # noqa: ANN401
    known(world.panel.wires, goal.cable_id, "wire")
    _check_terminal(world, goal)
    _check_end(goal)


def _check_pick(world: World, cell: str, goal: Any) -> None:  # noqa: ANN401
    _check_robot(goal)
    _check_end(goal)
    if goal.grasp_distance:
        _check_number("grasp_distance", goal.grasp_distance, *GRASP_RANGE_M)
    _check_live(world, cell, goal)
    hand = world.hand(cell)
    if hand.held:
        raise WorldError(
            ErrorCode.OTHER_CABLE_HELD,
            f"the gripper holds end {hand.held} of {hand.live!r} already; place it first",
        )
    _check_loose(world, goal)


def _check_carry(world: World, cell: str, goal: Any) -> None:  # noqa: ANN401
    _check_robot(goal)
    poses = getattr(goal, "path", None)
    if poses is not None and not poses:
        raise WorldError(ErrorCode.INVALID_GOAL, "path is empty; it must have one pose or more")
    _check_live(world, cell, goal)
    _check_held(world, cell)


def _check_insert(world: World, cell: str, goal: Any) -> None:  # noqa: ANN401
    _check_robot(goal)
    _check_end(goal)
    _check_number("force_limit", goal.force_limit, 1.0, MAX_FORCE_N)
    _check_live(world, cell, goal)
    _check_terminal(world, goal)
    held = world.hand(cell).held
    if held and held != goal.cable_end:
        raise WorldError(
            ErrorCode.OTHER_CABLE_HELD,
            f"the gripper holds end {held}, not end {goal.cable_end}; place it first",
        )
    _check_loose(world, goal)
    occupant = world.occupant(_terminal(goal))
    if occupant is not None:
        raise WorldError(
            ErrorCode.TERMINAL_OCCUPIED, f"terminal {_terminal(goal)!r} holds end {occupant!r}"
        )


def _check_fix(world: World, cell: str, goal: Any) -> None:  # noqa: ANN401
    _check_robot(goal)
    _check_number("pull_test_force", goal.pull_test_force, 0.0, MAX_FORCE_N)
    _check_live(world, cell, goal)
    _check_terminal(world, goal)
    _check_held(world, cell)


def _check_extract(world: World, cell: str, goal: Any) -> None:  # noqa: ANN401
    _check_robot(goal)
    _check_live(world, cell, goal)
    _check_terminal(world, goal)


def _check_connector(world: World, _: str, goal: Any) -> None:  # noqa: ANN401
    _check_robot(goal)
    if not goal.connector_id:
        raise WorldError(ErrorCode.UNKNOWN_NAME, "connector_id is empty")
    _check_number("force_limit", goal.force_limit, 1.0, math.inf)


def _check_pin(_: World, __: str, goal: Any) -> None:  # noqa: ANN401
    for robot in (goal.robot_1_name, goal.robot_2_name):
        known(ROBOTS, robot, "robot")


# --- what is done


def _locate(world: World, _: str, goal: Any) -> Effect:  # noqa: ANN401
    found: dict[str, Place] = {"component_pose": world.panel.components[goal.component_id]}
    if goal.terminal_id:
        found["socket_pose"] = world.panel.mouths[_terminal(goal)]
    return Effect(world, f"{goal.component_id} is where the panel has it", found=found)


def _detect(world: World, _: str, goal: Any) -> Effect:  # noqa: ANN401
    loose = [end for end in "ab" if world.seat(goal.cable_id, end) is None]
    length_m = world.panel.lengths[goal.cable_id]
    text = f"{goal.cable_id} is seen, loose ends: {', '.join(loose) or 'none'}"
    return Effect(world, text, found={"observation": (goal.cable_id, length_m, len(loose))})


def _look_at_connection(world: World, _: str, goal: Any) -> Effect:  # noqa: ANN401
    connected = world.seat(goal.cable_id, goal.cable_end) == Seat(_terminal(goal), True)
    text = f"end {goal.cable_end} of {goal.cable_id} {'sits' if connected else 'does not sit'} in"
    return Effect(world, f"{text} {_terminal(goal)}", found={"connected": connected})


def _pick(world: World, cell: str, goal: Any) -> Effect:  # noqa: ANN401
    text = f"end {goal.cable_end} of {goal.cable_id} held"
    return Effect(world.with_hand(cell, held=goal.cable_end), text, found={"grip_width": GRIP_M})


def _place(world: World, cell: str, goal: Any) -> Effect:  # noqa: ANN401
    return Effect(_let_go(_disengaged(world, cell), cell), f"{goal.cable_id} laid down")


def _route(world: World, cell: str, goal: Any) -> Effect:  # noqa: ANN401
    count = len(goal.path)
    text = f"{goal.cable_id} carried along {count} poses"
    return Effect(_disengaged(world, cell), text, found={"reached": count})


def _insert(world: World, cell: str, goal: Any) -> Effect:  # noqa: ANN401
    held = world.with_hand(cell, held=goal.cable_end)
    after = held.with_seat(goal.cable_id, goal.cable_end, Seat(_terminal(goal), False))
    text = f"end {goal.cable_end} of {goal.cable_id} seated in {_terminal(goal)}"
    found = {"depth": DEPTH_M, "peak_force": min(PUSH_N, goal.force_limit)}
    return Effect(after, text, found=found)


def _fix(world: World, cell: str, goal: Any) -> Effect:  # noqa: ANN401
    end = world.hand(cell).held
    terminal = _terminal(goal)
    if world.seat(goal.cable_id, end) != Seat(terminal, False):
        raise WorldError(
            ErrorCode.NOT_SEATED,
            f"the screw of {terminal!r} met nothing: end {end} is not in it; insert it first",
        )
    after = _let_go(world, cell).with_seat(goal.cable_id, end, Seat(terminal, True))
    entry = Entry(Deed.FIX, cell, goal.cable_id, end, terminal, goal.id)
    return Effect(after, f"end {end} of {goal.cable_id} fixed in {terminal}", (entry,))


def _extract(world: World, cell: str, goal: Any) -> Effect:  # noqa: ANN401
    end = _end_meant(world, cell, goal)
    seat = world.seat(goal.cable_id, end)
    after = _let_go(world, cell).with_seat(goal.cable_id, end, None)
    if seat is None or not seat.fixed:
        return Effect(after, f"end {end} of {goal.cable_id} laid down")
    entry = Entry(Deed.LOOSEN, cell, goal.cable_id, end, seat.terminal, goal.id)
    return Effect(after, f"end {end} of {goal.cable_id} out of {seat.terminal}", (entry,))


def _mate(world: World, cell: str, goal: Any) -> Effect:  # noqa: ANN401
    found = {"depth": DEPTH_M, "peak_force": min(PUSH_N, goal.force_limit)}
    return Effect(_let_go(world, cell), f"{goal.connector_id} mated", found=found)


def _place_pin(world: World, _: str, __: Any) -> Effect:  # noqa: ANN401
    return Effect(world, "pin placed")


# --- what they share


def _terminal(goal: Any) -> str:  # noqa: ANN401
    return f"{goal.component_id}/{goal.terminal_id}"


def _check_robot(goal: Any) -> None:  # noqa: ANN401
    known(ROBOTS, goal.robot_name, "robot")


def _check_end(goal: Any) -> None:  # noqa: ANN401
    if goal.cable_end not in ("a", "b"):
        text = f"cable_end is {goal.cable_end!r}; allowed: 'a', 'b'"
        raise WorldError(ErrorCode.INVALID_GOAL, text)


def _check_number(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        text = f"{name} is {value:g}; allowed: {low:g} to {high:g}"
        raise WorldError(ErrorCode.INVALID_GOAL, text)


def _check_terminal(world: World, goal: Any) -> None:  # noqa: ANN401
    known(world.panel.components, goal.component_id, "component")
    known(world.panel.mouths, _terminal(goal), "terminal")


def _check_live(world: World, cell: str, goal: Any) -> None:  # noqa: ANN401
    known(world.panel.wires, goal.cable_id, "wire")
    live = world.hand(cell).live
    if live != goal.cable_id:
        raise WorldError(
            ErrorCode.WIRE_NOT_FED,
            f"wire {goal.cable_id!r} is not the one fed last, which is {live or 'none'!r}; feed it "
            "first",
        )


def _check_held(world: World, cell: str) -> None:
    if not world.hand(cell).held:
        text = "the gripper is empty; pick the wire first"
        raise WorldError(ErrorCode.NOTHING_HELD, text)


def _check_loose(world: World, goal: Any) -> None:  # noqa: ANN401
    seat = world.seat(goal.cable_id, goal.cable_end)
    if seat is not None:
        how = "fixed" if seat.fixed else "seated"
        raise WorldError(
            ErrorCode.INVALID_GOAL,
            f"end {goal.cable_end} of {goal.cable_id!r} is {how} in a terminal; extract it first",
        )


def _end_meant(world: World, cell: str, goal: Any) -> str:  # noqa: ANN401
    """Return the end in the hand, the one in that terminal, or the one that belongs there."""
    if world.hand(cell).held:
        return world.hand(cell).held
    for end in "ab":
        seat = world.seat(goal.cable_id, end)
        if seat is not None and seat.terminal == _terminal(goal):
            return end
    return "b" if world.panel.wires[goal.cable_id][1] == _terminal(goal) else "a"


def _disengaged(world: World, cell: str) -> World:
    """Return the world with the held end out of the terminal that it may be seated in."""
    hand = world.hand(cell)
    return world.with_seat(hand.live, hand.held, None)


def _let_go(world: World, cell: str) -> World:
    return world.with_hand(cell, held="")


# --- all of them

OPERATIONS: Mapping[str, Operation] = MappingProxyType(
    {
        "CheckConnection": Operation(_check_connection, _look_at_connection),
        "DetectCable": Operation(_check_live, _detect),
        "ExtractCable": Operation(_check_extract, _extract),
        "FixCable": Operation(_check_fix, _fix),
        "InsertCable": Operation(_check_insert, _insert),
        "LocateGearboxComponent": Operation(_check_locate, _locate),
        "PickCable": Operation(_check_pick, _pick),
        "PlaceCable": Operation(_check_carry, _place),
        "PlaceConnector": Operation(_check_connector, _mate),
        "PlacePin": Operation(_check_pin, _place_pin),
        "RouteWire": Operation(_check_carry, _route),
    }
)
