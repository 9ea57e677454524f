"""Behaviors of random charts are loaded, checked and saved unchanged by the FlexBE App's rules."""

import re
from pathlib import Path

import pytest
from app_judge import judge
from random_charts.engine_run import Synthesis
from random_charts.generate import generate

from flexbe_testing.core.app_behavior import Known
from flexbe_testing.core.app_load import define_behavior
from flexbe_testing.edge.doctor import read_packages

SOURCES = Path(__file__).parents[3]
# What the App drops or cannot write, as the package's README says: blanks in outcomes of states,
# and containers whose ids are no Python names.
BLANKS = re.compile(r"'(no) (way)'|'(not) (turned)'")
UNNAMEABLE = "would name a variable"


@pytest.fixture(scope="module")
def states():
    scripted = Path(__file__).parents[1] / "random_charts" / "packages" / "scripted_states"
    folders = [scripted, SOURCES / "remodel_states", SOURCES / "flexbe" / "flexbe_states"]
    return read_packages(folders).states


@pytest.mark.parametrize("count", [5, pytest.param(500, marks=pytest.mark.slow)])
def test_the_app_saves_the_behaviors_of_random_charts_unchanged(
    states, tmp_path, fresh_seed, count
):
    saved, complaints = 0, []
    for seed in range(fresh_seed, fresh_seed + count):
        source = generate(seed)
        synthesis = Synthesis(source.files, source.path, tmp_path)
        if synthesis.errors:
            continue
        files = [path for path in synthesis.written if path.stem.endswith("_sm")]
        texts = {f"{path.parent.name}.{path.stem}": path.read_text() for path in files}
        inner = [define_behavior(text, module) for module, text in texts.items()]
        for module, text in texts.items():
            without_blanks = BLANKS.sub(lambda m: f"'{''.join(filter(None, m.groups()))}'", text)
            found = judge(without_blanks, Known(states, inner))
            saved += not found
            complaints += [(seed, module, c) for c in found if UNNAMEABLE not in c]
    assert complaints == []
    assert saved >= count / 5
