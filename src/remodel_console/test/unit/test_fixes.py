"""Problems at their states, with changes that correct them; copies of states; no ROS."""

import shutil
from pathlib import Path

import pytest

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart, Outcome, State
from remodel_console.core.copying import copied, outermost, pasted
from remodel_console.core.editing import change_at, matches, unplaced
from remodel_console.core.inspection import counts, fixed, located, unambiguous
from remodel_console.edge.workspace import Workspace, inspect_text

SRC = Path(__file__).parents[3]
CHARTS = Path(__file__).parents[1] / "charts"
ERRAND = (CHARTS / "errand.xml").read_text()


@pytest.fixture
def workspace(tmp_path):
    package = Path(shutil.copytree(SRC / "remodel_behaviors", tmp_path / "remodel_behaviors"))
    return Workspace(f"{package}:{SRC / 'flexbe' / 'flexbe_states'}")


@pytest.fixture
def inspect(workspace, tmp_path):
    file = str(tmp_path / "remodel_behaviors" / "charts" / "errand.xml")
    return lambda text: inspect_text(workspace, text, file)


@pytest.mark.parametrize(
    ("good", "bad", "path", "words"),
    [
        (
            '<transition event="found" target="Report"/>',
            "",
            "Search",
            "Connect 'found' to 'Report'",
        ),
        ('target="Look closer"', 'target="Look cloer"', "Search/Look", "'Look closer'"),
        ('event="exhausted"', 'event="exhausdet"', "Report", "Delete the transition 'exhausdet'"),
        ('initial="Greet"', 'initial="Gret"', "", "Start at 'Greet'"),
        ('initial="Look"', 'initial="Lok"', "Search", "Start at 'Look'"),
        ("</datamodel>\n\n  <s", '<outcome name="odd"/></datamodel>\n\n  <s', "", "outcome 'odd'"),
        (
            'name="text" value="The errand is done."/>',
            'name="text" value="a"/><param name="tex" value="b"/>',
            "Report",
            "Delete the parameter 'tex'",
        ),
    ],
)
def test_a_problem_is_at_its_state_and_its_fix_corrects_it(inspect, good, bad, path, words):
    assert good in ERRAND
    chart, inspection = inspect(ERRAND.replace(good, bad, 1))
    found = [one for one in located(inspection) if "/".join(one.path) == path]
    assert found
    fixes = [fix for one in found for fix in one.fixes if words in fix.words]
    assert fixes
    changed = change_at(chart, fixes[0].path, fixes[0].change)
    assert changed != chart
    fixed = fixes[0].words
    assert not any(fixed == fix.words for one in located_in(inspect, changed) for fix in one.fixes)


def located_in(inspect, chart):
    return located(inspect(write_chart(chart))[1])


def test_errors_with_one_correction_each_are_fixed_at_once(inspect):
    right = 'name="text" value="The errand is done."/>'
    wrong = ERRAND.replace(right, f'{right}<param name="tex" value="b"/>')
    wrong = wrong.replace('target="Look closer"', 'target="Look cloer"', 1)
    chart, inspection = inspect(wrong)
    fixes = unambiguous(located(inspection))
    assert len(fixes) >= 2
    _, after = inspect(write_chart(fixed(chart, fixes)))
    assert after.error_count == inspection.error_count - len(fixes)


def test_an_input_that_nothing_feeds_becomes_one_of_the_chart(inspect):
    text = ERRAND.replace('<input name="greeting" type="string" ext:default="hello"/>', "")
    text = text[: text.index("  <connection")] + "</statemachine>\n"
    chart, inspection = inspect(text)
    (found,) = [one for one in located(inspection) if one.path == ("Greet",)]
    assert counts([found]) == {"Greet": (1, 0)}
    assert [fix.words for fix in found.fixes] == ["Make 'data' an input of 'Errand'"]
    changed = change_at(chart, found.fixes[0].path, found.fixes[0].change)
    assert [one for one in located_in(inspect, changed) if one.path == ("Greet",)] == []


def test_copies_get_ids_of_their_own_and_lead_to_each_other():
    chart = parse_chart((CHARTS / "patrol.xml").read_bytes())
    changed, ids = pasted(chart, copied(chart, [("North",), ("South",)]))
    assert ids == ("North 2", "South 2")
    north, south = changed.nodes[2:]
    assert [t.target for t in north.transitions] == ["South 2", "finished"]
    assert [t.target for t in south.transitions] == ["North 2"]
    again, ids = pasted(changed, copied(chart, [("North",)]))
    assert ids == ("North 3",)
    assert [t.target for t in again.nodes[-1].transitions] == ["South", "finished"]


def test_a_copy_in_another_chart_leads_to_nothing_that_is_not_there():
    chart = parse_chart(ERRAND.encode())
    other = Chart("Other", "", (Outcome("failed"),))
    changed, ids = pasted(other, copied(chart, [("Report",), ("Search",), ("Search", "Look")]))
    assert ids == ("Report", "Search")
    assert [t.target for t in changed.nodes[0].transitions] == ["failed"]
    assert [t.target for t in changed.nodes[1].transitions] == ["Report"]
    assert changed.initial == "Report"


def test_what_lies_in_a_selected_container_is_not_selected_again():
    assert outermost([("A", "B"), ("A",), (), ("C",), ("C",)]) == (("A",), ("C",))


def test_states_are_found_and_places_are_dropped():
    chart = parse_chart(ERRAND.encode())
    assert matches(chart, "LOOK") == (("Search", "Look"), ("Search", "Look closer"))
    placed = Chart("A", "B", (Outcome("c", (1, 2)),), (State("B", "W", at=(3, 4)),))
    bare = Chart("A", "B", (Outcome("c"),), (State("B", "W"),))
    assert unplaced(placed) == bare
    assert placed != bare
