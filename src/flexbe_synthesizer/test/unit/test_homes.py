"""Values that share a home, and timers that would wait.

Random charts found each of these accepted, and doing something else than it says.
"""

import pytest
from random_charts.engine_run import Synthesis

from flexbe_synthesizer.core.chart.problem import ProblemKind

HEAD = '<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="A" initial="S"><datamodel>'
FLOW = '<connection output_state_id="{}" output="{}" input_state_id="{}" input="{}"/>'


def node(kind, node_id, class_name, more="", inside="", **targets):
    leading = "".join(f'<transition event="{e}" target="{t}"/>' for e, t in targets.items())
    given = f' type="{class_name}"' if class_name else ""
    return f'<{kind} id="{node_id}"{given}{more}>{inside}{leading}</{kind}>'


def state(node_id, class_name, more="", **targets):
    return node("state", node_id, class_name, more, **targets)


def chart(parts, *flows, data=""):
    connections = "".join(FLOW.format(*flow) for flow in flows)
    return f'{HEAD}<outcome name="o"/>{data}</datamodel>{parts}{connections}</statemachine>'


MAKE = state("S", "MakeState", made="T", failed="S")
MAKE_AGAIN = state("T", "MakeState", made="R", failed="T")


def shared_by_routes(output):
    ability = state("S", "AbilityState", ' ext:on_error="3: o; 5: S"', done="o", failed="o")
    return chart(
        ability,
        ("S", "error_code", "A", "v"),
        ("S", "error_message", "A", output),
        data='<input name="target"/><output name="v"/><output name="w"/>',
    )


def shared_by_a_reader(output):
    first = state("S", "SpreadState", done="T", failed="T")
    keys = "<param name=\"output_keys\" value=\"['a', 'b']\"/></state>"
    return chart(
        first.replace("</state>", keys) + state("T", "UseState", used="o", refused="o"),
        ("S", "a", "T", "item"),
        ("S", "a", "A", "v"),
        ("S", "b", "A", output),
        data='<output name="v"/><output name="w"/>',
    )


def written_by_its_reader(output):
    return chart(
        MAKE + state("T", "TurnState", **{"turned": "T", "not turned": "o"}),
        ("S", "item", "T", "item"),
        ("S", "item", "A", "v"),
        ("T", "result", "A", output),
        data='<output name="v"/><output name="w"/>',
    )


def written_inside(output):
    data = '<datamodel><outcome name="o"/><input name="x"/><output name="y"/></datamodel>'
    flows = FLOW.format("T", "x", "Use", "item") + FLOW.format("Make", "item", "T", "y")
    inside = data + state("Make", "MakeState", made="Use", failed="Make")
    inside += state("Use", "UseState", used="o", refused="o") + flows
    return chart(
        MAKE + node("ext:container", "T", "", ' initial="Make"', inside=inside, o="o"),
        ("S", "item", "T", "x"),
        ("S", "item", "A", "v"),
        ("T", "y", "A", output),
        data='<output name="v"/><output name="w"/>',
    )


def written_at_the_same_time(output):
    inside = f'<datamodel><outcome name="o"/><input name="v"/><output name="{output}"/></datamodel>'
    inside += '<state id="Make" type="MakeState"/><state id="Use" type="UseState"/>'
    inside += FLOW.format("S", "v", "Use", "item") + FLOW.format("Make", "item", "S", output)
    for name, event in (("Make", "made"), ("Make", "failed"), ("Use", "used"), ("Use", "refused")):
        inside += f'<ext:condition outcome="o"><ext:when state="{name}" event="{event}"/>'
        inside += "</ext:condition>"
    return chart(
        node("ext:concurrency", "S", "", "", inside=inside, o="o"), data='<input name="v"/>'
    )


def written_by_another(output):
    return chart(
        MAKE + MAKE_AGAIN + state("R", "UseState", used="o", refused="o"),
        ("S", "item", "R", "item"),
        ("S", "item", "A", "v"),
        ("T", "item", "A", output),
        data='<input name="v"/><output name="v"/><output name="w"/>',
    )


def changed_by_another(giver):
    """`giver` is v if the last to read is to have what S made of the input, w for any."""
    first = state("S", "TallyState", "", enough="T")
    second = state("T", "TallyState", "", enough="R")
    first = first.replace("</state>", '<transition event="more" target="T"/></state>')
    second = second.replace("</state>", '<transition event="more" target="R"/></state>')
    source = ("S", "count") if giver == "v" else ("T", "count")
    return chart(
        first + second + state("R", "UseState", used="o", refused="o"),
        ("A", "v", "S", "count"),
        ("S", "count", "T", "count"),
        (*source, "R", "item"),
        data='<input name="v"/>',
    )


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (shared_by_routes, "ext:on_error of state 'S' reads 'error_code'"),
        (shared_by_a_reader, "from 'a' of 'S', whose output 'b' is the same value, 'v'"),
        (written_by_its_reader, "from 'S', but 'T' writes the same value, 'v'"),
        (written_inside, "may be overwritten while it is still read"),
        (written_at_the_same_time, "which 'Make' writes at the same time"),
        (written_by_another, "from 'S', but 'T' writes the same value, 'v'"),
        (changed_by_another, "from 'S', but 'T' writes the same value, 'v'"),
    ],
)
def test_a_value_that_can_be_taken_for_another(made, said, tmp_path):
    errors = Synthesis({"a.xml": made("v").encode()}, "a.xml", tmp_path).errors
    (error,) = [e for e in errors if e.code is not ProblemKind.UNFED_OUTPUT]
    assert error.code is ProblemKind.OVERWRITTEN_VALUE
    assert said in error.message
    assert Synthesis({"a.xml": made("w").encode()}, "a.xml", tmp_path).errors == ()


def test_a_timer_that_would_wait_for_what_it_is_to_end(tmp_path):
    inside = '<datamodel><outcome name="o"/></datamodel>' + state(
        "M", "MakeState", made="o", failed="o"
    )
    more = ' initial="M" ext:timeout_s="2"'
    text = chart(node("ext:priority", "S", "", more, inside=inside, o="o", timed_out="o"))
    (error,) = Synthesis({"a.xml": text.encode()}, "a.xml", tmp_path).errors
    assert "its timer is beside it" in error.message
    text = text.replace("ext:priority", "ext:container")
    assert Synthesis({"a.xml": text.encode()}, "a.xml", tmp_path).errors == ()
