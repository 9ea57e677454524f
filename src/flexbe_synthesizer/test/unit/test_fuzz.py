"""Whatever arrives: a closed behavior, or errors with lines; never a traceback or a hang."""

import ast
import cProfile
import math
import pstats
import re
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st
from synthesizer_support.rendering import rendered
from synthesizer_support.strategies import charts
from synthesizer_support.w3c_scxml import faults

from flexbe_synthesizer.core.chart.chart_reader import read_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart as ChartModel
from flexbe_synthesizer.core.chart.model import Connection, Input, Outcome, Param, State, Transition
from flexbe_synthesizer.core.chart.problem import errors_in
from flexbe_synthesizer.core.compile import Unit, check_units, compile_chart
from flexbe_synthesizer.core.export.scxml import ScxmlError, chart_to_scxml

LONGEST_S = 5.0
TAGS = ["statemachine", "datamodel", "outcomes", "outcome", "input", "output", "state", "behavior"]
TAGS += ["param", "transition", "connection", "ext:container", "ext:concurrency", "ext:priority"]
TAGS += ["ext:condition", "ext:when", "x"]
ATTRIBUTES = ["name", "initial", "id", "type", "event", "target", "value", "topic", "state"]
ATTRIBUTES += ["ext:attempts", "ext:timeout_s", "ext:on_error", "ext:default", "outcome", "input"]
VALUES = ["A", "done", "failed", "3", "UserDataState", "ChooseState", "1-2: A", "", "preempted"]
NASTY = ["", " ", "a/b", "'", "preempted", "Locate", "failed", "Fix"]
NASTY += ["0", "-1", "[", "é", "x def y"]
CODE = [
    "__import__('os').system('touch /tmp/pwned')",
    "'''\nimport os\n'''",
    "'); raise SystemExit('",
    "lambda: 1",
    "{{ 7 * 7 }}",
    "{% for x in y %}",
    "# [/MANUAL_INIT]",
    "\\x27 + 1",
    "a\nclass B(Behavior): pass",
    "a def create(self): b",
    "It's '''quoted''' and \\ slashed\\",
    "\u202e\u2028",
]


@pytest.fixture(scope="module")
def holds(library, app_complaints):
    """Return a function: it fails unless a text has errors with places, or a good behavior."""

    def holds(text):
        start = time.process_time()  # a busy machine is not the chart's fault
        chart, problems = read_chart(text, "fuzz.xml")
        assert chart is not None or errors_in(problems)
        if chart is not None:
            checked = check_units([Unit(chart, "fuzzed")], library)["fuzz.xml"]
            problems = (*problems, *checked.problems)
            if not errors_in(problems):
                source = rendered(compile_chart(checked, "fuzzed"))
                assert app_complaints(source) == []
                classes = [n for n in ast.parse(source).body if isinstance(n, ast.ClassDef)]
                assert len(classes) == 1
                try:
                    assert faults(chart_to_scxml(chart)) == []
                except ScxmlError as error:
                    assert "rename" in str(error)
        assert all(p.position.line >= 1 and p.position.column >= 1 for p in problems)
        assert time.process_time() - start < LONGEST_S
        return problems

    return holds


@given(st.binary(max_size=300) | st.text(max_size=300).map(ascii).map(str.encode))
def test_bytes(holds, data):
    holds(data)


@given(st.data())
def test_trees(holds, data):
    def element(depth):
        tag = data.draw(st.sampled_from(TAGS))
        names = data.draw(st.lists(st.sampled_from(ATTRIBUTES), max_size=4, unique=True))
        attributes = "".join(f' {n}="{data.draw(st.sampled_from(VALUES))}"' for n in names)
        count = data.draw(st.integers(0, 3)) if depth else 0
        return f"<{tag}{attributes}>{''.join(element(depth - 1) for _ in range(count))}</{tag}>"

    space = 'xmlns:ext="urn:remodel:statechart:ext:1"'
    inside = "".join(element(3) for _ in range(data.draw(st.integers(0, 4))))
    holds(f'<statemachine {space} name="A" initial="A">{inside}</statemachine>')


