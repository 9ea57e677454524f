"""What a synthesis server returns becomes the chart that it was made from."""

from dataclasses import replace
from pathlib import Path

import pytest

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.edge.package_path import find_packages, read_library
from flexbe_synthesizer.synthesis import Request, Settings, fulfil
from remodel_console.core.server_states import chart_from_states
from remodel_console.errors import CommandError

SRC = Path(__file__).parents[3]
PATH = ":".join(
    str(SRC / one) for one in ("remodel_msgs", "remodel_states", "flexbe/flexbe_states")
)
CHARTS = sorted((SRC / "remodel_behaviors" / "charts").glob("*.xml"))


@pytest.fixture(scope="module")
def library():
    return read_library(find_packages(f"{PATH}:{SRC / 'remodel_behaviors'}")[0])[0]


def served(chart, tmp_path):
    folder = tmp_path / "package"
    settings = Settings((chart.parent,), folder, f"{PATH}:{SRC / 'remodel_behaviors'}")
    return fulfil(Request(chart.name), settings, lambda *_: None).states


@pytest.mark.parametrize("chart", CHARTS, ids=lambda chart: chart.stem)
def test_a_server_s_states_say_what_the_chart_says(chart, tmp_path, library):
    states = served(chart, tmp_path)
    source = parse_chart(chart.read_bytes())
    found = chart_from_states(states, source.name, library)
    assert isinstance(found, Chart)
    assert [node.id for node in found.nodes] == [node.id for node in source.nodes]
    assert parse_chart(write_chart(found).encode()) == found
    assert {o.name for o in found.outcomes} == {o.name for o in source.outcomes}
    for ours, theirs in zip(found.nodes, source.nodes, strict=True):
        assert {(t.event, t.target) for t in ours.transitions} == {
            (t.event, t.target) for t in theirs.transitions
        }
        assert ours.attempts == theirs.attempts


def test_what_cannot_be_used_is_reported(tmp_path, library):
    states = served(CHARTS[0], tmp_path)
    with pytest.raises(CommandError, match="no container '/'"):
        chart_from_states(states[1:], "X", library)
    strange = (states[0], replace(states[1], state_class="NoSuchState"))
    with pytest.raises(CommandError, match="'NoSuchState', which is not installed"):
        chart_from_states(strange, "X", library)
    with pytest.raises(CommandError, match="which is no container"):
        chart_from_states((replace(states[0], state_class="X"), *states[1:]), "X", library)
    evil = (states[0], replace(states[1], parameter_names=("a",), parameter_values=("f()",)))
    with pytest.raises(CommandError, match="cannot be used"):
        chart_from_states(evil, "X", library)
