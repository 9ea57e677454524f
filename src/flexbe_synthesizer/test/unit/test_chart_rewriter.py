"""Charts changed inside their text, whatever the change; the console's tests have each edit."""

import dataclasses
import re

import pytest
from hypothesis import given
from synthesizer_support.strategies import WILD_NAMES, charts

from flexbe_synthesizer.core.chart.chart_reader import parse_chart, read_chart
from flexbe_synthesizer.core.chart.chart_rewriter import RewriteError, rewrite_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart, Input, Outcome, State

MIXED = charts(WILD_NAMES.map(str.strip).filter(bool))
CHART = """<statemachine name="A" initial="S">
  <datamodel><outcome name="x"/></datamodel>
  <state id="S" type="T"/>
</statemachine>
"""


@given(MIXED, MIXED)
def test_any_chart_becomes_any_other_one_on_many_lines_and_on_one(before, after):
    text = write_chart(before)
    assert rewrite_chart(text, before) == text
    assert repr(parse_chart(rewrite_chart(text, after))) == repr(parse_chart(write_chart(after)))
    line = re.sub(r">\n *<(?!!--)", "><", text)
    if read_chart(line, "")[0] == before:  # a description may hold what looks like tags
        assert rewrite_chart(line, before) == line
        assert parse_chart(rewrite_chart(line, after)) == after


def test_a_state_without_content_is_opened_and_the_namespace_declared_where_it_is_needed():
    chart = parse_chart(CHART)
    (state,) = chart.nodes
    limited = State(
        "S", "T", parse_chart(TWO).nodes[0].transitions, attempts=2, source=state.source
    )
    text = rewrite_chart(CHART, Chart("A", "S", chart.outcomes, (limited,)))
    assert text == (
        '<statemachine name="A" initial="S" xmlns:ext="urn:remodel:statechart:ext:1">\n'
        '  <datamodel><outcome name="x"/></datamodel>\n'
        '  <state id="S" type="T" ext:attempts="2">\n'
        '    <transition event="done" target="x"/>\n'
        "  </state>\n"
        "</statemachine>\n"
    )


TWO = CHART.replace('"T"/>', '"T"><transition event="done" target="x"/></state>')


def test_an_outcome_joins_the_others_where_they_are_wrapped():
    wrapped = CHART.replace(
        '<outcome name="x"/>', '<outcomes>\n    <outcome name="x"/>\n  </outcomes>'
    )
    chart = parse_chart(wrapped)
    more = Chart("A", "S", (*chart.outcomes, Outcome("y")), chart.nodes)
    expected = wrapped.replace('"x"/>\n', '"x"/>\n    <outcome name="y"/>\n')
    assert rewrite_chart(wrapped, more) == expected


@pytest.mark.parametrize("text", ["", "<a", "<other/>", CHART.replace("<state ", '<state id="R" ')])
def test_a_text_that_cannot_be_edited_is_refused(text):
    with pytest.raises(RewriteError):
        rewrite_chart(text, Chart("A", "S", (Outcome("z"),), (State("S", "T"),)))


def test_deep_nesting_of_unknown_elements_is_no_hindrance():
    deep = CHART.replace("</statemachine>", f"{'<x>' * 5000}{'</x>' * 5000}</statemachine>")
    chart, _problems = read_chart(deep, "")
    changed = Chart("A", "S", (Outcome("z"),), chart.nodes)
    assert rewrite_chart(deep, changed) == deep.replace('outcome name="x"', 'outcome name="z"')


@pytest.mark.parametrize("spelled", ["5", "'5'", "&quot;5&quot;"])
@pytest.mark.parametrize("old", ['type="string" ', 'type="int" ', ""])
@pytest.mark.parametrize(
    "new", [Input("i", "string", "5"), Input("i", None, "5"), Input("i", "int", 5), Input("i")]
)
def test_a_default_keeps_its_value_when_its_type_changes(old, spelled, new):
    text = (
        '<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="A" initial="S">'
        f'<datamodel><outcome name="x"/><input name="i" {old}ext:default="{spelled}"/></datamodel>'
        '<state id="S" type="T"/></statemachine>'
    )
    wanted = dataclasses.replace(parse_chart(text), inputs=(new,))
    assert parse_chart(rewrite_chart(text, wanted)).inputs == (new,)
