"""What each ability does to the world.

The effects are those of the skills (remodel_skills.abilities); forces and shapes are left out.
A goal is anything with the fields of the ability's goal message.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from remodel_msgs.msg import ErrorCode

from remodel_states.core.ability_error import AbilityError
from remodel_states.core.contract import ROBOT_FIELDS
from remodel_states.testing import requirements
from remodel_states.testing.requirements import Goal, terminal_of
from remodel_states.testing.world import Deed, Entry, Place, Seat, World

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


# --- what is done


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
        "CheckConnection": Operation(
            requirements.check_connection, _check_connection, observes=True
        ),
        "DetectCable": Operation(requirements.check_live, _detect, observes=True),
        "DiscardCable": Operation(requirements.check_discard, _discard, includes=_extracts_ends),
        "ExtractCable": Operation(requirements.check_extract, _extract),
        "FixCable": Operation(requirements.check_fix, _fix),
        "InsertCable": Operation(requirements.check_insert, _insert),
        "LayWire": Operation(requirements.check_lay, _lay),
        "LocateGearboxComponent": Operation(requirements.check_locate, _locate, observes=True),
        "PickCable": Operation(requirements.check_pick, _pick),
        "PlaceCable": Operation(requirements.check_place, _place),
        "PlaceConnector": Operation(requirements.check_connector, _mate),
        "PlacePin": Operation(requirements.check_pin, _place_pin),
        "RouteWire": Operation(requirements.check_carry, _route),
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
