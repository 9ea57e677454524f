"""What each outcome writes: one model for states, behaviors and containers, held to real runs."""

import itertools

import pytest
from synthesizer_support.rendering import rendered

from flexbe_core.engine.user_data import BehaviorFailure
from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.problem import ProblemKind, errors_in
from flexbe_synthesizer.core.compile import Unit, check_units, compile_chart, manifest_of
from flexbe_synthesizer.core.library.sources import write_manifest
from flexbe_synthesizer.core.machine.lower import lower
from flexbe_synthesizer.edge.package_path import find_packages, read_library

EXT = 'xmlns:ext="urn:remodel:statechart:ext:1"'
INNER = (
    f'<statemachine {EXT} name="Inner" initial="Try">'
    """<datamodel><outcome name="good"/><outcome name="bad"/>
  <output name="value"/><output name="error_code"/></datamodel>
<state id="Try" type="TryState">
  <transition event="done" target="good"/>
  <transition event="given up" target="{given_up}"/>
  <transition event="failed" target="bad"/>
</state>{more}</statemachine>"""
)
AGAIN = """<state id="Again" type="TryState">
  <transition event="done" target="good"/>
  <transition event="given up" target="Again"/>
  <transition event="failed" target="bad"/>
</state>"""
NESTED = """<behavior id="In" type="{type}" {limits}>
  <transition event="good" target="Report"/>
  <transition event="bad" target="{bad}"/>{ends}
</behavior>"""
OUTER = (
    f'<statemachine {EXT} name="Outer" initial="In">'
    """<datamodel><outcome name="end"/></datamodel>{node}
<state id="Report" type="ReportState">
  <param name="text" value="x"/><transition event="reported" target="end"/>
</state>
<connection output_state_id="In" output="{read}" input_state_id="Report" input="value"/>
</statemachine>"""
)
# What is inside, how its `good` is read, and how its `bad` leads on: whether no run lacks data.
CASES = {
    "written on the outcome": (("bad", ""), "value", "end", True),
    "not written on the outcome": (("good", ""), "value", "end", False),
    "written on the other outcome": (("bad", ""), "error_code", "end", False),
    "written on one of two outcomes": (("bad", ""), "value", "Report", False),
    "written later on": (("Again", AGAIN), "value", "end", True),
}


def nested(inner, kind, bad, limits="", ends=""):
    """Return the node that runs the inner chart: a behavior, or a container of its content."""
    node = NESTED.format(type={"path": "inner.xml"}.get(kind, "Inner"), **locals())
    if kind != "container":
        return node
    body = inner.partition("<datamodel>")[2].removesuffix("</statemachine>")
    after = node.partition(">")[2].replace("</behavior>", "</ext:container>")
    return f'<ext:container id="In" initial="Try" {limits}><datamodel>{body}{after}'


@pytest.fixture
def charts(package_path, tmp_path):
    """Return a function: inner and outer chart, how one names the other -> checked, and texts."""

    def charts(inner, outer, kind):
        texts = {"outer.xml": outer}
        packages = package_path
        if kind in ("path", "name"):
            texts["inner.xml"] = inner
        if kind == "source":
            packages = f"{package_path}:{installed(inner, tmp_path / 'p', package_path)}"
        library = read_library(find_packages(packages)[0])[0]
        units = [Unit(parse_chart(text, path), "p") for path, text in texts.items()]
        return check_units(units, library)

    return charts


def installed(inner, package, package_path):
    """Generate the behavior of a chart into a package without the chart, and return its folder."""
    library = read_library(find_packages(package_path)[0])[0]
    checked = check_units([Unit(parse_chart(inner, "inner.xml"), "p")], library)["inner.xml"]
    machine = compile_chart(checked, "p")
    (package / "src" / "p").mkdir(parents=True)
    (package / "manifest").mkdir()
    (package / "package.xml").write_text(
        "<package><name>p</name><export><flexbe_behaviors/></export></package>"
    )
    (package / "src" / "p" / "inner_sm.py").write_text(rendered(machine))
    (package / "manifest" / "inner.xml").write_text(write_manifest(manifest_of(machine), ""))
    return package


def generated(checked):
    return rendered(lower(checked.resolved, "p"))


