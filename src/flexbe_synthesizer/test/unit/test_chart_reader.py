import dataclasses

import pytest
from hypothesis import given
from synthesizer_support.strategies import WILD_NAMES, charts

from flexbe_synthesizer.core.chart.chart_reader import parse_chart, read_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart, Input, Outcome, Param, State, Transition
from flexbe_synthesizer.core.chart.problem import ChartError, ProblemKind
from flexbe_synthesizer.core.chart.xml_tree import XmlTree


@given(charts(WILD_NAMES, WILD_NAMES))
def test_a_chart_that_is_written_is_read_as_the_same_chart(chart):
    text = write_chart(chart)
    again = parse_chart(text)
    assert repr(dataclasses.replace(again, file="")) == repr(
        chart
    )  # distinguishes 1 from True and 1.0
    assert write_chart(again) == text


def test_a_faultless_chart_is_checked_without_looking_for_places(golden, check, monkeypatch):
    def look(*_arguments):
        pytest.fail("the slow reader was asked for a place")

    monkeypatch.setattr(XmlTree, "place", look)
    _checked, problems = check((golden / "charts" / "place_connector.xml").read_bytes())
    assert problems == ()


def test_a_written_chart_looks_as_one_would_write_it():
    chart = Chart(
        name="Wait Twice",
        initial="First",
        outcomes=(Outcome("done"),),
        nodes=(
            State("First", "WaitState", (Transition("done", "done"),), params=(Param("s", "5"),)),
        ),
        inputs=(Input("x", "int", 3),),
        description="Waits\nand ends.",
    )
    assert write_chart(chart) == (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="Wait Twice" '
        'initial="First">\n'
        "  <!-- Waits\n       and ends. -->\n"
        "  <datamodel>\n"
        '    <outcome name="done"/>\n'
        '    <input name="x" type="int" ext:default="3"/>\n'
        "  </datamodel>\n"
        '  <state id="First" type="WaitState">\n'
        '    <param name="s" value="&quot;5&quot;"/>\n'
        '    <transition event="done" target="done"/>\n'
        "  </state>\n"
        "</statemachine>\n"
    )


def test_outcomes_are_read_bare_and_wrapped_in_the_order_of_the_file():
    chart = parse_chart(
        '<statemachine name="A" initial="a"><datamodel><outcome name="x"/><outcomes>'
        '<outcome name="y"/></outcomes><outcome name="z"/></datamodel>'
        '<state id="a" type="T"/></statemachine>'
    )
    assert [outcome.name for outcome in chart.outcomes] == ["x", "y", "z"]


def test_the_description_is_the_comment_in_the_root_or_else_the_one_before_it():
    head, tail = (
        '<statemachine name="A" initial="a">',
        ('<datamodel><outcome name="x"/></datamodel><state id="a" type="T"/></statemachine>'),
    )
    both = parse_chart(f"<!-- licence --><!--before-->{head}<!-- in -->{tail}<!-- late -->")
    assert both.description == "in"
    assert parse_chart(f"<!-- licence --><!--before-->{head}{tail}").description == "before"
    inner = tail.replace("<state", "<!-- not this --><state")
    assert parse_chart(head + inner).description == ""


def test_a_double_hyphen_in_a_description_is_parted_since_no_comment_can_hold_it():
    chart = Chart("A", "a", (Outcome("x"),), (State("a", "T"),), description="a---b --")
    assert chart.description == "a- - -b - -"
    assert parse_chart(write_chart(chart)) == chart


def test_a_pointer_to_a_schema_is_no_mistake():
    parse_chart(
        '<statemachine xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
        'xsi:noNamespaceSchemaLocation="remodel_statechart.xsd" name="A" initial="a">'
        '<datamodel><outcome name="x"/></datamodel><state id="a" type="T"/></statemachine>'
    )


def test_a_text_without_the_form_of_a_chart_raises_all_its_problems():
    with pytest.raises(ChartError) as caught:
        parse_chart("<statemachine nam='A'/>", "c.xml")
    lines = str(caught.value).splitlines()
    assert len(lines) == 5
    assert all(line.startswith("c.xml:1:") for line in lines)


@pytest.mark.parametrize("element", ["<p:/>", "<:/>", '<p: p:="" x=""/>'])
def test_an_element_without_a_name_behind_its_prefix_is_unknown(element):
    _chart, problems = read_chart(
        f'<statemachine name="A" initial="a">\n{element}</statemachine>', "c"
    )
    found = [(p.code, p.position[1:]) for p in problems]
    assert (ProblemKind.UNKNOWN_ELEMENT, (2, 1)) in found
    root, problems = read_chart(element, "c")
    assert root is None
    assert ProblemKind.UNKNOWN_ELEMENT in {p.code for p in problems}


def test_an_attribute_with_a_prefix_is_reported_where_it_stands():
    _chart, problems = read_chart(
        '<statemachine xmlns:e="urn:remodel:statechart:ext:1" xmlns:f="urn:f" name="A"\n'
        ' initial="a"\n f:name="B"\n e:initial="b"/>',
        "c",
    )
    places = {p.code: p.position[1:] for p in problems}
    assert places[ProblemKind.UNKNOWN_ATTRIBUTE] == (3, 2)
    assert places[ProblemKind.UNKNOWN_EXTENSION] == (4, 2)


INPUT = '<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="A" initial="S"><datamodel>'
INPUT += (
    '<outcome name="x"/><input name="i" {}/></datamodel><state id="S" type="T"/></statemachine>'
)


@pytest.mark.parametrize(
    ("spelled", "value"),
    [
        ("5", "5"),
        ("true", "true"),
        ("1.50", "1.50"),
        ("[1]", "[1]"),
        ("'5'", "5"),
        ("&quot;5&quot;", "5"),
        ("null", None),
        ("'null'", "null"),
        ("W1", "W1"),
        ("", ""),
    ],
)
def test_the_default_of_a_string_is_its_text(spelled, value):
    (port,) = parse_chart(INPUT.format(f'type="string" ext:default="{spelled}"')).inputs
    assert port.default == value


def test_the_default_of_a_string_is_written_without_quotes_that_it_does_not_need():
    chart = parse_chart(INPUT.format('type="string" ext:default="\'5\'"'))
    assert 'type="string" ext:default="5"' in write_chart(chart)
    chart = parse_chart(INPUT.format("ext:default=\"'5'\""))
    assert 'name="i" ext:default="&quot;5&quot;"' in write_chart(chart)


def test_the_default_of_a_key_without_a_type_is_a_literal():
    (port,) = parse_chart(INPUT.format('ext:default="5"')).inputs
    assert port.default == 5
