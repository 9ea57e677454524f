"""Mistakes besides those of test_errors_page.py, which has one for each code.

Each is reported alone, at its line and column, with a message that helps.
"""

import dataclasses

import pytest
from synthesizer_support.classes import state_class

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.model import Chart, Outcome, State, Transition
from flexbe_synthesizer.core.chart.problem import errors_in
from flexbe_synthesizer.core.check.check import check_chart
from flexbe_synthesizer.core.compile import Unit, check_units
from flexbe_synthesizer.core.library.signature import Library

GOOD = """\
<?xml version="1.0"?>
<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="Task" initial="Locate">
  <datamodel>
    <outcome name="finished"/>
    <outcome name="gone"/>
    <input name="component_id" type="string"/>
    <input name="cable_id"/>
    <output name="error_code" type="int"/>
  </datamodel>
  <state id="Locate" type="LocateComponentState" topic="locate" ext:attempts="3">
    <param name="view" value="side"/>
    <transition event="located" target="Insert"/>
    <transition event="failed" target="Locate"/>
    <transition event="exhausted" target="gone"/>
  </state>
  <state id="Insert" type="InsertCableState">
    <param name="force_limit_n" value="20"/>
    <transition event="inserted" target="Clean"/>
    <transition event="failed" target="Extract"/>
  </state>
  <state id="Extract" type="ExtractCableState" ext:timeout_s="2.5">
    <transition event="extracted" target="Locate"/>
    <transition event="failed" target="gone"/>
  </state>
  <behavior id="Clean" type="Clean Up">
    <transition event="cleaned" target="finished"/>
    <transition event="failed" target="gone"/>
  </behavior>
  <connection output_state_id="Locate" output="pose" input_state_id="Insert" input="pose"/>
</statemachine>
"""
END = "</statemachine>"
VIEW = '<param name="view" value="side"/>'
TO_CLEAN = '<transition event="inserted" target="Clean"/>'
TO_EXTRACT = '<transition event="failed" target="Extract"/>'
EXTRACTED = '<transition event="extracted" target="Locate"/>'
CLEANED = '<transition event="cleaned" target="finished"/>'
CLEAN = '<behavior id="Clean" type="Clean Up">'
DATA = "<datamodel>"
FINISHED = '<outcome name="finished"/>'
GONE = '<outcome name="gone"/>'
COMPONENT = '<input name="component_id" type="string"/>'
CABLE = '<input name="cable_id"/>'
CODE = '<output name="error_code" type="int"/>'
CHOOSE = """<state id="Choose" type="ChooseState">
    <param name="outcomes" ◊value="[1]"/>
    <transition event="a" target="finished"/>
  </state>
"""
PAUSE = """<state id="Pause" ◊type="PauseState">
    <transition event="done" target="finished"/>
  </state>
"""


def flow(source, output, target, key):
    return (
        f'<connection output_state_id="{source}" output="{output}" '
        f'input_state_id="{target}" input="{key}"/>'
    )


