import itertools
import math

import numpy as np
import place_wire as do
import pytest

from remodel_sim.core.faults import Disturbances, FaultError, check_fault
from remodel_skills.abilities.picking import PickGoal
from remodel_work.errors import AbilityError
from remodel_work.panel import WireEnd


@pytest.mark.parametrize(
    ("kind", "target", "values", "words"),
    [
        ("earthquake", "", [], "no fault 'earthquake'; there are: component_moved"),
        ("light_changed", "X1", [0.5], "target is 'X1'; light_changed has none"),
        ("tip_bent", "", [0.1], "target is empty; tip_bent needs: a or b"),
        ("tip_bent", "c", [0.1], "target is 'c'; allowed: a or b"),
        ("socket_blocked", "X1", [], "must be 'component/terminal'"),
        ("component_moved", "X1", [0.0], r"needs: dx \[m\], dy \[m\], dyaw \[rad\]"),
        ("grip_weakened", "", [math.nan], "share of the grip force is nan"),
        ("server_frozen", "", [0.0], r"time is 0.0 s; allowed: 0.1 to 600"),
        ("server_killed", "cell", [], "server_killed has none"),
        ("camera_bumped", "wrist", [1.0, 0.0, 0.0, 0.0], "dx is 1.0 m; allowed: -0.05 to 0.05"),
    ],
)
def test_a_fault_that_makes_no_sense_is_refused(kind, target, values, words):
    with pytest.raises(FaultError, match=words):
        check_fault(kind, target, values)


def test_a_fault_on_what_is_not_there_is_refused(cell):
    with pytest.raises(AbilityError, match="no channel 'Z'"):
        cell.plant.disturb("cable_in_the_way", "Z", [0.0, 0.0])
    with pytest.raises(FaultError, match="cell/inject_fault causes it"):
        cell.plant.disturb("server_killed", "", [])
    with pytest.raises(FaultError, match=r"no camera 'wrist_2'; there are: overhead, wrist$"):
        cell.plant.disturb("camera_bumped", "wrist_2", [0.01, 0.0, 0.0, 0.0])
    with pytest.raises(FaultError, match="no wire is live"):
        cell.plant.disturb("tip_bent", "a", [0.1])


def pull(cell, force):
    """Pull the held end with a force; return how far it slides in the grip [m]."""
    cable, bullet = cell.plant.live.cable, cell.plant.world.bullet
    start = cable.tip(WireEnd.A)[0]
    for _ in range(60):
        apex, out = cable.tip(WireEnd.A)
        bullet.applyExternalForce(
            *cable.ferrule(WireEnd.A), (force * out).tolist(), apex.tolist(), bullet.WORLD_FRAME
        )
        cell.plant.step()
    return float(np.linalg.norm(cable.tip(WireEnd.A)[0] - start))


@pytest.mark.slow
@pytest.mark.physics
@pytest.mark.parametrize("kind", ["grip_weakened", "friction_lowered"])
def test_a_weak_hand_lets_the_wire_slide(cell, kind):
    goal = PickGoal(do.ROBOT, "W1", WireEnd.A, 0.0)
    cell.feed("W1", "A")
    do.do(cell, do.pick_cable, goal)
    assert pull(cell, 15.0) < 0.002
    cell.load(cell.plant.loaded)
    cell.plant.disturb(kind, "", [0.3])
    cell.feed("W1", "A")
    do.do(cell, do.pick_cable, goal)
    assert pull(cell, 15.0) > 0.005


def test_a_bumped_camera_shows_the_plate_from_elsewhere_than_it_says(cell):
    before = cell.plant.take_overhead_picture()
    cell.plant.disturb("camera_bumped", "overhead", [0.010, 0.0, 0.0, 0.0])
    after = cell.plant.take_overhead_picture()
    assert np.array_equal(
        after.view.world_from_camera.position, before.view.world_from_camera.position
    )
    assert np.abs(after.rgb.astype(int) - before.rgb).mean() > 2.0


def test_less_light_darkens_the_pictures_until_the_panel_is_rebuilt(cell):
    usual = cell.context.cameras.take_wrist_picture().rgb.mean()
    cell.plant.disturb("light_changed", "", [0.5])
    assert cell.context.cameras.take_wrist_picture().rgb.mean() == pytest.approx(usual / 2, rel=0.1)
    cell.load(cell.plant.loaded)
    assert cell.context.cameras.take_wrist_picture().rgb.mean() == pytest.approx(usual, rel=0.1)


def test_the_readings_of_a_wrist_scatter_as_they_are_told_to(cell):
    (robot,) = cell.plant.robots.values()

    def scatter():
        return np.std([robot.read_wrist() for _ in range(400)], axis=0)

    assert (scatter() == 0.0).all()
    cell.plant.differ(Disturbances(force_noise=0.5), {}, lambda wire: wire)
    assert scatter() == pytest.approx(0.5, rel=0.2)


@pytest.mark.physics
def test_a_bent_tip_points_aside(cell):
    cell.feed("W1", "A")

    def aside():
        nodes = cell.plant.live.cable.nodes()
        first, then = nodes[0] - nodes[1], nodes[1] - nodes[2]
        cosine = first @ then / np.linalg.norm(first) / np.linalg.norm(then)
        return math.acos(min(1.0, cosine))

    straight = aside()
    cell.plant.disturb("tip_bent", "a", [0.4])
    for _ in range(8):
        cell.come_to_rest()
    assert straight < 0.05
    assert aside() == pytest.approx(0.4, abs=0.1)


@pytest.mark.physics
def test_a_cable_in_the_way_falls_onto_the_live_wire(cell):
    cell.feed("W1", "A")
    live = set(cell.plant.live.cable.bodies)
    bullet = cell.plant.world.bullet
    before = {bullet.getBodyUniqueId(i) for i in range(bullet.getNumBodies())}
    cell.plant.disturb("cable_in_the_way", "A", [0.05, 0.3])
    stray = {bullet.getBodyUniqueId(i) for i in range(bullet.getNumBodies())} - before
    for _ in range(8):
        cell.come_to_rest()
    touching = {frozenset(point[1:3]) for point in bullet.getContactPoints()}
    assert any(frozenset(pair) in touching for pair in itertools.product(live, stray))
    cell.feed("W2", "A")
    assert bullet.getNumBodies() > len(before), "it is still there for the next wire"
