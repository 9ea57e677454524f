"""Robots that hold the same wire move together; one holds its free end out of the way of another.

Several steps run at once.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np

from remodel_skills.motion import Line
from remodel_skills.parameters import WireParameters
from remodel_skills.primitives.motions import (
    NOTHING,
    canonical,
    check_lag,
    check_tracking,
    is_free,
    straight_line,
    wait_to_follow,
)
from remodel_skills.robot_context import RobotContext, Steps
from remodel_states.core.codes import Code
from remodel_work.errors import AbilityError
from remodel_work.geometry import Array, wrap_angle
from remodel_work.robot.arm import ToolPose
from remodel_work.robot.arm_volume import gap_between, volume_of


def move_together(
    targets: Sequence[tuple[RobotContext, ToolPose]],
    speed: float,
    others: float | None = None,
    allowed: Set[str] = NOTHING,
) -> Steps[None]:
    """Move all tools in straight lines that begin and end at the same time.

    So the distance between two of them is never more than at the start or at the end, and the wire
    between them is never pulled taut on the way.

    Args:
        targets: the robots, each with where its tool goes.
        speed: that no tool centre exceeds, or only the first one's [m/s].
        others: the same of the other ones [m/s]; None: as of the first.
        allowed: names of obstacles that the first one may touch.

    Raises:
        AbilityError: UNREACHABLE before anything moves, MOTION_FAULT when a robot does not arrive.
    """
    speeds = [speed, *[speed if others is None else others] * (len(targets) - 1)]
    touchable = [allowed, *[NOTHING] * (len(targets) - 1)]
    lines = [
        straight_line(context, target, most, may_touch)
        for (context, target), most, may_touch in zip(targets, speeds, touchable, strict=True)
    ]
    duration = max(line.duration for line in lines)
    contexts = [context for context, _ in targets]
    moves = [(c, replace(line, least_s=duration)) for c, line in zip(contexts, lines, strict=True)]
    _check_apart(moves)
    for context, line in moves:
        context.space.take(line.postures(context.arm))
    tick_s = contexts[0].tick_s
    for tick in range(1, math.ceil(duration / tick_s) + 1):
        for context, line in moves:
            context.follow(line.at(tick * tick_s))
        yield
        for context, line in moves:
            check_lag(context, line.at((tick - context.lead_ticks) * tick_s))
    for context, line in moves:
        context.follow(line.end)
    yield from wait_to_follow(contexts[0])
    for context in contexts:
        context.space.stand(context.commanded)
        check_tracking(context)


def _check_apart(moves: Sequence[tuple[RobotContext, Line]]) -> None:
    """Raise UNREACHABLE when two robots would come too near to each other on the way."""
    gap, margin_m = least_gap(moves), moves[0][0].parameters.motion.robots_apart_m
    if gap < margin_m:
        names = " and ".join(context.name for context, _ in moves)
        raise AbilityError(
            Code.UNREACHABLE,
            f"{names} would come within {gap * 1e3:.0f} mm of each other on the way to "
            f"{moves[0][1].end}; allowed: {margin_m * 1e3:.0f} mm or more",
        )


def least_gap(moves: Sequence[tuple[RobotContext, Line]]) -> float:
    """Return the least distance between robots that move along lines at the same time [m].

    Raises:
        AbilityError: UNREACHABLE when a robot does not reach a place on its line.
    """
    step_m = moves[0][0].parameters.motion.check_step_m
    farthest = max(line.distance for _, line in moves)
    shares = np.linspace(0.0, 1.0, max(3, math.ceil(farthest / step_m) + 1))
    least = math.inf
    for (one, first), (other, second) in combinations(moves, 2):
        for share in shares:
            volumes = [
                volume_of(context.arm, context.arm.joints_for(line.between(share)))
                for context, line in ((one, first), (other, second))
            ]
            least = min(least, gap_between(*volumes))
    return least


def concurrently(*all_steps: Steps[Any]) -> Steps[tuple[Any, ...]]:
    """Do one step of each per tick, until the last is done; return what each returns.

    When one of them raises, the others are stopped where they are.
    """
    results: dict[int, Any] = {}
    pending = dict(enumerate(all_steps))
    try:
        while pending:
            for i, steps in tuple(pending.items()):
                try:
                    next(steps)
                except StopIteration as done:
                    results[i] = done.value
                    del pending[i]
            if pending:
                yield
    finally:
        for steps in pending.values():
            steps.close()
    return tuple(results[i] for i in range(len(all_steps)))


@dataclass(frozen=True)
class Hold:
    """How the other end is held.

    Attributes:
        shares: the straight distance between the places at which the wire is held, as a share of
            its length between them; the best first.
        most: on the way it is never more than this share.
        up_rad: how steeply the wire rises from the working hand, the best first [rad].
    """

    shares: tuple[float, ...]
    most: float
    up_rad: tuple[float, ...]


def slack_hold(wire: WireParameters) -> Hold:
    """Return how a wire is held that hangs a little, and pulls at neither hand."""
    return Hold(wire.slack_shares, wire.slack_most_share, wire.slack_up_rad)


def steep_hold(wire: WireParameters) -> Hold:
    """Return how a wire is held that is nearly straight, and rises over the next corner's wall."""
    return Hold(wire.steep_shares, wire.steep_most_share, wire.steep_up_rad)


