import pytest
from holds import clamp_pull_out, clip_forces, grip_pull_out, spring_forces

pytestmark = pytest.mark.physics


@pytest.mark.parametrize(("force", "friction"), [(10.0, 0.5), (30.0, 0.5)])
def test_the_grip_lets_go_where_coulomb_says(force, friction):
    held, expected = grip_pull_out(force, friction)
    assert held == pytest.approx(expected, rel=0.15)


@pytest.mark.parametrize("retention", [10.0, 80.0])
def test_a_clamp_lets_go_at_its_retention_force(retention):
    assert clamp_pull_out(retention) == pytest.approx(retention, rel=0.10)


@pytest.mark.parametrize(("insertion", "retention"), [(5.0, 20.0), (12.0, 50.0)])
def test_a_spring_clamp_lets_a_ferrule_in_and_then_holds_it(insertion, retention):
    inward, outward = spring_forces(insertion, retention)
    assert inward == pytest.approx(insertion, rel=0.15)
    assert outward == pytest.approx(retention, rel=0.10)


@pytest.mark.parametrize(("retention", "diameter"), [(5.0, 0.003), (20.0, 0.006)])
def test_a_clip_snaps_shut_on_a_wire_and_lets_go_at_its_retention_force(retention, diameter):
    inward, outward = clip_forces(retention, diameter)
    assert outward == pytest.approx(retention, rel=0.10)
    assert inward == pytest.approx(retention, rel=0.20)