@given(charts(types=st.sampled_from(["UserDataState", "ChooseState", "CountState", "Clean Up"])))
def test_models(holds, chart):
    holds(write_chart(chart))


@st.composite
def damaged(draw, text):
    """Draw the text with up to four attribute values, names or lines changed."""
    for _ in range(draw(st.integers(1, 4))):
        lines = text.splitlines()
        kind = draw(st.sampled_from(["value", "name", "drop", "double", "swap", "byte"]))
        index, other = (draw(st.integers(1, len(lines) - 1)) for _ in range(2))
        if kind == "drop":
            del lines[index]
        elif kind == "double":
            lines.insert(other, lines[index])
        elif kind == "swap":
            lines[index], lines[other] = lines[other], lines[index]
        elif kind == "byte":
            at = draw(st.integers(0, len(lines[index])))
            lines[index] = lines[index][:at] + draw(st.characters()) + lines[index][at:]
        else:
            values = re.findall('="([^"]*)"', text)
            new = draw(st.sampled_from(values) | st.sampled_from(NASTY) | st.text(max_size=4))
            pattern = '="[^"]*"' if kind == "value" else r"\w+(?==)"
            found = list(re.finditer(pattern, lines[index]))
            if found:
                where = draw(st.sampled_from(found))
                put = f'="{new}"' if kind == "value" else new
                lines[index] = lines[index][: where.start()] + put + lines[index][where.end() :]
        text = "\n".join(lines)
    return text


@pytest.mark.parametrize("name", ["plain.xml", "place_connector.xml"])
def test_damaged_charts(name, golden, holds):
    @given(damaged((golden / "charts" / name).read_text()))
    def hold(text):
        assert all(p.position.line <= text.count("\n") + 1 for p in holds(text))

    hold()


@pytest.mark.parametrize("code", CODE)
def test_code_in_values_names_and_words_stays_text(holds, code):
    chart = ChartModel(
        "Attack",
        "Set",
        (Outcome("finished"),),
        (
            State(
                "Set",
                "UserDataState",
                (Transition("done", "finished"),),
                params=(Param("data", {"k": [code, {code: code}]}),),
            ),
        ),
        inputs=(Input("given", default=code),),
        description=code.replace("\u2028", " "),
    )
    assert errors_in(holds(write_chart(chart))) == ()
    for field in ("name", "type", "event", "target", "id"):
        text = write_chart(chart).replace("UserDataState", f"{field}", 1)
        holds(text)


def test_deep_and_wide_charts_end_in_time(holds):
    deep = "<ext:container id='a' initial='a'>" * 2000 + "</ext:container>" * 2000
    head = "<statemachine xmlns:ext='urn:remodel:statechart:ext:1' name='A' initial='a'>"
    assert errors_in(holds(f"{head}{deep}</statemachine>"))
    plain = "<x>" * 100_000 + "</x>" * 100_000
    assert errors_in(holds(f"{head}{plain}</statemachine>"))
    wide = "<state id='a' type='T'/>" * 20_000
    assert errors_in(holds(f"{head}{wide}</statemachine>"))


HEAD = (
    '<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="A" initial="S0"><datamodel>'
    '<outcome name="finished"/><outcome name="failed"/><input name="component_id"/>'
    '<output name="pose"/></datamodel>'
)
COUNT = 2000


def locate(index, on, failed="failed"):
    return (
        f'<state id="S{index}" type="LocateComponentState"><transition event="located" '
        f'target="{on}"/><transition event="failed" target="{failed}"/></state>'
    )


def insert(index, on):
    return (
        f'<state id="S{index}" type="InsertCableState"><transition event="inserted" '
        f'target="{on}"/><transition event="failed" target="failed"/></state>'
    )


def connect(source, target, given="pose"):
    return (
        f'<connection output_state_id="{source}" output="{given}" input_state_id="{target}" '
        'input="pose"/>'
    )


