"""Whatever is killed, stalled, lost or commanded when: nothing is done twice, and nothing left out.

A schedule that fails here is shown by `make schedules BENCH="--seed SEED --count 1 --trace"`.
"""

import sys
from pathlib import Path
from random import SystemRandom

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from schedules.schedule import Schedules

FIXED, FRESH, AT_ONCE = 2000, 500, 100


@pytest.fixture(scope="module")
def schedules():
    return Schedules()


def failures(schedules, first, count):
    verdicts = [schedules.run(seed) for seed in range(first, first + count)]
    return [f"seed {each.seed}: {each.violation}" for each in verdicts if each.violation]


@pytest.mark.parametrize("first", range(0, FIXED, AT_ONCE))
def test_fixed_seeds(schedules, first):
    assert not failures(schedules, first, AT_ONCE)


def test_fresh_seeds(schedules):
    first = SystemRandom().randrange(10**6, 10**9)
    assert not failures(schedules, first, FRESH), f"fresh seeds from {first} on"


def test_a_seed_gives_the_same_schedule_again(schedules):
    first, again = (schedules.run(8, tracing=True) for _ in range(2))
    assert first.trace
    assert first == again
