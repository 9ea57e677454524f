import math

import numpy as np
import pytest
from elastica import cantilever_drop
from panels import wire

from remodel_sim.core.cable import MAX_LINKS, discretise
from remodel_sim.physics.cable import Cable
from remodel_sim.physics.world import GRAVITY, World


def test_the_links_add_up_to_the_wire():
    for length in (0.34, 0.5, 0.75):
        ordered = wire("W", ("X", "1"), ("Y", "1"), length)
        model = discretise(ordered, 1 / 240)
        assert len(model.lengths) <= MAX_LINKS
        assert math.isclose(model.lengths.sum() + 2 * model.radius, length)
        assert math.isclose(model.masses.sum(), length * ordered.linear_density)


def test_torques_pull_back_to_the_rest_shape():
    model = discretise(wire("W", ("X", "1"), ("Y", "1"), 0.4), 1 / 240)
    bend = np.zeros_like(model.stiffness)
    bend[5, 0] = 0.1
    assert model.torques(bend, np.zeros_like(bend))[5, 0] == pytest.approx(
        -0.1 * model.stiffness[5, 0]
    )


@pytest.mark.parametrize("load", [1.0, 5.0])
def test_a_clamped_wire_hangs_like_the_heavy_elastica(load):
    # The ferrule is rigid and clamped; the rest is a cantilever up to the middle of its last link,
    # all but.
    density = 0.020
    ordered = wire("W", ("X", "1"), ("Y", "1"), 0.40, linear_density=density, ferrule_length=0.010)
    free = ordered.length - ordered.ferrule_length
    stiffness = density * GRAVITY * free**3 / load
    ordered = wire(
        "W",
        ("X", "1"),
        ("Y", "1"),
        0.40,
        linear_density=density,
        ferrule_length=0.010,
        bending_stiffness=stiffness,
    )
    world = World(240)
    model = discretise(ordered, world.time_step)
    cable = Cable(world, model, "BU")
    cable.lay(np.array([0.0, 0.0, 1.0]), 0.0, np.zeros(len(model.lengths) - 1))
    position, quaternion = world.bullet.getBasePositionAndOrientation(cable.body)
    hold = world.bullet.createConstraint(
        cable.body, -1, -1, -1, world.bullet.JOINT_FIXED, [0, 0, 0], [0, 0, 0], position,
        [0, 0, 0, 1], quaternion,
    )  # fmt: skip
    world.bullet.changeConstraint(hold, maxForce=1e4)
    for _ in range(240 * 12):
        world.step()
    drop = 1.0 - cable.nodes()[-1, 2]
    expected = cantilever_drop(free, stiffness, density * GRAVITY)
    assert drop == pytest.approx(expected, rel=0.02)
    world.close()