# Code, part of the message, and the changes to the good chart; ◊ stands before the place.
CASES = [
    ("unknown-element", "Did you mean 'state'?", (DATA, "◊<sate/>" + DATA)),
    ("unknown-element", "no namespace", (DATA, '◊<x:s xmlns:x="urn:x"/>' + DATA)),
    ("unknown-element", "outermost element is <statemachine>", (GOOD, "◊<scxml/>")),
    ("duplicate-element", "second <outcomes>", (GONE, GONE + "<outcomes/>◊<outcomes/>")),
    ("unknown-attribute", "Did you mean 'topic'?", ("topic", "◊topics")),
    (
        "unknown-attribute",
        "'topic' of the namespace 'urn:x'",
        ("topic", 'xmlns:x="urn:x" ◊x:topic'),
    ),
    ("missing-attribute", "type of <behavior> is empty", ('type="Clean Up"', '◊type=""')),
    ("unknown-extension", "no element <ext:box>", (DATA, "◊<ext:box/>" + DATA)),
    ("unknown-extension", "has: none", (' name="view"', ' ◊ext:default="1" name="view"')),
    ("invalid-value", "an integer from 1", ('ext:attempts="3"', '◊ext:attempts="two"')),
    (
        "invalid-value",
        "two whole numbers",
        ('ext:timeout_s="2.5"', 'ext:timeout_s="2.5" ◊ext:at="12"'),
    ),
    ("invalid-value", "above 0", ('ext:timeout_s="2.5"', '◊ext:timeout_s="-1"')),
    ("invalid-value", "'off', 'low'", ('"Extract"/>', '"Extract" ◊ext:autonomy="max"/>')),
    ("invalid-name", "the first of these a letter", ('name="Task"', '◊name="日本"')),
    ("invalid-name", "the first of these a letter", ('name="Task"', '◊name="Ä1"')),
    ("invalid-name", "at most 200 letters", ('name="Task"', f'◊name="{"T" * 201}"')),
    ("invalid-name", "single '/' between", ('topic="locate"', '◊topic="a b!"')),
    (
        "invalid-name",
        "'cell 1/locate' of state 'Locate' cannot name a topic; allowed: a-z,",
        (' topic="locate"', ""),
        (VIEW, VIEW + '<param name="topic" ◊value="cell 1/locate"/>'),
    ),
    (
        "invalid-name",
        "'5' of state 'Locate' cannot name a topic",
        (' topic="locate"', ""),
        (VIEW, VIEW + '<param name="topic" ◊value="5"/>'),
    ),
    ("invalid-name", "'a,b' of an outcome", (FINISHED, FINISHED + '<outcome ◊name="a,b"/>')),
    ("invalid-name", "Python identifier", (CABLE, CABLE + '<input ◊name="my key"/>')),
    (
        "invalid-name",
        "'def' and 'class'",
        ('id="Clean"', '◊id="Clean def x"'),
        ('"Clean"/>', '"Clean def x"/>'),
    ),
    ("reserved-name", "adds it", (FINISHED, FINISHED + '<outcome ◊name="preempted"/>')),
    (
        "reserved-name",
        "delete this",
        (TO_EXTRACT, f'{TO_EXTRACT}<transition ◊event="preempted" target="gone"/>'),
    ),
    (
        "reserved-name",
        "also an outcome of the chart",
        ('id="Clean"', '◊id="gone"'),
        ('"Clean"/>', '"gone"/>'),
    ),
    (
        "reserved-name",
        "a state that the extension adds for 'Locate'",
        ('id="Clean"', '◊id="Locate_attempts"'),
        ('"Clean"/>', '"Locate_attempts"/>'),
    ),
    ("unknown-type", "ROS message (package/Message)", ('type="int"', '◊type="number"')),
    ("duplicate-name", "attribute of state", (VIEW, '<param ◊name="topic" value="a"/>')),
    ("duplicate-name", "second input", (CABLE, CABLE + CABLE.replace("name", "◊name"))),
    ("duplicate-name", "in line 4", (FINISHED, FINISHED + FINISHED.replace("name", "◊name"))),
    ("unknown-class", "no state class", ('type="Insert', '◊type="other_states/Insert')),
    (
        "unknown-parameter",
        "has no parameter 'topic'",
        ('type="ExtractCableState"', 'type="ExtractCableState" ◊topic="a"'),
    ),
    ("parameter-type", "dictionary", (CLEAN, CLEAN + '<param name="places" ◊value="[{}]"/>')),
    (
        "parameter-type",
        "needed a list of names",
        (END, CHOOSE + END),
        (CLEANED, CLEANED.replace("finished", "Choose")),
    ),
    (
        "parameter-source",
        "takes Python source",
        (END, PAUSE.replace("PauseState", "CalculateState") + END),
        (CLEANED, CLEANED.replace("finished", "Pause")),
    ),
    (
        "unknown-event",
        "limit the attempts with ext:attempts",
        (TO_EXTRACT, TO_EXTRACT + '<transition ◊event="exhausted" target="gone"/>'),
    ),
    (
        "missing-transition",
        "which ext:attempts adds, leads nowhere",
        ('<state id="Locate"', '◊<state id="Locate"'),
        ('<transition event="exhausted" target="gone"/>', ""),
    ),
    (
        "unknown-input",
        "cannot copy input 'cable_id' of the chart to its output 'error_code'",
        (END, flow("Task", "cable_id", "Task", "error_code").replace(" input=", " ◊input=") + END),
    ),
    ("unknown-output", "no output 'torque'", (TO_CLEAN, '<output ◊name="torque"/>' + TO_CLEAN)),
    (
        "unknown-input",
        "Did you mean 'cable_id'",
        (TO_CLEAN, '<input ◊name="cabel_id"/>' + TO_CLEAN),
    ),
    (
        "type-conflict",
        "output 'error_code' of 'Locate' is int, output 'error_code' of the chart is string",
        (CODE, "◊" + CODE.replace("int", "string")),
    ),
    (
        "type-conflict",
        "input 'component_id' of the chart is int, input 'component_id' of 'Locate' is string",
        (COMPONENT, COMPONENT.replace("string", "int")),
        ('<state id="Locate"', '◊<state id="Locate"'),
    ),
    (
        "type-conflict",
        "is many (string); its type is int.",
        (CABLE, CABLE + '<input name="spare" type="int" ◊ext:default="many"/>'),
    ),
    (
        "type-conflict",
        "input 'cable_id' of state class ExtractCableState is string; found list",
        (EXTRACTED, '<input name="cable_id" ◊type="list"/>' + EXTRACTED),
    ),
]


