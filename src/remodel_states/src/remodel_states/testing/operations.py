"""What each ability asks of the world before it moves, and what it does to it.

Both are those of the simulated cell (remodel_skills.abilities); reach, forces and shapes are left
out. A check raises AbilityError unless a cell can take a goal as the world is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from remodel_msgs.msg import ErrorCode

from remodel_states.core.ability_error import AbilityError
from remodel_states.core.contract import ROBOT_FIELDS
from remodel_states.testing.world import Deed, Entry, Goal, Place, Seat, World, known

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


# What each ability does


# What is measured where nothing is: [m] an end is deep, [N] it took, [m] between the pads, [N] a
# wire pulls at the hand that leads it.
DEPTH_M = 0.012
PUSH_N = 5.0
GRIP_M = 0.003
LEAD_N = 4.0

# Failures of which the table of error codes states that nothing moved.
_UNMOVED = frozenset({ErrorCode.STALE_OWNER, ErrorCode.SEVERAL_SERVERS})


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
        check: raises AbilityError unless a cell can take a goal as the world is.
        do: returns the effect; raises AbilityError when it fails.
        observes: whether it moves nothing.
        includes: returns the abilities that are a part of it, as the world is: what goes wrong with
            them goes wrong with it.
    """

    check: Callable[[World, str, Goal], None]
    do: Callable[[World, str, Goal], Effect]
    observes: bool = False
    includes: Callable[[World, str, Goal], tuple[str, ...]] = lambda *_: ()


def fail(world: World, cell: str, ability: str, code: int, goal: Goal) -> World:
    """Return the world after an ability failed with a code."""
    if code in _UNMOVED:
        return world
    if code == ErrorCode.GRASP_SLIPPED:
        return _release(world, cell, goal)
    if ability == "InsertCable" and code < ErrorCode.UNKNOWN_NAME:
        return _grip(world, cell, goal)  # it was picked, or held before
    if ability == "PickCable" and code == ErrorCode.TWO_CABLES_HELD:
        return _grip(world, cell, goal)
    return world


def _locate(world: World, _: str, goal: Goal) -> Effect:
    found: dict[str, Place] = {"component_pose": world.panel.components[goal.component_id]}
    if goal.terminal_id:
        found["socket_pose"] = world.panel.openings[terminal_of(goal)]
    return Effect(world, f"{goal.component_id} is where the panel has it", found=found)


def _detect(world: World, _: str, goal: Goal) -> Effect:
    loose = [end for end in "ab" if world.seat(goal.cable_id, end) is None]
    length_m = world.panel.lengths[goal.cable_id]
    text = f"{goal.cable_id} is seen, loose ends: {', '.join(loose) or 'none'}"
    return Effect(world, text, found={"observation": (goal.cable_id, length_m, len(loose))})


def _check_connection(world: World, _: str, goal: Goal) -> Effect:
    connected = world.seat(goal.cable_id, goal.cable_end) == Seat(terminal_of(goal), True)
    text = f"end {goal.cable_end} of {goal.cable_id} {'sits' if connected else 'does not sit'} in"
    return Effect(world, f"{text} {terminal_of(goal)}", found={"connected": connected})


def _pick(world: World, cell: str, goal: Goal) -> Effect:
    text = f"end {goal.cable_end} of {goal.cable_id} held"
    return Effect(_grip(world, cell, goal), text, found={"grip_width": GRIP_M})


def _place(world: World, cell: str, goal: Goal) -> Effect:
    text = f"{world.hands_in(cell).live} laid down"
    return Effect(_release(_disengaged(world, cell, goal), cell, goal), text)


def _discard(world: World, cell: str, goal: Goal) -> Effect:
    wire = _wire_to_discard(world, cell, goal)
    if wire not in world.fed:
        return Effect(world, "there is nothing to discard")
    entry = Entry(Deed.DISCARD, cell, wire, goal=goal.id)
    return Effect(world.discard(wire), f"{wire} is in the scrap bin", (entry,))


def _extracts_ends(world: World, cell: str, goal: Goal) -> tuple[str, ...]:
    """Return ExtractCable if the wire that is discarded is connected."""
    wire = _wire_to_discard(world, cell, goal)
    return ("ExtractCable",) if world.is_connected(wire) else ()


def _route(world: World, cell: str, goal: Goal) -> Effect:
    count = len(goal.path)
    text = f"{goal.cable_id} carried along {count} poses"
    return Effect(_disengaged(world, cell, goal), text, found={"reached": count})


def _lay(world: World, _: str, goal: Goal) -> Effect:
    ducts = ", ".join(world.panel.ducts[goal.cable_id])
    found = {"peak_force": LEAD_N}
    return Effect(world, f"{goal.cable_id} laid into {ducts}", found=found)


def _insert(world: World, cell: str, goal: Goal) -> Effect:
    held = _grip(world, cell, goal)
    after = held.with_seat(goal.cable_id, goal.cable_end, Seat(terminal_of(goal), False))
    text = f"end {goal.cable_end} of {goal.cable_id} seated in {terminal_of(goal)}"
    found = {"depth": DEPTH_M, "peak_force": min(PUSH_N, goal.force_limit)}
    return Effect(after, text, found=found)


