import math

import numpy as np
import pytest
from panels import wire

from remodel_sim.core.wire_mechanics import HeldEnd, discretise, hanging_loop
from remodel_sim.physics.live_wire import hanging_cable
from remodel_sim.physics.world import World
from remodel_work.panel import WireEnd

FORWARD = np.array([1.0, 0.0, 0.0])


def ordered(length, **changes):
    return wire("W", ("X", "1"), ("Y", "1"), length, **changes)


def model_of(length, **changes):
    return discretise(ordered(length, **changes), 1 / 240)


def side_by_side(straight=0.0, gap=0.08):
    return [HeldEnd(np.array([0.2, s * gap / 2, 0.03]), FORWARD, straight) for s in (-1, 1)]


def hold(world, cable, end):
    bullet, link = world.bullet, cable.ferrule(end)
    position, quaternion = cable.link_pose(link)
    held = bullet.createConstraint(
        *link, -1, -1, bullet.JOINT_FIXED, [0, 0, 0], [0, 0, 0], position.tolist(),
        [0, 0, 0, 1], quaternion.tolist(),
    )  # fmt: skip
    bullet.changeConstraint(held, maxForce=1e4)


@pytest.mark.physics
@pytest.mark.parametrize("length", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("diameter, density, stiffness", [(0.003, 0.02, 1e-3), (6e-3, 0.115, 6e-3)])
def test_a_wire_laid_into_its_loop_is_at_rest(length, diameter, density, stiffness):
    whole = ordered(
        length,
        diameter=diameter,
        linear_density=density,
        bending_stiffness=stiffness,
        torsional_stiffness=0.75 * stiffness,
    )
    world = World(240)
    cable = hanging_cable(world, whole, *side_by_side())
    nodes = cable.nodes()
    for end in WireEnd:
        hold(world, cable, end)
    for _ in range(240):
        world.step()
    moved = np.abs(cable.nodes() - nodes).max()
    world.close()
    assert nodes[:, 2].min() < 0.03 - 0.25 * length
    assert moved < 5e-4


def test_a_limp_wire_hangs_in_a_catenary():
    model = model_of(1.0, bending_stiffness=1e-7, torsional_stiffness=1e-7)
    down = np.array([0.0, 0.0, 1.0])
    span = 0.5
    a, b = (HeldEnd(np.array([0.0, s * span / 2, 0.0]), down, 0.0) for s in (-1, 1))
    nodes = hanging_loop(model, a, b)
    # The ferrules hang straight down at both ends; s = 2 c sinh(span / 2 c) for what is between.
    steps = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    between = steps[1:-1].sum()
    low, high = 1e-3, 10.0
    for _ in range(60):
        c = (low + high) / 2
        low, high = (c, high) if 2 * c * math.sinh(span / 2 / c) > between else (low, c)
    depth = c * (math.cosh(span / 2 / c) - 1) + steps[0]
    assert -nodes[:, 2].min() == pytest.approx(depth, rel=2e-3)


def test_what_a_holder_keeps_straight_stays_straight():
    nodes = hanging_loop(model_of(1.0), *side_by_side(straight=0.1))
    from_a = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(nodes, axis=0), axis=1))]
    held = nodes[from_a < 0.0999]
    assert len(held) > 3
    assert np.ptp(held[:, 1:], axis=0) == pytest.approx([0.0, 0.0], abs=1e-9)
    assert held[0, 0] - held[-1, 0] == pytest.approx(from_a[len(held) - 1])


def test_a_wire_that_is_too_short_is_refused_with_the_lengths():
    with pytest.raises(ValueError, match=r"0\.4\d* m of wire hang between holders 0\.800 m apart"):
        hanging_loop(model_of(0.5), *side_by_side(gap=0.8))
    with pytest.raises(ValueError, match=r"nothing of 0\.500 m of wire hangs"):
        hanging_loop(model_of(0.5), *side_by_side(straight=0.3))
