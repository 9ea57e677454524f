import shutil

import pytest

from flexbe_synthesizer.edge.chart_files import ChartMemory
from flexbe_synthesizer.edge.output_package import OutputPackage, output_package
from flexbe_synthesizer.edge.package_path import read_inventory
from flexbe_synthesizer.synthesis import check_files, write_behaviors

OUTER, INNER = "wire_task.xml", "place_connector.xml"
READS = """<statemachine name="Outer" initial="In">
  <datamodel><outcome name="end"/></datamodel>
  <behavior id="In" type="{inner}">
    <transition event="good" target="Report"/>
    <transition event="bad" target="end"/>
  </behavior>
  <state id="Report" type="ReportState">
    <param name="text" value="x"/><transition event="reported" target="end"/>
  </state>
  <connection output_state_id="In" output="value" input_state_id="Report" input="value"/>
</statemachine>"""
WRITES = """<statemachine name="Inner" initial="Try">
  <datamodel><outcome name="good"/><outcome name="bad"/><output name="value"/></datamodel>
  <state id="Try" type="TryState">
    <transition event="done" target="good"/>
    <transition event="given up" target="bad"/>
    <transition event="failed" target="bad"/>
  </state>
</statemachine>"""


@pytest.fixture
def charts(tmp_path, golden):
    return shutil.copytree(golden / "charts", tmp_path / "charts")


def check(charts, library, memory, draft=None):
    """Return the outer chart checked with what it names, as the console and the server do."""
    path = str(charts / OUTER)
    return check_files(
        [path],
        library,
        lambda _path: OutputPackage("golden_behaviors", charts, {}),
        drafts={} if draft is None else {path: draft},
        memory=memory,
    )


def edit(charts, name, old, new):
    file = charts / name
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new, 1))


def test_what_has_not_changed_is_neither_read_nor_checked_again(charts, library):
    memory = ChartMemory()
    first = check(charts, library, memory)
    again = check(charts, library, memory)
    assert len(first.charts) == 2
    for path, one in first.charts.items():
        assert again.charts[path].resolved is one.resolved


def test_a_draft_is_checked_and_the_charts_that_it_names_are_not(charts, library):
    memory = ChartMemory()
    first = check(charts, library, memory)
    text = (charts / OUTER).read_bytes()
    draft = text.replace(b'ext:attempts="', b'ext:attempts="1')
    assert draft != text
    second = check(charts, library, memory, draft=draft)
    resolved = [
        [files.charts[str(charts / name)].resolved for name in (OUTER, INNER)]
        for files in (first, second)
    ]
    assert resolved[0][0] is not resolved[1][0]
    assert resolved[0][1] is resolved[1][1]


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        (INNER, "<transition", "<transitions"),
        (INNER, '<outcome name="failed"/>', '<outcome name="broken"/>'),
        (INNER, '<input name="', '<input name="other_'),
        (INNER, 'name="Place Connector"', 'name="Wire Task"'),
        (OUTER, 'target="', 'target="No'),
        (OUTER, "</statemachine>", ""),
    ],
)
def test_what_is_remembered_is_what_a_first_check_finds(charts, library, name, old, new):
    memory = ChartMemory()
    check(charts, library, memory)
    before = (charts / name).read_bytes()
    edit(charts, name, old, new)
    changed = check(charts, library, memory)
    expected = check(charts, library, None)
    assert changed.problems == expected.problems
    assert changed.problems
    assert list(changed.charts) == list(expected.charts)
    (charts / name).write_bytes(before)
    assert check(charts, library, memory).problems == check(charts, library, None).problems


def write_less(charts):
    """Leave the interface of the inner chart as it is, and have `good` no longer write `value`."""
    edit(charts, INNER, 'event="given up" target="bad"', 'event="given up" target="good"')


def test_what_a_named_chart_no_longer_writes_is_seen(charts, library):
    (charts / OUTER).write_text(READS.format(inner=INNER))
    (charts / INNER).write_text(WRITES)
    memory = ChartMemory()
    assert not check(charts, library, memory).problems
    write_less(charts)
    found = check(charts, library, memory).problems
    assert found == check(charts, library, None).problems
    assert [problem.code.slug for problem in found] == ["read-before-write"]


def test_what_the_code_of_a_named_behavior_no_longer_writes_is_seen(charts, package_path):
    """A behavior that is installed without its chart is read back from its file."""
    package = charts.parent / "packages" / "inner_behaviors"

    def install():
        output = output_package(package)
        files = check_files([str(charts / INNER)], library(), lambda _path: output)
        write_behaviors(files)

    def library():
        return read_inventory(f"{package_path}:{package.parent}").library

    (charts / INNER).write_text(WRITES)
    install()
    (charts / OUTER).write_text(READS.format(inner="Inner"))
    memory = ChartMemory()
    assert not check(charts, library(), memory).problems
    write_less(charts)
    install()
    found = check(charts, library(), memory).problems
    assert [problem.code.slug for problem in found] == ["read-before-write"]


def test_another_library_has_all_checked_again(charts, library):
    memory = ChartMemory()
    assert not check(charts, library, memory).problems
    lacking = type(library)(states=library.states[:1])
    found = check(charts, lacking, memory).problems
    assert found == check(charts, lacking, None).problems
    assert {problem.code.slug for problem in found} >= {"unknown-class"}
    assert not check(charts, library, memory).problems


def test_the_oldest_texts_are_forgotten(charts, library):
    texts = [(charts / name).read_bytes() for name in (OUTER, INNER)]
    memory = ChartMemory(most_bytes=max(map(len, texts)))
    first = [memory.read(text, name)[0] for text, name in zip(texts, "ab", strict=True)]
    assert memory.read(texts[1], "b")[0] is first[1]
    assert memory.read(texts[0], "a")[0] is not first[0]
    assert memory.read(texts[0], "a")[0] == first[0]