def edited(*changes):
    """Return the good chart with texts replaced, and the line and column of the mark."""
    text = GOOD
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    before = text.partition("◊")[0]
    return text.replace("◊", ""), (before.count("\n") + 1, len(before) - before.rfind("\n"))


def lines_of(problems):
    return "\n".join(map(str, problems))


def test_a_good_chart_has_no_problem(check):
    assert check(GOOD)[1] == ()


@pytest.mark.parametrize(
    ("code", "part", "changes"),
    [(code, part, changes) for code, part, *changes in CASES],
    ids=[f"{code}-{number}" for number, (code, *_) in enumerate(CASES)],
)
def test_a_mistake_is_reported_alone_and_in_its_place(check, code, part, changes):
    text, place = edited(*changes)
    problems = errors_in(check(text)[1])
    assert [(p.code.slug, p.position[1:]) for p in problems] == [(code, place)], lines_of(problems)
    assert part in problems[0].message


def test_the_missing_parts_of_a_chart_are_reported(check):
    assert lines_of(check('<statemachine name="A" initial="B"/>')[1]).splitlines()[:2] == [
        "chart.xml:1:1: [missing-element] no <datamodel>; a chart needs one, with its outcomes.",
        "chart.xml:1:1: [missing-element] neither a <state> nor a <behavior>; a chart needs at "
        "least one.",
    ]
    text = '<statemachine name="A" initial="B">\n <datamodel><outcomes/></datamodel></statemachine>'
    assert 'chart.xml:2:2: [missing-element] no <outcome name="..."/>' in lines_of(check(text)[1])


@pytest.fixture
def check_all(library):
    """Return a function: {path: text} -> all problems of charts in one package."""

    def check_all(texts, known=library):
        units = [Unit(parse_chart(text, path), "cell_behaviors") for path, text in texts.items()]
        checked = check_units(units, known)
        return [problem for one in checked.values() for problem in one.problems]

    return check_all


def task(name, inner):
    """Return a chart that only runs another behavior."""
    return (
        f'<statemachine name="{name}" initial="Run"><datamodel><outcome name="done"/></datamodel>\n'
        f'<behavior id="Run" type="{inner}"><transition event="done" target="done"/></behavior>'
        "</statemachine>"
    )


def places(problems, code):
    return [p.position for p in problems if p.code.slug == code]


def test_of_charts_that_contain_each_other_the_circle_is_reported(check_all):
    problems = check_all({"d/a.xml": task("A", "e/b.xml"), "d/e/b.xml": task("B", "../a.xml")})
    assert places(problems, "chart-cycle") == [("d/a.xml", 2, 20), ("d/e/b.xml", 2, 20)]
    assert "A > B > A" in problems[0].message


