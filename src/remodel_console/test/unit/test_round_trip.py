"""The XML of a chart is its author's: an edit changes its own lines, saving alone changes nothing.

Each edit goes through the session that pages and commands share; those that are saved, to the file.
"""

import difflib
import re
import shutil
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path

import pytest

from flexbe_synthesizer.core.chart.chart_reader import parse_chart, read_chart
from flexbe_synthesizer.core.chart.model import (
    Behavior,
    Container,
    ContainerKind,
    Param,
    State,
    Transition,
)
from flexbe_synthesizer.core.chart.problem import errors_in
from remodel_console.core import chart_edit
from remodel_console.core.chart_edit import with_condition, with_input, with_kind, with_output
from remodel_console.core.commands import read_command
from remodel_console.core.copying import grouped
from remodel_console.core.editing import change_at, container_at, node_paths
from remodel_console.edge.workspace import Workspace, inspect_text
from remodel_console.errors import CommandError, FileChangedError
from remodel_console.session import Session

SRC = Path(__file__).parents[3]
SHIPPED = sorted(
    (
        *SRC.glob("remodel_behaviors/charts/*.xml"),
        *SRC.glob("remodel_console/test/charts/*.xml"),
        *SRC.glob("flexbe_synthesizer/test/golden/charts/*.xml"),
    )
)
COMMENTED = """<?xml version='1.0' encoding='UTF-8'?>
<!-- Licence: ours. -->
<statemachine  initial = 'Wait'
    name='Odd One' xmlns:e='urn:remodel:statechart:ext:1' >

\t<!-- Waits twice,
\t     then ends. -->
\t<datamodel>
\t\t<outcomes> <outcome name='finished' /> <outcome name='failed' /> </outcomes>
\t</datamodel>

\t<!-- The first wait.
\t     <param name="old" value="1"/> -->
\t<state e:attempts='3' id='Wait'\ttype='WaitState'> <!-- on the line -->
\t\t<!-- seconds, > 0 -->
\t\t<param value = '30' name = 'wait_time' /> <!-- half a minute -->

\t\t<transition event='done' target='Again' /><!-- no blank -->
\t\t<transition event='exhausted' target='failed' />
\t</state>
\t<?editor fold?>
\t<state id='Again' type='WaitState'
\t       e:timeout_s='30'>
\t\t<param name='wait_time' value='1.50' />
\t\t<transition event='done' target='finished' />
\t\t<transition event='timed_out' target='failed' />
\t</state>
\t<!-- The end. -->
</statemachine>
<!-- After all. -->
"""
ONE_LINE = (
    '<statemachine name="One Line" initial="A"><datamodel><outcome name="finished"/></datamodel>'
    '<state id="A" type="WaitState"><param name="wait_time" value="30"/>'
    '<transition event="done" target="B"/></state><state id="B" type="WaitState">'
    '<param name="wait_time" value="2"/><transition event="done" target="finished"/></state>'
    "</statemachine>"
)
PLAIN = ONE_LINE.replace("><", ">\n<").replace("One Line", "Plain")
ODD = {
    "commented": COMMENTED.encode(),
    "one_line": ONE_LINE.encode(),
    "plain": PLAIN.encode(),
    "dos": COMMENTED.replace("\n", "\r\n").replace("Odd One", "Dos").encode(),
    "marked": b"\xef\xbb\xbf" + PLAIN.replace("Plain", "Marked").encode(),
    "wide": PLAIN.replace("Plain", "Wide").encode("utf-16"),
    "latin": PLAIN.replace("Plain", "Latin")
    .replace("<datamodel>", "<!-- für Menschen --><datamodel>", 1)
    .replace("<state", '<?xml version="1.0" encoding="ISO-8859-1"?>\n<state', 1)
    .encode("latin-1"),
}


@pytest.fixture(scope="module")
def charts(tmp_path_factory):
    """Return a package whose charts are all that are shipped, and odd ones."""
    package = tmp_path_factory.mktemp("charts") / "remodel_behaviors"
    shutil.copytree(SRC / "remodel_behaviors", package)
    shutil.rmtree(package / "charts")
    (package / "charts").mkdir()
    for path in SHIPPED:
        is_golden = "golden" in path.parts
        target = package / "charts" / f"{'golden_' * is_golden}{path.name}"
        text = path.read_bytes()
        if is_golden:
            text = re.sub(rb'(<statemachine[^>]*name=")', rb"\1Golden ", text, count=1)
        target.write_bytes(text)
    for name, content in ODD.items():
        (package / "charts" / f"{name}.xml").write_bytes(content)
    return package / "charts"