def dies(on_engine, texts):
    """Return whether some run of up to three choices lacks data."""
    for picks in itertools.product(range(3), repeat=3):
        left = list(picks)

        def choose(_path, events, left=left):
            return events[left.pop(0) % len(events)] if left else events[0]

        try:
            on_engine(texts, choose)
        except BehaviorFailure as error:
            assert "no data for key" in str(error)
            return True
    return False


@pytest.mark.parametrize("kind", ["container", "path", "name", "source"])
@pytest.mark.parametrize("case", CASES)
def test_what_is_accepted_never_lacks_data_and_what_is_refused_does(case, kind, charts, on_engine):
    (given_up, more), read, bad, is_good = CASES[case]
    inner = INNER.format(given_up=given_up, more=more)
    outer = OUTER.format(node=nested(inner, kind, bad), read=read)
    checked = charts(inner, outer, kind)
    found = errors_in(p for one in checked.values() for p in one.problems)
    assert [p.code for p in found] == [] if is_good else [ProblemKind.READ_BEFORE_WRITE]
    texts = [generated(checked["outer.xml"])]
    if kind in ("path", "name"):
        texts.insert(0, generated(checked["inner.xml"]))
    if kind == "source":
        alone = charts("", inner, "container")["outer.xml"]
        texts.insert(0, generated(alone))
    assert dies(on_engine, texts) is not is_good


def test_custom_code_in_a_nested_behavior_makes_nothing_certain(charts, tmp_path, package_path):
    inner = INNER.format(given_up="bad", more="")
    outer = OUTER.format(node=nested(inner, "source", "end"), read="value")
    assert errors_in(charts(inner, outer, "source")["outer.xml"].problems) == ()
    file = tmp_path / "p" / "src" / "p" / "inner_sm.py"
    file.write_text(file.read_text().replace("# [/MANUAL_CREATE]", "self.change(_state_machine)"))
    library = read_library(find_packages(f"{package_path}:{tmp_path}")[0])[0]
    checked = check_units([Unit(parse_chart(outer, "outer.xml"), "q")], library)["outer.xml"]
    assert [p.code for p in errors_in(checked.problems)] == [ProblemKind.READ_BEFORE_WRITE]


def test_a_state_class_says_in_its_docstring_what_an_outcome_writes(check):
    node = """<state id="In" type="TryState">
  <transition event="done" target="end"/><transition event="given up" target="end"/>
  <transition event="failed" target="Report"/></state>"""
    assert errors_in(check(OUTER.format(node=node, read="error_code"))[1]) == ()
    (problem,) = errors_in(check(OUTER.format(node=node, read="value"))[1])
    assert problem.code is ProblemKind.READ_BEFORE_WRITE
    assert "In -failed-> Report. 'In' does not write it when it ends with 'failed'." in str(problem)


ROUTED = f"""<statemachine {EXT} name="Outer" initial="In">
<datamodel><outcome name="end"/></datamodel>
<behavior id="In" type="inner.xml" ext:on_error="3: end">
  <transition event="good" target="end"/><transition event="failed" target="end"/>
</behavior></statemachine>"""


@pytest.mark.parametrize(("given_up", "is_good"), [("good", True), ("failed", False)])
def test_a_route_by_error_code_needs_a_code_on_each_path(given_up, is_good, charts, on_engine):
    inner = INNER.format(given_up=given_up, more="").replace('"bad"', '"failed"')
    checked = charts(inner, ROUTED, "path")
    found = errors_in(checked["outer.xml"].problems)
    assert [p.code for p in found] == ([] if is_good else [ProblemKind.READ_BEFORE_WRITE])
    texts = [generated(checked[path]) for path in ("inner.xml", "outer.xml")]
    assert dies(on_engine, texts) is not is_good


def test_attempts_that_an_earlier_visit_has_spent_write_nothing(charts, on_engine):
    limits = 'ext:attempts="1"'
    inner = INNER.format(given_up="bad", more="").replace(
        'type="TryState">',
        f'type="TryState" {limits}><transition event="exhausted" target="good"/>',
    )
    for bad, is_good in (("end", True), ("In", False)):
        outer = OUTER.format(node=nested(inner, "container", bad), read="value")
        checked = charts(inner, outer, "container")["outer.xml"]
        found = [p.code for p in errors_in(checked.problems)]
        assert found == ([] if is_good else [ProblemKind.READ_BEFORE_WRITE])
        assert dies(on_engine, [generated(checked)]) is not is_good
