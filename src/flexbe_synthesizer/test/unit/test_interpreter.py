"""What the reference interpreter reports of charts that go wrong, and how a run is followed."""

import pytest
from synthesizer_support.chart_run import run
from synthesizer_support.interpreter import Interface, explore

from flexbe_synthesizer.core.chart.chart_reader import parse_chart

HEAD = """<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="A" initial="S">
  <datamodel><outcome name="o"/></datamodel>"""
BOTH = """<ext:concurrency id="S"><datamodel><outcome name="o"/></datamodel>
  <state id="L" type="Two"/><state id="R" type="Two"/>
  <ext:condition outcome="o"><ext:when state="L" event="a"/><ext:when state="R" event="a"/>
  </ext:condition>{}<transition event="o" target="o"/></ext:concurrency>"""


def interface(node):
    kinds = {
        "Two": (("a", "b"), (), ()),
        "Read": (("a",), ("v",), ()),
        "Write": (("a",), (), ("v",)),
    }
    return Interface(*kinds[node.type])


def state(node_id, kind, *targets, more=""):
    exits = "".join(f'<transition event="{e}" target="{t}"/>' for e, t in targets)
    return f'<state id="{node_id}" type="{kind}"{more}>{exits}</state>'


def flow(source, target):
    return (
        f'<connection output_state_id="{source}" output="v" input_state_id="{target}" input="v"/>'
    )


@pytest.mark.parametrize(
    ("body", "fault"),
    [
        (state("S", "Two", ("a", "o"), ("b", "o")), None),
        (state("S", "Two", ("a", "o")), "'b' leads to 0 places"),
        (state("S", "Two", ("a", "o"), ("b", "x")), "does not exist"),
        (state("S", "Two", ("a", "o"), ("b", "T")) + state("T", "Write", ("a", "T")), "no outcome"),
        (state("S", "Read", ("a", "o")), "nothing feeds 'v'"),
        (
            state("S", "Two", ("a", "T"), ("b", "W"))
            + state("W", "Write", ("a", "T"))
            + state("T", "Read", ("a", "o"))
            + flow("W", "T"),
            "read before it is written",
        ),
        (
            state("S", "Write", ("a", "S"), ("exhausted", "S"), more=' ext:attempts="2"'),
            "leads to no outcome",
        ),
        (BOTH.format(""), "waits forever after L b, R b"),
        (
            BOTH.format(
                '<ext:condition outcome="o"><ext:when state="L" event="b"/></ext:condition>'
            ),
            "waits forever after L a, R b",
        ),
    ],
)
def test_faults_are_found(body, fault):
    faults = [f.what for f in explore(parse_chart(f"{HEAD}{body}</statemachine>"), interface)]
    if fault is None:
        assert faults == []
    else:
        assert any(fault in what for what in faults), faults


def test_a_run_ends_at_its_outcome_or_when_its_steps_run_out():
    body = state("S", "Two", ("a", "o"), ("b", "S"))
    chart = parse_chart(f"{HEAD}{body}</statemachine>")
    assert run(chart, interface, lambda _path, _events: "a", 9) == ("o", (("/S", "a"),))
    outcome, steps = run(chart, interface, lambda _path, _events: "b", 9)
    assert (outcome, len(steps)) == (None, 9)