CHAIN = [(index, f"S{index + 1}" if index < COUNT - 1 else "finished") for index in range(COUNT)]
ODD = range(1, COUNT, 2)
MANY_MISTAKES = {
    "unknown targets": [locate(index, f"T{index}") for index, _on in CHAIN],
    "unknown types": [locate(index, on).replace("Comp", f"Cmp{index}") for index, on in CHAIN],
    "dead ends": [locate(index, f"S{index}", f"S{(index + 1) % COUNT}") for index, _on in CHAIN],
    "knots of loops": [*(locate(index, on, f"S{index}") for index, on in CHAIN), "<x/>"],
    "inputs without source": [insert(index, on) for index, on in CHAIN],
    "unknown ends": [
        *(locate(index, on) for index, on in CHAIN),
        *(connect(f"X{index}", f"Y{index}", "pse") for index, _on in CHAIN),
    ],
    "read too early": [
        *(insert(index, on) for index, on in CHAIN[:-1]),
        locate(*CHAIN[-1]),
        *(connect(f"S{COUNT - 1}", f"S{index}") for index, _on in CHAIN[:-1]),
    ],
    "written over": [
        *((insert if index in ODD else locate)(index, on) for index, on in CHAIN),
        *(connect("S0", f"S{index}") for index in ODD),
    ],
}


@pytest.mark.parametrize("parts", MANY_MISTAKES.values(), ids=MANY_MISTAKES.keys())
def test_thousands_of_mistakes_are_reported_in_time(holds, parts):
    assert len(holds(f"{HEAD}{''.join(parts)}</statemachine>")) >= COUNT / 2 - 1


def calls_for(count, library):
    """Return how many calls it takes to make a behavior of a chart of some states."""
    nodes, flows = [], []
    for index in range(count):
        on = f"S{index + 1}" if index < count - 1 else "finished"
        if index % 3:
            exits = (Transition("inserted", on), Transition("failed", "failed"))
            force = (Param("force_limit_n", 20.0),)
            nodes.append(State(f"S{index}", "InsertCableState", exits, params=force))
            flows.append(Connection(f"S{index - index % 3}", "pose", f"S{index}", "pose"))
        else:
            exits = (Transition("located", on), Transition("failed", f"S{index}"))
            exits += (Transition("exhausted", "failed"),)
            nodes.append(State(f"S{index}", "LocateComponentState", exits, attempts=3))
    outcomes = (Outcome("finished"), Outcome("failed"))
    inputs = (Input("component_id"), Input("cable_id"))
    chart = ChartModel(
        "A", "S0", outcomes, tuple(nodes), inputs=inputs, connections=tuple(flows), file="a.xml"
    )
    profile = cProfile.Profile()
    with profile:
        checked = check_units([Unit(chart, "big")], library)["a.xml"]
        rendered(compile_chart(checked, "big"))
    return pstats.Stats(profile).total_calls


def test_the_work_grows_no_faster_than_n_log_n(library):
    calls_for(2, library)  # what is made once
    small, large = 200, 2000
    most = large * math.log(large) / (small * math.log(small))
    assert calls_for(large, library) < most * calls_for(small, library)


def test_a_long_chain_of_values_that_are_read_and_written_is_bound(check):
    chain = [
        f'<state id="S{index}" type="CountState"><transition event="done" target="{on}"/></state>'
        for index, on in reversed(CHAIN)
    ]
    flows = [
        f'<connection output_state_id="S{index}" output="number" input_state_id="S{index + 1}" '
        'input="number"/>'
        for index in range(COUNT - 1)
    ]
    head = '<statemachine name="A" initial="S0"><datamodel><outcome name="finished"/>'
    data = '<input name="number"/></datamodel>'
    checked, problems = check(f"{head}{data}{''.join(chain)}{''.join(flows)}</statemachine>")
    assert errors_in(problems) == ()
    assert {homes["number"] for homes in checked.resolved.flow.outputs.values()} == {"number"}