@pytest.fixture
def session(charts):
    states = (SRC / "remodel_states", SRC / "flexbe" / "flexbe_states")
    return Session(Workspace(":".join(map(str, (charts.parent, *states)))))


def chart_names():
    for path in SHIPPED:
        name = parse_chart(path.read_bytes()).name
        yield f"Golden {name}" if "golden" in path.parts else name
    for content in ODD.values():
        yield parse_chart(content).name


def tags(text):
    """Return the tags and comments of a text."""
    return re.findall(r"<!--.*?-->|<[^>]*>", text, re.DOTALL)


def difference(one, other):
    """Return the (removed, added) parts of a list."""
    removed, added = [], []
    matcher = difflib.SequenceMatcher(None, one, other, autojunk=False)
    for kind, first, last, start, end in matcher.get_opcodes():
        if kind != "equal":
            removed += one[first:last]
            added += other[start:end]
    return removed, added


def line_count(parts):
    return sum(part.count("\n") + 1 for part in parts)


def comments(text):
    return re.findall(r"<!--.*?-->|<\?.*?\?>", text, re.DOTALL)


class Edit:
    """Makes an edit in a session, holds the text to what it may change, and takes it back."""

    def __init__(self, session):
        self.session = session

    def __call__(self, path, change, removed, added, *, keeps_comments=True):
        """Make an edit by which so many tags, and no other lines than theirs, may differ."""
        session = self.session
        before, wanted = session.text, change_at(session.chart, path, change)
        session.change(lambda _chart: wanted)
        after = session.text
        assert read_chart(after, "")[0] == wanted
        gone, new = difference(tags(before), tags(after))
        if not keeps_comments:  # what goes takes those with it that are in it
            gone = [tag for tag in gone if not tag.startswith("<!--")]
        assert len(gone) <= removed, (gone, new)
        assert len(new) <= added, (gone, new)
        if keeps_comments:
            assert comments(after) == comments(before)
            lines_gone, lines_new = difference(before.splitlines(), after.splitlines())
            assert len(lines_gone) <= max(line_count(gone), bool(new)), (lines_gone, lines_new)
            assert len(lines_new) <= max(line_count(new), bool(gone)), (lines_gone, lines_new)
        if after != before:
            session.undo()
        assert session.text == before
        return after


@pytest.mark.parametrize("name", list(chart_names()))
def test_each_edit_of_the_console_changes_its_own_lines_only(session, name):
    session.carry_out(read_command(f"load {name}"))
    edit = Edit(session)
    for path in node_paths(session.chart):
        edit_node(edit, session, path)
    for path in [(), *(p for p in node_paths(session.chart) if has_body(session.chart, p))]:
        edit_scope(edit, container_at(session.chart, path), path)


def has_body(chart, path):
    return isinstance(chart_edit.node_at(chart, path), Container)


def edit_node(edit, session, path):
    """Make every edit that the console offers of a state, behavior or container."""
    node, scope = chart_edit.node_at(session.chart, path), container_at(session.chart, path[:-1])
    inside = partial(edit, path[:-1])
    one_tag = {"removed": 1, "added": 1}
    for param in node.params:
        given = partial(chart_edit.with_parameter, node_id=node.id, name=param.name)
        inside(partial(given, text="47.25"), **one_tag)
        inside(partial(given, text="a & b < 'c' \"d\""), **one_tag)
        inside(partial(given, text=""), 1, 0)
    if not isinstance(node, Container):
        new = partial(chart_edit.with_parameter, node_id=node.id, name="brand_new", text="5")
        text = inside(new, 1, 3)
        assert 'name="brand_new"' in text or "name='brand_new'" in text
    for transition in node.transitions:
        lead = partial(chart_edit.led, node_id=node.id, event=transition.event)
        inside(partial(lead, target="elsewhere"), **one_tag)
        inside(partial(lead, target=""), 1, 0)
    inside(partial(chart_edit.led, node_id=node.id, event="new", target=node.id), 1, 3)
    limits = partial(chart_edit.limited, node_id=node.id)
    inside(partial(limits, attempts=7, timeout_s=node.timeout_s), 2, 2)
    text = inside(partial(limits, attempts=node.attempts, timeout_s=45.0), 2, 2)
    assert node.timeout_s != 30 or re.search("timeout_s=['\"]45['\"]", text)
    inside(partial(limits, attempts=None, timeout_s=None), 1, 1)
    inside(partial(chart_edit.routed, node_id=node.id, text=f"100-199: {node.id}"), 2, 2)
    if scope.initial:
        inside(partial(chart_edit.started_at, node_id=node.id), **one_tag)
    mentions = len(re.findall(f"['\" ]{re.escape(node.id)}['\";]", session.text))
    renamed = partial(chart_edit.renamed, old=node.id, new="Brand new")
    inside(renamed, mentions, mentions)
    for port in scope.inputs:
        fed = partial(chart_edit.fed, node_id=node.id, input_name="x")
        inside(partial(fed, source=(scope.name, port.name)), 1, 2)
    for flow in scope.connections:
        if flow.input_state_id == node.id:
            fed = partial(chart_edit.fed, node_id=node.id, input_name=flow.input)
            inside(partial(fed, source=("Other", "y")), 2, 2)
            inside(partial(fed, source=None), 1, 0)
    own = len(parts_of(node))
    gone = partial(chart_edit.without_node, node_id=node.id)
    inside(gone, own + mentions + 2, mentions, keeps_comments=False)
    if isinstance(node, Container):
        for kind in ContainerKind:
            change = partial(with_kind, node_id=node.id, kind=kind)
            inside(change, own, 2 + len(node.body.nodes), keeps_comments=False)


