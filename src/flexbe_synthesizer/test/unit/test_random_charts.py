"""Random charts do on the engine what the documentation says, and never lack data.

A seed that fails here is shown by `python3 -m random_charts --seed SEED`, shrunk, and with
`--trace` in full; see "Tests" in the package's README.
"""

import sys
from collections import Counter
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from random_charts.generate import generate
from random_charts.judge import judge, judge_seed
from random_charts.kinds import KINDS
from random_charts.shrink import shrink

CHARTS, AT_ONCE, RUNS = 500, 50, 3
verdicts = {}


@pytest.mark.parametrize("first", range(0, CHARTS, AT_ONCE))
def test_engine_and_reference_agree(first):
    found = {seed: judge_seed(seed, RUNS) for seed in range(first, first + AT_ONCE)}
    verdicts.update(found)
    assert [(seed, v.kind, v.details) for seed, v in found.items() if v.is_wrong] == []
