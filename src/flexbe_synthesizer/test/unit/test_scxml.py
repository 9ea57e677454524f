"""Charts as SCXML, executed by a library that knows nothing of us (python-statemachine)."""

import random

import pytest
from lxml import etree
from statemachine.io import load
from synthesizer_support.chart_run import run
from synthesizer_support.w3c_scxml import faults

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.export.scxml import NAMESPACE, ScxmlError, chart_to_scxml, scxml_name

CHARTS = ("plain.xml", "place_connector.xml", "wire_task.xml", "two_arms.xml")
RUNS, MOST_STEPS = 15, 60


@pytest.fixture(params=CHARTS)
def chart(request, golden):
    return parse_chart((golden / "charts" / request.param).read_bytes(), request.param)


def started(scxml):
    """Return a machine without its timers: the executor would wait for them in real time."""
    root = etree.fromstring(scxml.encode())
    for timed in root.xpath("//s:send | //s:cancel", namespaces={"s": NAMESPACE}):
        timed.getparent().remove(timed)
    return load(etree.tostring(root, encoding="unicode"), format="scxml")()


def configuration(machine):
    return {state.id for state in machine.configuration}


def test_a_chart_is_written_as_w3c_says(chart):
    assert faults(chart_to_scxml(chart)) == []


def test_names_of_our_own_are_taken_from_no_one():
    text = """<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="visits_C" initial="C">
      <datamodel><outcome name="done"/></datamodel>
      <ext:container id="C" initial="timer" ext:attempts="2" ext:timeout_s="1.5">
        <datamodel><outcome name="attempts"/><outcome name="region"/></datamodel>
        <state id="timer" type="T"><transition event="done" target="attempts"/></state>
        <transition event="attempts" target="C"/><transition event="region" target="done"/>
        <transition event="timed_out" target="done"/><transition event="exhausted" target="done"/>
      </ext:container></statemachine>"""
    assert faults(chart_to_scxml(parse_chart(text))) == []


@pytest.mark.parametrize(
    ("good", "bad"),
    [
        ('version="1.0" name', 'version="2" name'),
        ("<final id", "<finale id"),
        ('target="Fix"', 'target="Fiks"'),
        ('initial="', 'initial="x'),
        ('event="', 'event="a..'),
        (' id="Fix"', ' id="Locate"'),
        ("</scxml>", "<state id='1'/></scxml>"),
        ("</scxml>", "x</scxml>"),
        ("</scxml>", "<transition/></scxml>"),
    ],
)
def test_the_rules_of_w3c_find_what_breaks_them(golden, good, bad):
    path = golden / "charts" / "place_connector.xml"
    text = chart_to_scxml(parse_chart(path.read_bytes(), path.name))
    assert good in text
    assert faults(text.replace(good, bad, 1)) != []


@pytest.mark.parametrize("seed", range(RUNS))
def test_another_executor_comes_to_the_same_outcome(chart, seed, events_of_golden):
    pick = random.Random(seed)
    outcome, steps = run(
        chart, events_of_golden, lambda _path, events: pick.choice(events), MOST_STEPS
    )
    machine = started(chart_to_scxml(chart))
    for path, event in steps:
        if event != "exhausted":
            parts = [scxml_name(part) for part in (*path.strip("/").split("/"), event)]
            machine.send(".".join(parts), error_code=0)
    if outcome is None:
        assert not machine.is_terminated
    else:
        assert configuration(machine) == {scxml_name(outcome)}


ROUTED = """<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="A" initial="Look">
  <datamodel><outcome name="found"/><outcome name="blind"/><outcome name="failed"/></datamodel>
  <state id="Look" type="T" ext:on_error="{}">
    <transition event="seen" target="found"/><transition event="failed" target="failed"/>
  </state></statemachine>"""
CODES = {"BENT": (4,), "serious": (3, 4, 5, 9)}


@pytest.mark.parametrize(
    ("routes", "reached"),
    [
        (
            "100-199: blind; 305: Look",
            {99: "failed", 100: "blind", 199: "blind", 305: "Look", 0: "failed"},
        ),
        (
            "BENT: Look; serious: blind",
            {3: "blind", 4: "Look", 5: "blind", 6: "failed", 9: "blind"},
        ),
    ],
)
def test_the_first_route_that_has_the_error_code_is_taken(routes, reached):
    scxml = chart_to_scxml(parse_chart(ROUTED.format(routes)), CODES)
    for code, state in reached.items():
        machine = started(scxml)
        machine.send("Look.failed", error_code=code)
        assert configuration(machine) == {state}, code


def test_names_that_become_one_are_refused():
    text = (
        '<statemachine name="A" initial="x y"><datamodel><outcome name="o"/></datamodel>'
        '<state id="x y" type="T"/><state id="x_y" type="T"/></statemachine>'
    )
    with pytest.raises(ScxmlError, match="'x_y'"):
        chart_to_scxml(parse_chart(text))