def parts_of(node):
    """Return something for each tag that a node has at most."""
    inner = [*node.params, *node.transitions, *node.inputs, *node.outputs]
    if isinstance(node, Container):
        body = node.body
        inner += [*body.outcomes, *body.inputs, *body.outputs, *body.connections, *body.conditions]
        inner += [when for condition in body.conditions for when in (*condition.all_of, condition)]
        inner += [part for one in body.nodes for part in parts_of(one)] + [None] * 4
    return [*inner, None, None]


def edit_scope(edit, scope, path):
    """Make every edit that the console offers of a chart or the content of a container."""
    inside = partial(edit, path)
    around = 2 * len(path)  # a new value of a container becomes one of what is around it
    end = Transition("done", scope.outcomes[0].name)
    state = State("Brand new", "WaitState", (end,), params=(Param("wait_time", 1),))
    text = inside(lambda one: chart_edit.with_node(one, state), 0, 4)
    assert re.search("id=['\"]Brand new['\"]", text)
    inside(lambda one: chart_edit.with_node(one, Behavior("New", "Other", (end,))), 0, 3)
    inside(lambda one: chart_edit.with_node(one, chart_edit.new_container("Box")), 1, 7)
    names = [outcome.name for outcome in scope.outcomes]
    inside(lambda one: chart_edit.with_outcomes(one, (*names, "more")), 0, 1)
    inside(lambda one: chart_edit.with_outcomes(one, tuple(names[::-1])), 3, 3)
    inside(
        lambda one: with_input(one, len(one.inputs), "brand_new", "int", default=""), 0, 1 + around
    )
    inside(lambda one: with_output(one, len(one.outputs), "brand_new", ""), 0, 1)
    for place, port in enumerate(scope.inputs):
        uses = sum(scope.name == flow.output_state_id for flow in scope.connections)
        inside(
            lambda one, i=place: with_input(one, i, "other", "", default=""),
            1 + uses,
            1 + uses + around,
        )
        inside(lambda one, i=place: with_input(one, i, "", "", default=""), 1 + uses, 0)
        inside(
            lambda one, i=place, p=port: with_input(one, i, p.name, "dict", default=""),
            1,
            1 + around,
        )
    for place, condition in enumerate(scope.conditions):
        pairs = tuple((when.state, when.event) for when in condition.all_of)
        put = partial(with_condition, place=place, outcome=condition.outcome)
        inside(partial(put, pairs=(*pairs, ("Other", "done"))), 0, 1)
        inside(partial(put, pairs=(("Other", "done"), *pairs[1:])), 1, 1)
        inside(partial(with_condition, place=place, outcome="", pairs=()), 2 + len(pairs), 0)


@pytest.fixture
def give(session):
    return lambda text: session.carry_out(read_command(text))


@pytest.mark.parametrize("name", ["Odd One", "One Line", "Plain", "Dos", "Marked", "Wide", "Latin"])
def test_saving_an_unchanged_chart_changes_no_byte(session, charts, give, name):
    give(f"load {name}")
    file = Path(session.chart.file)
    before = file.read_bytes()
    give("save")
    assert file.read_bytes() == before
    change = partial(chart_edit.with_parameter, node_id=session.chart.nodes[0].id, text="31")
    session.change(partial(change, name="wait_time"))
    session.undo()
    give("save")
    assert file.read_bytes() == before
    session.change(partial(change, name="wait_time"))
    give("save")
    after = file.read_bytes()
    assert len(after) == len(before)
    assert sum(a != b for a, b in zip(after, before, strict=True)) == 1
    assert give("save").endswith("nothing has changed")


