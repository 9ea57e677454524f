"""A run is followed through its chart by the records of its abilities alone."""

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.replay import trace

INNER = parse_chart(
    """<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="Inner" initial="Look">
      <datamodel><outcome name="finished"/><outcome name="failed"/></datamodel>
      <state id="Look" type="LookState" ext:attempts="2">
        <transition event="seen" target="Push"/>
        <transition event="exhausted" target="failed"/>
      </state>
      <state id="Push" type="PushState">
        <transition event="pushed" target="finished"/>
        <transition event="failed" target="Look"/>
      </state>
    </statemachine>""",
    "inner.xml",
)
OUTER = parse_chart(
    """<statemachine name="Outer" initial="First">
      <datamodel><outcome name="finished"/><outcome name="failed"/></datamodel>
      <behavior id="First" type="Inner">
        <transition event="finished" target="Last"/>
        <transition event="failed" target="failed"/>
      </behavior>
      <state id="Last" type="LastState"><transition event="done" target="finished"/></state>
    </statemachine>""",
    "outer.xml",
)


def follow(*records):
    operations = tuple(Operation(path, "", outcome, 0, "", 0.0, 0.0) for path, outcome in records)
    return trace(OUTER, operations, {"Inner": INNER}, {})


def test_a_clean_run_reaches_its_outcome():
    run = follow(("/First/Look", "seen"), ("/First/Push", "pushed"), ("/Last", "done"))
    assert run.steps == (("First", "finished"), ("Last", "done"))
    assert run.outcome == "finished"
    assert run.children[0].path == "/First"
    assert run.children[0].steps == (("Look", "seen"), ("Push", "pushed"))


def test_a_bound_on_attempts_needs_no_record():
    once = (("/First/Look", "seen"), ("/First/Push", "failed"))
    run = follow(*once, *once)
    assert run.children[0].steps[-1] == ("Look", "exhausted")
    assert run.outcome == "failed"


def test_a_run_that_was_stopped_has_no_outcome():
    run = follow(("/First/Look", "seen"), ("/First/Push", ""))
    assert run.steps == ()
    assert run.outcome is None
    assert run.children[0].steps == (("Look", "seen"),)


def test_records_of_another_behavior_are_not_followed():
    assert follow(("/Elsewhere", "done")).outcome is None


def test_a_failure_goes_where_its_code_leads():
    chart = parse_chart(
        """<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="Route" initial="Look">
          <datamodel><outcome name="finished"/><outcome name="failed"/></datamodel>
          <state id="Look" type="LookState" ext:on_error="LOST: Look; serious: failed">
            <transition event="seen" target="finished"/>
            <transition event="failed" target="Look"/>
          </state>
        </statemachine>""",
        "route.xml",
    )
    records = [Operation("/Look", "", "failed", code, "", 0.0, 0.0) for code in (100, 4, 8)]
    run = trace(chart, tuple(records), {}, {"LOST": (4,), "serious": (4, 7, 8)})
    assert run.steps == (("Look", "failed"), ("Look", "failed_LOST"), ("Look", "failed_serious"))
    assert run.outcome == "failed"