def _fix(world: World, cell: str, goal: Goal) -> Effect:
    end = world.hands_in(cell).of(goal.robot_name)
    terminal = terminal_of(goal)
    if world.seat(goal.cable_id, end) != Seat(terminal, False):
        raise AbilityError(
            ErrorCode.NOT_SEATED,
            f"the clamp of {terminal!r} met nothing: end {end} is not in it; insert it first",
        )
    after = _release(world, cell, goal).with_seat(goal.cable_id, end, Seat(terminal, True))
    entry = Entry(Deed.FIX, cell, goal.cable_id, end, terminal=terminal, goal=goal.id)
    return Effect(after, f"end {end} of {goal.cable_id} fixed in {terminal}", (entry,))


def _extract(world: World, cell: str, goal: Goal) -> Effect:
    end = _end_meant(world, cell, goal)
    seat = world.seat(goal.cable_id, end)
    after = _release(world, cell, goal).with_seat(goal.cable_id, end, None)
    if seat is None or not seat.fixed:
        return Effect(after, f"end {end} of {goal.cable_id} laid down")
    entry = Entry(Deed.LOOSEN, cell, goal.cable_id, end, terminal=seat.terminal, goal=goal.id)
    return Effect(after, f"end {end} of {goal.cable_id} out of {seat.terminal}", (entry,))


def _mate(world: World, cell: str, goal: Goal) -> Effect:
    found = {"depth": DEPTH_M, "peak_force": min(PUSH_N, goal.force_limit)}
    return Effect(_release(world, cell, goal), f"{goal.connector_id} mated", found=found)


def _place_pin(world: World, _: str, __: Goal) -> Effect:
    return Effect(world, "pin placed")


# --- what they share


def _wire_to_discard(world: World, cell: str, goal: Goal) -> str:
    """Return the wire that is meant, or the one in the hand; empty if there is none."""
    hands = world.hands_in(cell)
    return goal.cable_id or (hands.live if hands.of(goal.robot_name) else "")


def _end_meant(world: World, cell: str, goal: Goal) -> str:
    """Return the end in the hand, the one in that terminal, or the one that belongs there."""
    held = world.hands_in(cell).of(goal.robot_name)
    if held:
        return held
    for end in "ab":
        seat = world.seat(goal.cable_id, end)
        if seat is not None and seat.terminal == terminal_of(goal):
            return end
    return "b" if world.panel.wires[goal.cable_id][1] == terminal_of(goal) else "a"


def _disengaged(world: World, cell: str, goal: Goal) -> World:
    """Return the world with the held end out of the terminal that it may be seated in."""
    hands = world.hands_in(cell)
    return world.with_seat(hands.live, hands.of(goal.robot_name), None)


def _grip(world: World, cell: str, goal: Goal) -> World:
    return world.with_held(cell, goal.robot_name, goal.cable_end)


def _release(world: World, cell: str, goal: Goal) -> World:
    for robot in [getattr(goal, name) for name in ROBOT_FIELDS if hasattr(goal, name)]:
        world = world.with_held(cell, robot, "")
    return world


# --- all that change or observe the world

OPERATIONS: Mapping[str, Operation] = MappingProxyType(
    {
        "CheckConnection": Operation(check_connection, _check_connection, observes=True),
        "DetectCable": Operation(check_live, _detect, observes=True),
        "DiscardCable": Operation(check_discard, _discard, includes=_extracts_ends),
        "ExtractCable": Operation(check_extract, _extract),
        "FixCable": Operation(check_fix, _fix),
        "InsertCable": Operation(check_insert, _insert),
        "LayWire": Operation(check_lay, _lay),
        "LocateGearboxComponent": Operation(check_locate, _locate, observes=True),
        "PickCable": Operation(check_pick, _pick),
        "PlaceCable": Operation(check_place, _place),
        "PlaceConnector": Operation(check_connector, _mate),
        "PlacePin": Operation(check_pin, _place_pin),
        "RouteWire": Operation(check_carry, _route),
    }
)


# An ability of which this world knows nothing: it can always be done, and changes nothing.
_UNKNOWN = Operation(lambda *_: None, lambda world, *_: Effect(world, "done"), observes=True)


def operation_of(ability: str) -> Operation:
    """Return what an ability does."""
    return OPERATIONS.get(ability, _UNKNOWN)


def perform(ability: str, world: World, cell: str, goal: Goal, code: int = 0) -> Effect:
    """Return the effect of an ability; with a code, of its failure.

    Raises:
        AbilityError: if it fails as the world is.
    """
    operation = operation_of(ability)
    done = Effect(fail(world, cell, ability, code, goal=goal), "") if code else None
    effect = done or operation.do(world, cell, goal)
    if operation.observes or code in _UNMOVED:
        return effect
    return replace(effect, world=effect.world.touched(getattr(goal, "cable_id", "")))