def test_of_a_chart_contained_in_an_existing_behavior_the_circle_is_reported(check_all, library):
    clean_up = dataclasses.replace(library.behaviors[0], contains=("A",), outcomes=("done",))
    known = dataclasses.replace(library, behaviors=(clean_up,))
    problems = check_all({"a.xml": task("A", "Clean Up")}, known)
    assert "A > Clean Up > A" in lines_of(problems)


def test_charts_can_name_each_other_by_display_name(check_all):
    inner = (
        task("Inner", "Clean Up")
        .replace('event="done"', 'event="cleaned"')
        .replace("</behavior>", '<transition event="failed" target="done"/></behavior>')
        .replace("</datamodel>", '<input name="cable_id"/></datamodel>')
    )
    outer = task("Outer", "Inner").replace("</datamodel>", '<input name="cable_id"/></datamodel>')
    assert check_all({"a.xml": outer, "b.xml": inner}) == []


def test_two_behaviors_of_one_class_cannot_be_used_side_by_side(check_all, library):
    other = dataclasses.replace(library.behaviors[0], name="Clean", module="other.clean_up_sm")
    known = dataclasses.replace(library, behaviors=(*library.behaviors, other))
    second = CLEAN.replace('id="Clean" type="Clean Up"', 'id="Last" type="Clean"')
    text, _ = edited(
        (END, f"{second}{CLEANED}<transition event='failed' target='gone'/></behavior>{END}"),
        (CLEANED, CLEANED.replace("finished", "Last")),
    )
    problems = check_all({"a.xml": text}, known)
    assert places(problems, "duplicate-behavior") == [("a.xml", 30, 21)]


def test_an_extension_without_the_state_that_it_needs_says_which(library, check_all):
    known = dataclasses.replace(
        library, states=tuple(s for s in library.states if s.name != "CountAttemptsState")
    )
    problems = check_all({"a.xml": GOOD}, known)
    assert places(problems, "unknown-class") == [("a.xml", 10, 65)]
    assert "CountAttemptsState of package remodel_states" in problems[0].message


def test_ten_mistakes_are_reported_in_one_go_each_in_its_line(check, golden):
    text = (golden / "wrong" / "ten_mistakes.xml").read_text()
    expected = {
        (number, line.partition("mistake: ")[2].split()[0])
        for number, line in enumerate(text.splitlines(), start=1)
        if "mistake: " in line
    }
    found = {(p.position.line, p.code.slug) for p in errors_in(check(text)[1])}
    assert len(expected) == 10
    assert found == expected


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ('topic="a">', 'topic="b!">'),
        ('><param name="topic" value="a"/>', '><param name="topic" value="b!"/>'),
        ('><param name="led_topic" value="a"/>', '><param name="led_topic" value="b!"/>'),
    ],
)
def test_states_that_differ_in_a_topic_alone_are_both_checked(check, first, second):
    ends = '<transition event="located" target="{0}"/><transition event="failed" target="{0}"/>'
    state = '<state id="{}" type="LocateComponentState" {}{}</state>'
    text = (
        '<statemachine name="A" initial="One"><datamodel><outcome name="x"/>'
        '<input name="component_id"/></datamodel>'
        + state.format("One", first, ends.format("Two"))
        + state.format("Two", second, ends.format("x"))
        + "</statemachine>"
    )
    (problem,) = errors_in(check(text)[1])
    assert "'b!' of state 'Two' cannot name a topic" in problem.message


def test_an_outcome_of_a_class_of_its_own_is_added_by_no_extension():
    library = Library(states=(state_class("Own", ("timed_out", "exhausted")),))
    chart = Chart("A", "S", (Outcome("x"),), (State("S", "Own", (Transition("exhausted", "x"),)),))
    (problem,) = errors_in(check_chart(chart, library, {}).problems)
    assert problem.message.startswith("outcome 'timed_out' of state 'S' leads nowhere;")