def flat_hold(wire: WireParameters) -> Hold:
    """Return how a wire is held that leaves a terminal and its slot flatly.

    So flatly that an eyelet closes around it there.
    """
    return Hold(wire.flat_shares, wire.flat_most_share, wire.flat_up_rad)


def holder_of(context: RobotContext) -> RobotContext | None:
    """Return the other robot that holds the live wire's other end and does nothing else."""
    grip = context.belief.grip
    for peer in context.peers:
        held = peer.belief.grip
        if held is not None and grip is not None and held.end is grip.end.other and not peer.busy:
            return peer
    return None


def free_length(context: RobotContext, holder: RobotContext) -> float:
    """Return how long the wire is between the grips of two robots [m]."""
    mine, other = context.belief.grip, holder.belief.grip
    assert mine is not None and other is not None, "both hold it"
    return context.wire.length - mine.distance - other.distance


def bring_together(
    working: RobotContext,
    tool: ToolPose,
    holder: RobotContext,
    out: Array,
    length: float,
    hold: Hold | None = None,
    front: float | None = None,
    then: ToolPose | None = None,
    keeps: bool = False,
) -> list[list[tuple[RobotContext, ToolPose]]]:
    """Plan how a robot moves with a part of a wire while another one keeps the rest off the board.

    Args:
        working: the robot that inserts or leads the wire.
        tool: where its tool goes.
        holder: holds the free end.
        out: in which the wire then leaves the working hand, unit vector (3,), level.
        length: of the wire from there to the holder's grip [m].
        hold: how tightly and steeply; None: it hangs a little.
        front: yaw of the working hand's side at which the wire leaves it [rad]; None: of `out`.
        then: where the working hand goes afterwards, while the other one stays.
        keeps: whether it has the wire then.

    Returns:
        Moves, one after the other: all robots of a move move at the same time.

    Raises:
        AbilityError: UNREACHABLE.
    """
    front = math.atan2(out[1], out[0]) if front is None else front
    tool = canonical(working, tool)
    hold = hold or slack_hold(working.parameters.wire)
    for share in hold.shares:
        for place in _places(holder, tool, out, share * length, hold.up_rad):
            if not holder.arm.reaches(place):
                continue
            after = [] if then is None else [[(working, then), (holder, place)]]
            for moves in _orders(working, tool, holder, place):
                with_wire = [*moves, *after] if keeps else moves
                if (
                    _is_slack(with_wire, hold.most * length)
                    and _leaves_in_front(moves, tool.yaw - front)
                    and _are_apart([*moves, *after])
                    and _keeps_clear(holder, moves)
                ):
                    return moves
    raise AbilityError(
        Code.UNREACHABLE,
        f"{holder.name} has no place to hold the other end of {working.wire.id!r} while "
        f"{working.name} is at {tool}; present the wire nearer to its terminals",
    )


def hold_off(
    holder: RobotContext,
    at: ToolPose,
    out: Array,
    length: float,
    hold: Hold,
    visits: Sequence[tuple[RobotContext, ToolPose]] = (),
) -> list[tuple[RobotContext, ToolPose]]:
    """Plan where a robot holds a wire that is fixed at its other end; the other robots stay.

    Args:
        holder: holds the free end.
        at: where the wire comes from.
        out: in which it goes on from there, unit vector (3,), level.
        length: of the wire from there to the holder's grip [m].
        hold: how tightly and steeply.
        visits: where another robot goes then, one place after the other.

    Returns:
        A move of all robots at the same time; none where there is no such place.
    """
    others = [(peer, peer.commanded) for peer in holder.peers]
    for share in hold.shares:
        for place in _places(holder, at, out, share * length, hold.up_rad):
            move = [(holder, place), *others]
            if (
                holder.arm.reaches(place)
                and _are_apart([move])
                and all(_leaves_room(holder, place, visit) for visit in visits)
                and _keeps_clear(holder, [move])
            ):
                return move
    return []