def test_a_note_goes_below_the_description(session, charts, give):
    give("load Odd One")
    before = session.text
    give("note Twice is enough.")
    wanted = before.replace(
        "\t     then ends. -->", "\t     then ends.\n\t     Twice is enough. -->"
    )
    assert session.text == wanted
    give("load Plain")
    give("note First.")
    assert session.text.splitlines()[1].strip() == "<!-- First. -->"
    give("note Second.")
    assert session.chart.description == "First.\nSecond."


def test_what_is_typed_keeps_its_comments_and_line_ends(session, give):
    give("load Dos")
    before = session.text
    typed = before.replace("\r\n", "\n").replace("<!-- The end. -->", "<!-- Really\n the end. -->")
    session.retype(typed)
    assert session.text == typed.replace("\n", "\r\n")
    assert not session.is_saved
    with pytest.raises(CommandError, match="not-xml"):
        session.retype(typed + "<")
    session.undo()
    assert session.text == before


def test_a_chart_that_another_editor_has_changed_is_not_overwritten(session, give, tmp_path):
    give("load Plain")
    file = Path(session.chart.file)
    before = file.read_bytes()
    mine = before.replace(b"<connection", b"<!-- theirs --><connection") + b"<!-- theirs -->"
    session.change(partial(chart_edit.limited, node_id="B", attempts=None, timeout_s=9.0))
    file.write_bytes(mine)
    try:
        with pytest.raises(FileChangedError, match="changed elsewhere") as refused:
            give("save")
        assert file.read_bytes() == mine
        assert refused.value.now == mine.decode()
    finally:
        file.write_bytes(before)


def test_a_new_chart_does_not_take_the_place_of_another(session, give, charts):
    path = charts / "plain.xml"
    before = path.read_bytes()
    session.open(replace(chart_edit.new_chart("Plain", str(path)), description="Other."))
    with pytest.raises(CommandError, match="changed elsewhere"):
        give("save")
    session.open(chart_edit.new_chart("plain", str(charts / "new.xml")))
    with pytest.raises(CommandError, match=r"'plain' and 'Plain' of .*plain.xml become the same"):
        give("save")
    assert path.read_bytes() == before


def test_a_character_that_no_file_can_hold_is_refused(session, give):
    give("load Plain")
    before = session.text
    with pytest.raises(CommandError, match=r"U\+0007 cannot stand in an XML file"):
        give("note ring \x07")
    assert session.text == before


@pytest.mark.parametrize("name", list(chart_names()))
def test_states_that_are_grouped_leave_a_chart_without_errors(session, name):
    session.carry_out(read_command(f"load {name}"))
    chart, workspace = session.chart, session._workspace
    _, before = inspect_text(workspace, session.text, chart.file)
    nodes = [node.id for node in chart.nodes]
    for ids in {*pairwise(nodes), *((node,) for node in nodes)}:
        uses = {i: before.uses[i] for i in ids if i in before.uses}
        reads = {i: tuple(use.inputs) for i, use in uses.items()}
        writes = {i: tuple(use.outputs) for i, use in uses.items()}
        try:
            changed = grouped(chart, ids, "The Group", reads, writes)
        except CommandError:
            continue  # entered in two places
        session.change(lambda _chart, changed=changed: changed)
        _, after = inspect_text(workspace, session.text, chart.file)
        assert read_chart(session.text, "")[0] == changed
        if not before.error_count:
            assert not errors_in(after.problems), (ids, after.problems)
        session.undo()


def test_a_copy_has_its_comments_and_leaves_the_first_as_it_was(session, charts, give):
    give("load Odd One")
    before = session.text
    session.copy_as("Copied One")
    assert (session.chart.name, session.is_saved) == ("Copied One", False)
    assert session.chart.file == str(charts / "copied_one.xml")
    assert comments(session.text) == comments(before)
    gone, new = difference(tags(before), tags(session.text))
    assert all("Odd One" in tag for tag in gone), gone
    assert [tag.replace("Copied One", "Odd One") for tag in new] == gone
    for taken in ("Odd One", "Plain"):
        with pytest.raises(CommandError, match="already"):
            session.copy_as(taken)
