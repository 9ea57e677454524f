"""The magazine: presents a wire between clips, and lets its loop come to rest."""

from __future__ import annotations

import numpy as np

from remodel_sim.core.wires.hanging_loop import HeldEnd
from remodel_sim.physics.fixtures.clips import add_clip
from remodel_sim.physics.live_wire import hanging_cable
from remodel_sim.physics.wires.cable import SimulatedWire
from remodel_sim.physics.world import World
from remodel_work.cell.magazine import (
    Magazine,
    disturbed,
    fork_clips,
    held_length,
    plan_presentation,
    stop_box,
)
from remodel_work.cell.presentation import Presentation
from remodel_work.edge.bullet import add_static
from remodel_work.panel import Panel, PanelWire, WireEnd

# The ends are held until the loop has come to rest in the clips, with this force.
SETTLING_S = 0.5
HOLDING_N = 20.0
# Then they come to rest themselves.
REST_S = 0.5


def present(
    world: World, magazine: Magazine, panel: Panel, wire: PanelWire, noise: np.random.Generator
) -> tuple[SimulatedWire, Presentation, dict[WireEnd, tuple[int, ...]]]:
    """Put a wire into the magazine's clips.

    Returns:
        The wire, where its ends should be, and the clips that hold each end.
    """
    presentation = plan_presentation(magazine, panel, wire)
    tips = disturbed(presentation.tips, noise, is_short=magazine.is_short(wire.length))
    clips: dict[WireEnd, tuple[int, ...]] = {}
    for end, tip in tips.items():
        clips[end] = tuple(add_clip(world, clip, pose) for clip, pose in fork_clips(wire, tip))
        add_static(world.bullet, [stop_box(wire)], tip)
    a, b = (HeldEnd(tips[end].position, tips[end].rotation[:, 0], held_length()) for end in WireEnd)
    cable = hanging_cable(world, wire, a, b)
    holders = [_hold(world, cable, end) for end in WireEnd]
    _rest(world, SETTLING_S)
    for holder in holders:
        world.bullet.removeConstraint(holder)
    _rest(world, REST_S)
    return cable, presentation, clips


def _hold(world: World, cable: SimulatedWire, end: WireEnd) -> int:
    """Hold an end where it is; return the constraint."""
    link = cable.ferrule(end)
    position, quaternion = cable.link_pose(link)
    constraint = world.bullet.createConstraint(
        *link,
        childBodyUniqueId=-1,
        childLinkIndex=-1,
        jointType=world.bullet.JOINT_FIXED,
        jointAxis=[0, 0, 0],
        parentFramePosition=[0, 0, 0],
        childFramePosition=position.tolist(),
        parentFrameOrientation=[0, 0, 0, 1],
        childFrameOrientation=quaternion.tolist(),
    )
    world.bullet.changeConstraint(constraint, maxForce=HOLDING_N)
    return int(constraint)


def _rest(world: World, seconds: float) -> None:
    for _ in range(round(seconds / world.time_step)):
        world.step()
