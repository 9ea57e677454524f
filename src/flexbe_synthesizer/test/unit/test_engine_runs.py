"""What charts are lowered to means what the charts mean: golden behaviors run on flexbe_core.

The states are scripted: each ends with the event that the seed gives to its path. The reference
interpreter runs the chart with the same events and must end with the same outcome.
"""

import random
from itertools import chain, combinations

import pytest
from synthesizer_support.chart_run import run
from synthesizer_support.rendering import rendered

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.problem import errors_in
from flexbe_synthesizer.core.compile import compile_chart
from flexbe_synthesizer.core.export.layout import instantiate, lay_out, with_presets_written

CHARTS = ("place_connector", "two_arms")
SEEDS = 40


def choice(seed, path, events):
    """Return the event that a state always ends with, whichever engine runs it."""
    return random.Random(f"{seed} {path}").choice(events)


@pytest.mark.parametrize("name", CHARTS)
@pytest.mark.parametrize("seed", range(SEEDS))
def test_the_engine_comes_to_the_outcome_of_the_chart(
    name, seed, golden, events_of_golden, on_engine
):
    chart = parse_chart((golden / "charts" / f"{name}.xml").read_bytes(), f"{name}.xml")
    expected, _steps = run(
        chart, events_of_golden, lambda path, events: choice(seed, f"/root{path}", events), 99
    )
    assert expected is not None
    text = (golden / "behaviors" / f"{name}_sm.py").read_text()
    assert on_engine([text], lambda path, events: choice(seed, f"/root{path}", events)) == expected


LIMITS = {
    "attempts": ('ext:attempts="2"', '<transition event="exhausted" target="failed"/>'),
    "timeout": ('ext:timeout_s="5"', '<transition event="timed_out" target="fixed"/>'),
    "on_error": ('ext:on_error="3-5: Fix"', ""),
}
SUBSETS = [
    *chain.from_iterable(combinations(LIMITS, count) for count in range(len(LIMITS) + 1)),
]
ENDS = """<outcome name="fixed"/><outcome name="failed"/><input name="cable_id"/>
  <input name="component_id"/><output name="error_code"/><output name="error_message"/>"""
STATE = """<state id="{id}" type="FixCableState" {limits}>
  <transition event="fixed" target="{next}"/>
  <transition event="failed" target="{other}"/>{ends}</state>"""
INNER = (
    '<ext:{kind} id="Start" initial="Inner" {limits}><datamodel>'
    + ENDS
    + """</datamodel>
  {inner}{fix}
  <transition event="fixed" target="Fix"/>
  <transition event="failed" target="failed"/>{ends}</ext:{kind}>"""
)
TASK = (
    '<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="Task" initial="Start">'
    "<datamodel>" + ENDS + '<input name="pose"/></datamodel>{fix}{start}</statemachine>'
)


def task(limits, kind):
    """Return a chart whose initial node has the limits, and what is entered first in it."""
    attributes = " ".join(LIMITS[limit][0] for limit in limits)
    ends = "".join(LIMITS[limit][1] for limit in limits)
    parts = {"limits": attributes, "ends": ends}
    fix = STATE.format(id="Fix", limits="", next="fixed", other="failed", ends="")
    if kind == "state":
        start = STATE.format(id="Start", next="Fix", other="failed", **parts)
        return TASK.format(fix=fix, start=start), "/Start"
    inner = STATE.format(id="Inner", next="Fix", other="failed", **parts)
    start = INNER.format(kind=kind, inner=inner, fix=fix, **parts)
    start = start.replace(
        '<input name="cable_id"/>', '<input name="cable_id"/><input name="pose"/>'
    )
    return TASK.format(fix=fix, start=start), "/Start/Inner"


@pytest.mark.parametrize(
    ("limits", "kind"),
    [
        pytest.param(limits, kind, id="+".join((*limits, kind)))
        for limits in SUBSETS
        for kind in ("state", "container", "priority")
        if kind != "priority" or "timeout" not in limits  # its timer would wait
    ],
)
def test_the_initial_state_is_entered_first_whatever_is_added_around_it(
    limits, kind, check, library, on_engine
):
    text, first = task(limits, kind)
    checked, problems = check(text)
    assert errors_in(problems) == ()
    root = compile_chart(checked, "p")
    entered = []
    assert (
        on_engine([rendered(root)], lambda path, events: choice(1, path, events), entered)
        is not None
    )
    visited = [path for path in entered if not path.endswith(("_attempts", "/timer"))]
    assert visited[0] == first

    writer = library.find_states("flexbe_states/UserDataState")[0]
    listed = with_presets_written(root.root, writer)
    returned = instantiate(listed, lay_out(listed))
    after = {state.state_path: state.transitions for state in returned}
    name = returned[0].initial_state_name
    while name.startswith("Set "):  # a count, which the list itself must set
        (name,) = after[f"/{name}"]
    assert name == ("Start_attempts" if "attempts" in limits else "Start")
