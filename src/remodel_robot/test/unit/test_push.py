"""How a push ends."""

import pytest

from remodel_robot.core.push import Push, PushRules
from remodel_states.core.codes import Code


def pushed(meets_at_m, force_limit=5.0):
    """Push against something at a depth [m]."""
    push = Push(PushRules(), force_limit)
    while not push.has_ended:
        push.advance(0.02, 8.0 if push.depth_m >= meets_at_m else 0.5)
    return push


@pytest.mark.parametrize(
    ("meets_at_m", "problem"),
    [
        (-0.001, Code.INSERTION_MISALIGNED),
        (0.006, Code.INSERTION_JAMMED),
        (0.014, Code.NONE),
        (1.0, Code.INSERTION_NO_CONTACT),
    ],
)
def test_the_depth_decides_what_the_force_means(meets_at_m, problem):
    push = pushed(meets_at_m)
    assert push.problem is problem
    assert push.depth_m == pytest.approx(min(meets_at_m, 0.02), abs=0.0003)


def test_nothing_moves_on_beyond_the_force_limit():
    push = pushed(0.006)
    depth = push.depth_m
    push.advance(0.02, 0.0)
    assert push.depth_m == depth


@pytest.mark.parametrize(
    ("rules", "message"),
    [
        ({"speed_m_s": 0.0}, "speed_m_s is 0; allowed: more than 0"),
        ({"seated_m": 0.03}, "seated_m is 0.03; allowed: up to deepest_m, 0.02"),
    ],
)
def test_rules_that_cannot_be_are_refused(rules, message):
    with pytest.raises(ValueError, match=message):
        PushRules(**rules)