def _orders(
    working: RobotContext, tool: ToolPose, holder: RobotContext, place: ToolPose
) -> Iterator[list[list[tuple[RobotContext, ToolPose]]]]:
    """Yield ways to get there: both at once, or one first, while the other one stays."""
    here, there = working.commanded, holder.commanded
    yield [[(working, tool), (holder, place)]]
    yield [[(working, here), (holder, place)], [(working, tool), (holder, place)]]
    yield [[(working, tool), (holder, there)], [(working, tool), (holder, place)]]


def _is_slack(moves: list[list[tuple[RobotContext, ToolPose]]], most: float) -> bool:
    """Return whether two hands are never farther from each other than this [m]."""
    return all(
        float(np.linalg.norm(one.position - other.position)) <= most
        for (_, one), (_, other) in moves
    )


def _leaves_in_front(moves: list[list[tuple[RobotContext, ToolPose]]], turned: float) -> bool:
    """Return whether the wire never winds around the first hand: it goes away from its front.

    Args:
        moves: of the working hand, then of the holder's.
        turned: the working hand's yaw against that of its side at which the wire leaves it [rad].
    """
    motion = moves[0][0][0].parameters.motion
    at = [context.commanded for context, _ in moves[0]]
    for move in moves:
        lines = [
            Line(start, target, 1.0, motion) for start, (_, target) in zip(at, move, strict=True)
        ]
        for share in np.linspace(0.0, 1.0, 9):
            hand, other = (line.between(share) for line in lines)
            yaw = math.atan2(other.y - hand.y, other.x - hand.x)
            if abs(wrap_angle(yaw - hand.yaw + turned)) > motion.most_aside_rad and share > 0:
                return False
        at = [target for _, target in move]
    return True


def _are_apart(moves: list[list[tuple[RobotContext, ToolPose]]]) -> bool:
    motion = moves[0][0][0].parameters.motion
    at = {context: context.commanded for context, _ in moves[0]}
    for move in moves:
        lines = [(context, Line(at[context], target, 1.0, motion)) for context, target in move]
        if least_gap(lines) < motion.holding_apart_m:
            return False
        at.update(move)
    return True


def _leaves_room(
    holder: RobotContext, place: ToolPose, visit: tuple[RobotContext, ToolPose]
) -> bool:
    """Return whether another robot may stand where it goes while the holder is at a place."""
    working, there = visit
    lines = [Line(at, at, 1.0, holder.parameters.motion) for at in (place, there)]
    gap = least_gap(list(zip((holder, working), lines, strict=True)))
    return gap >= holder.parameters.motion.holding_apart_m


def _keeps_clear(holder: RobotContext, moves: list[list[tuple[RobotContext, ToolPose]]]) -> bool:
    """Return whether the holder touches nothing that stands on the plate."""
    here = holder.commanded
    for move in moves:
        there = dict(move)[holder]
        if there != here and not is_free(holder, there, start=here):
            return False
        here = there
    return True


def _places(
    holder: RobotContext, tool: ToolPose, out: Array, straight: float, ups: Sequence[float]
) -> list[ToolPose]:
    """Return places so far from a tool [m], the least cost first."""
    motion, found = holder.parameters.motion, list[tuple[float, ToolPose]]()
    heading, grip = math.atan2(out[1], out[0]), holder.belief.grip
    assert grip is not None, "it holds the end"
    for aside in motion.hold_aside_rad:
        for up in ups:
            z = float(np.clip(tool.z + straight * math.sin(up), *motion.hold_z_m))
            level, yaw = math.sqrt(straight**2 - min(straight, z - tool.z) ** 2), heading + aside
            x, y = tool.x + level * math.cos(yaw), tool.y + level * math.sin(yaw)
            # The tip points away: the other way round the wire would turn back beside the hand.
            now = holder.commanded.yaw
            hand = holder.arm.canonical_yaw(x, y, now + float(wrap_angle(yaw - grip.flip - now)))
            if hand is None:
                continue
            place = ToolPose(x, y, z, hand)
            way = float(np.linalg.norm(place.position - holder.commanded.position))
            steep = motion.hold_up_cost * abs(up - ups[0])
            found.append((abs(aside) + steep + motion.hold_way_cost * way, place))
    return [place for _, place in sorted(found, key=lambda each: each[0])]
