import re
import shutil

import pytest

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.model import (
    Behavior,
    Chart,
    ErrorRoute,
    Outcome,
    State,
    Transition,
)
from flexbe_synthesizer.core.export.draw import chart_to_dot
from flexbe_synthesizer.edge.files import render_dot
from flexbe_synthesizer.errors import DrawingError


@pytest.fixture
def chart(golden):
    return parse_chart((golden / "charts" / "place_connector.xml").read_bytes())


def edges(dot):
    return re.findall(r'"n ([^"]*)" -> "n ([^"]*)" \[(.*)\]', dot)


def edge(dot, source, target):
    (attributes,) = [a for s, t, a in edges(dot) if (s, t) == (source, target)]
    return attributes


def test_every_state_outcome_and_transition_is_drawn(chart):
    dot = chart_to_dot(chart)
    for node in chart.nodes:
        assert f"<b>{node.id}</b>" in dot
        for transition in node.transitions:
            assert transition.event in edge(dot, node.id, transition.target)
    assert '"start" -> "n Locate"' in dot
    assert dot.count("{ rank=sink;") == 1


def test_limits_are_notes_on_the_state_and_no_states_of_their_own(chart):
    dot = chart_to_dot(chart)
    assert "at most 3 attempts · timeout 5 s" in dot
    assert "Locate_attempts" not in dot
    assert "timer" not in dot


def test_failures_are_dashed_and_share_an_arrow(chart):
    dot = chart_to_dot(chart)
    assert "style=dashed" in edge(dot, "Insert", "Extract")
    assert "style=solid" in edge(dot, "Insert", "Fix")
    assert "failed<br/>timed_out" in edge(dot, "Fix", "Extract")


def test_only_routes_are_drawn_as_error_codes():
    routes = (ErrorRoute("JAMMED", "failed"), ErrorRoute("serious", "failed"))
    transitions = (Transition("failed_grasp", "failed"),)
    state = State("A", "T", transitions, on_error=routes)
    drawn = chart_to_dot(Chart("C", "A", (Outcome("failed"),), (state,)))
    assert "failed_grasp<br/>failed JAMMED, serious" in drawn


def test_routes_of_error_codes_share_lines_of_their_arrow():
    routes = tuple(ErrorRoute(f"{code}-{code + 1}", "failed") for code in range(100, 150, 10))
    state = State("A", "T", (Transition("lost", "failed"),), on_error=routes)
    dot = chart_to_dot(Chart("c", "A", (Outcome("failed"),), (state,)))
    label = "lost<br/>failed 100-101, 110-111, 120-121, 130-131<br/>140-141"
    assert label in edge(dot, "A", "failed")


def test_a_target_that_there_is_not_is_drawn_as_missing():
    state = State("A", "T", (Transition("done", "B"), Transition("again", "B")))
    dot = chart_to_dot(Chart("c", "A", (Outcome("finished"),), (state,)))
    assert dot.count("B?<br/>") == 1
    assert "dashed" in re.search(r'"n B" \[(.*)\]', dot)[1]
    assert '"start" ->' not in chart_to_dot(Chart("c", "", (), ()))


def test_the_path_taken_is_numbered_and_the_rest_fades(chart):
    path = [("Locate", "located"), ("Insert", "failed"), ("Extract", "extracted")]
    path += [("Locate", "located"), ("Insert", "inserted"), ("Fix", "fixed")]
    dot = chart_to_dot(chart, path)
    assert "<b>1, 4</b>" in edge(dot, "Locate", "Insert")
    assert "<b>6</b>" in edge(dot, "Fix", "finished")
    assert "penwidth=2.6" in edge(dot, "Insert", "Extract")
    assert "#b0bec5" in edge(dot, "Extract", "failed")
    assert '"n failed" [shape=box' in dot
    assert re.search(r'"n failed" .*fillcolor="white"', dot)
    assert re.search(r'"n finished" .*penwidth=2.6', dot)


def test_names_cannot_break_the_drawing(tmp_path):
    hostile = Chart(
        'a"b',
        'x"y<z>&',
        (Outcome('o"<b>'),),
        (
            State('x"y<z>&', "T<&\\", (Transition('e<b>&"', 'o"<b>'),)),
            Behavior("start", "B", (Transition("done", "start"),)),
        ),
    )
    render_dot(chart_to_dot(hostile, [('x"y<z>&', 'e<b>&"')]), tmp_path / "a.svg")
    assert "e&lt;b&gt;&amp;" in (tmp_path / "a.svg").read_text()


def test_the_suffix_says_the_format(chart, tmp_path):
    render_dot(chart_to_dot(chart), tmp_path / "new" / "a.svg")
    assert (tmp_path / "new" / "a.svg").read_text().rstrip().endswith("</svg>")
    render_dot(chart_to_dot(chart), tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_what_cannot_be_drawn_says_why(tmp_path, monkeypatch):
    with pytest.raises(DrawingError, match=r"unknown suffix .\.jpg."):
        render_dot("digraph {}", tmp_path / "a.jpg")
    with pytest.raises(DrawingError, match="syntax error"):
        render_dot("digraph {", tmp_path / "a.svg")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "file").write_text("")
    with pytest.raises(DrawingError, match="could not be drawn"):
        render_dot("digraph {}", tmp_path / "file" / "a.svg")
    assert shutil.which("dot")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(DrawingError, match="apt-get install graphviz"):
        render_dot("digraph {}", tmp_path / "a.svg")
