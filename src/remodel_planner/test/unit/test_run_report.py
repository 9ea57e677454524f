"""The report states what happened, and no text can break its page."""

from dataclasses import replace
from pathlib import Path

import pytest
from lxml import html

from remodel_planner.core.net_list import FoundEnd, FoundWire, net_list
from remodel_planner.core.run_report import (
    AttemptReport,
    Drawing,
    Picture,
    Report,
    render_html,
    report_data,
    summary_lines,
    timeline,
)
from remodel_production.core.production import Component, Order, TerminalRef, Wire
from remodel_rehearsal.core.forecast import forecast
from remodel_run.progress import Sums
from remodel_run.rehearsal import Trial
from remodel_run.whole_task import whole_tasks
from remodel_supervision.core.run import Execution, Operation

TEMPLATE = (Path(__file__).parents[2] / "templates" / "report.html.j2").read_text()
COLOURS = {"InsertCable": "#ffb703"}
GOOD = Operation(
    "/Connect a/InsertCable", "InsertCable", "inserted", 0, "seated", ended_s=12.0, elapsed_s=2.0
)
BAD = replace(
    GOOD, outcome="failed", error_code=301, text="jammed <here>", ended_s=9.0, elapsed_s=3.0
)


def attempted(name, *operations, placed=True, attempt=1, result=""):
    ends = TerminalRef("Q1", "B1"), TerminalRef("Q2", "T1")
    wire = Wire(name, *ends, "BU", section_mm2=1.5, source="line 7")
    outcome = "finished" if placed else "failed"
    execution = Execution(
        name,
        f"Place {name}",
        attempt,
        outcome,
        placed=placed,
        started_s=5.0,
        ended_s=15.0,
        operations=operations,
    )
    return AttemptReport(
        wire,
        0.3,
        execution,
        result or ("placed" if placed else "NOT placed (failed)"),
        (Drawing("chart", "<svg id='drawing'/>"),),
        pictures=(Picture("overhead", "data:image/jpeg;base64,"),),
    )


def report(*attempts, cables=None, also=(), before=(), sums=None):
    names = dict.fromkeys([*before, *(each.execution.wire for each in attempts), *also])
    tasks = whole_tasks((name, (cables or {}).get(name, "")) for name in names)
    parts = (Component("Q1", "", ()),)
    order = Order("house", "A <house>", "house.qet", parts, wires=(), notes=("an assumption",))
    return Report(
        order,
        tasks,
        12.3,
        attempts,
        overview=(),
        before=frozenset(before),
        sums=sums or summed(attempts, before, tasks),
    )


def summed(attempts, before, tasks):
    """Return the sums that the supervisor keeps of such a run."""
    placed = {each.execution.wire for each in attempts if each.execution.placed}
    first = [each.execution for each in attempts if each.execution.attempt == 1]
    passes = sum(each.placed and not each.failures for each in first)
    whole = [task for task in tasks if {*before, *placed}.issuperset(task.wires)]
    old = [task for task in whole if set(before).issuperset(task.wires)]
    return Sums(
        tasks=len(tasks),
        done_before=len(old),
        done=len(whole) - len(old),
        open=len(tasks) - len(whole),
        tried=len(placed),
        first_passes=passes,
        recovered=len(placed) - passes,
        taken_s=sum(each.execution.cell_s for each in attempts),
    )


def test_a_wire_that_failed_once_is_placed_but_not_at_first_pass():
    both = report(attempted("W1", GOOD), attempted("W2", BAD, GOOD))
    assert (both.placed, both.sums.first_passes, both.failures) == (2, 1, 1)
    assert both.complete


def test_a_wire_that_was_fed_again_is_placed_once_and_has_a_row_for_each_attempt():
    failed, second = attempted("W1", BAD, placed=False), attempted("W1", GOOD, attempt=2)
    both = report(failed, second)
    assert (both.placed, both.sums.first_passes, both.complete) == (1, 0, True)
    assert list(timeline(both.attempts, {})) == ["W1", "W1, attempt 2"]
    tree = html.fromstring(render_html(TEMPLATE, both, COLOURS))
    assert len(tree.xpath("//details[@id='W1-1' or @id='W1-2']")) == 2


def test_a_wire_that_was_never_run_makes_the_report_incomplete():
    assert not report(attempted("W1", GOOD), also=["W2"]).complete
    assert not report(attempted("W1", BAD, placed=False)).complete


def test_wires_that_an_earlier_run_has_placed_count():
    both = report(attempted("W2", GOOD), before=["W1"])
    assert (both.placed, both.sums.first_passes, both.complete) == (2, 1, True)


def test_the_page_shows_each_wire_and_its_failures():
    page = render_html(TEMPLATE, report(attempted("W1", GOOD), attempted("W2", BAD, GOOD)), COLOURS)
    tree = html.fromstring(page)
    assert len(tree.xpath("//details[@id='W1-1' or @id='W2-1']")) == 2
    assert len(tree.xpath("//*[@id='drawing']")) == 2
    assert "error 301" in tree.text_content()
    assert "A <house>" in tree.text_content()
    assert not tree.xpath("//house | //here")
    assert "background: #ffb703" in page


def test_the_page_names_what_became_of_each_attempt():
    discarded = attempted("W1", placed=False, attempt=2, result="discarded")
    made = report(attempted("W1", BAD, placed=False), discarded)
    page = html.fromstring(render_html(TEMPLATE, made, COLOURS))
    for path in ("//tr/td[5][@class]", "//details/summary/span[1]"):
        shown = [(each.get("class"), each.text) for each in page.xpath(path)]
        assert shown == [("bad", "NOT placed (failed)"), ("good", "discarded")]


def test_a_cable_is_one_task_shown_before_its_cores():
    made = report(
        attempted("W1", GOOD),
        attempted("C1.1", GOOD, placed=False),
        attempted("C1.1", GOOD, attempt=2),
        attempted("C1.2", GOOD, placed=False),
        attempted("W2", GOOD),
        cables={"C1.1": "C1", "C1.2": "C1"},
    )
    page = html.fromstring(render_html(TEMPLATE, made, COLOURS))
    line = "Cable C1: 1 of 2 cores placed"
    rows = [row.text_content().split("\n")[0].strip() for row in page.xpath("//table[1]//tr")]
    assert [row for row in rows if row.startswith("Cable")] == [line]
    assert rows.index(line) == 2
    assert "2 of 3tasks done" in page.text_content()
    data = report_data(made)
    assert (data["cables"], data["tasks_done"]) == ([line], 2)
    assert (data["placed"], data["planned"]) == (3, 4)
    assert data["tasks"][1] == {"name": "C1", "wires": ["C1.1", "C1.2"]}


def test_a_run_that_stopped_early_says_why():
    stopped = replace(report(attempted("W1", GOOD), also=["W2"]), stopped="the engine <died>")
    page = html.fromstring(render_html(TEMPLATE, stopped, COLOURS))
    assert "stopped early: the engine <died>" in page.text_content()
    assert report_data(stopped)["stopped"] == "the engine <died>"


def test_wires_by_hand_are_listed_with_what_decides():
    line = "W9: by hand, section_mm2 is 35.0 <thick>"
    made = replace(report(attempted("W1", GOOD)), triage=(line,))
    page = html.fromstring(render_html(TEMPLATE, made, COLOURS))
    assert page.xpath("//h2[contains(., 'by hand')]/following-sibling::ul[1]/li")[0].text == line
    assert report_data(made)["triage"] == [line]


def test_the_data_says_the_same():
    data = report_data(report(attempted("W2", BAD, GOOD, placed=False)))
    assert data["complete"] is False
    (wire,) = data["wires"]
    assert wire["insertions"] == 2
    assert wire["failures"] == ["InsertCable, error 301: jammed <here>"]
    assert data["notes"] == ["an assumption"]


def test_bars_lie_where_the_operations_were():
    first, second = timeline((attempted("W2", BAD, GOOD),), COLOURS)["W2"]
    assert (first.x, first.width, first.failed) == (10.0, 30.0, True)
    assert (second.x, second.width, second.failed) == (50.0, 20.0, False)
    assert first.colour == "#ffb703"


def found(a, b, *, fixed=(True, True), duct_length_m=0.0, in_ducts=0.0):
    """Return a wire whose ends are in terminals, such as "Q1:B1"; empty: in none."""
    ends = [
        FoundEnd(TerminalRef(*at.split(":")) if at else None, is_fixed)
        for at, is_fixed in zip((a, b), fixed, strict=True)
    ]
    return FoundWire(*ends, duct_length_m=duct_length_m, in_ducts=in_ducts)


def read_back(*attempts, wires=4):
    """Return a report of four wires: as designed, turned round, in a wrong terminal, missing."""
    one = attempted("W1", GOOD)
    designed = [replace(one.wire, name=f"W{n + 1}") for n in range(wires)]
    nets = net_list(
        designed,
        [wire.name for wire in designed],
        {
            "W1": found("Q1:B1", "Q2:T1", duct_length_m=0.6, in_ducts=1.0),
            "W2": found("Q2:T1", "Q1:B1", duct_length_m=0.2, in_ducts=0.5),
            "W3": found("Q1:B1", "Q2:T2"),
        },
    )
    return replace(report(*(attempts or (one,))), nets=nets)


def built(made):
    """Return the last section of the page."""
    page = html.fromstring(render_html(TEMPLATE, made, COLOURS))
    (heading,) = page.xpath("//h2[@id='built']")
    assert not heading.xpath("following::h2"), "the report ends with it"
    return heading.xpath("following-sibling::*")


def test_the_report_ends_with_each_connection_beside_the_designs():
    parts = built(read_back())
    (table,) = (part for part in parts if part.tag == "table")
    cells = [[td.text_content() for td in row.xpath("td")] for row in table.xpath(".//tr[td]")]
    assert cells == [
        ["W1", "Q1:B1 to Q2:T1", "Q1:B1 to Q2:T1", "as designed", "0.60 m", "100 %"],
        ["W2", "Q1:B1 to Q2:T1", "Q2:T1 to Q1:B1", "as designed", "0.20 m", "50 %"],
        ["W3", "Q1:B1 to Q2:T1", "Q1:B1 to Q2:T2", "wrong", "", ""],
        ["W4", "Q1:B1 to Q2:T1", "nowhere", "missing", "", ""],
    ]
    text = " ".join(part.text_content() for part in parts)
    assert "differs from the design's in 2 of 4 wires" in text
    assert "W3 wrong: designed Q1:B1 to Q2:T1, in Q2:T2 instead of Q2:T1" in text
    assert "W4 missing: designed Q1:B1 to Q2:T1, no piece of it in the cell" in text
    assert "87.5 %of the wires' routes in ducts" in text


def test_an_equal_net_list_is_said_to_be_equal():
    made = read_back()
    text = built(replace(made, nets=made.nets[:2]))[1].text_content()
    assert "equal to the design's: 2 of 2 wires" in text


def test_a_cell_without_ground_truth_leaves_figures_and_says_so():
    made = replace(report(attempted("W1", BAD, GOOD)), unread="a <real> cell")
    text = " ".join(part.text_content() for part in built(made))
    assert "Not read back: a <real> cell." in text
    assert "0 of 1wires placed at the first attempt" in text
    assert "1wire recovered" in text
    assert report_data(made)["unread"] == "a <real> cell"


def test_the_data_has_each_connection_beside_the_designs():
    data = report_data(read_back())
    assert data["in_ducts"] == 0.875
    turned, wrong = data["net_list"][1:3]
    assert turned == {
        "wire": "W2",
        "design": ["Q1:B1", "Q2:T1"],
        "cell": ["Q2:T1", "Q1:B1"],
        "fixed": [True, True],
        "verdict": "as designed",
        "difference": "",
        "duct_length_m": 0.2,
        "in_ducts": 0.5,
    }
    assert (wrong["verdict"], wrong["difference"]) == ("wrong", "in Q2:T2 instead of Q2:T1")
    assert wrong["in_ducts"] is None


def test_first_insertions_and_recovered_wires_are_counted_over_all_attempts():
    at = {"component_id": "Q1", "terminal_id": "B1"}
    seated = replace(GOOD, parameters=tuple(at.items()))
    jammed = replace(BAD, parameters=tuple(at.items()))
    other = replace(GOOD, parameters=(("component_id", "Q2"), ("terminal_id", "T1")))
    made = report(
        attempted("W1", seated, other),
        attempted("W2", jammed, placed=False),
        attempted("W2", seated, other, attempt=2),
        attempted("W3", jammed, placed=False),
    )
    assert made.insertions == (3, 5)
    assert (made.sums.first_passes, made.sums.recovered) == (1, 1)


def test_the_summary_is_what_the_report_ends_with():
    made = replace(read_back(), wall_s=20.0, simulated_s=30.0)
    assert list(summary_lines(made)) == [
        "1 of 1 wire placed, 1 without a failed operation; 0 failed operations; "
        "10 s in the cell, 20 s on the clock",
        "1 of 1 end seated by the first insertion; 0 wires recovered",
        "30 s simulated in 20 s, real-time factor 1.50",
        "net list: 2 of 4 wires as designed, 1 wrong, 1 missing",
        "  W3 wrong: designed Q1:B1 to Q2:T1, in Q2:T2 instead of Q2:T1",
        "  W4 missing: designed Q1:B1 to Q2:T1, no piece of it in the cell",
        "routes: below the rims at 87.5% of their length in ducts",
    ]


def test_the_summary_lists_the_first_differences():
    lines = list(summary_lines(read_back(wires=40)))
    assert [line for line in lines if line.startswith("  ")][-1] == "  and 30 more"
    assert len(lines) < 16


def test_the_summary_says_why_nothing_was_read_back():
    made = replace(report(attempted("W1", GOOD)), unread="no ground truth")
    assert list(summary_lines(made))[-1] == "net list: not read back: no ground truth"


def test_what_was_rehearsed_stands_beside_what_happened():
    trials = [Trial(wire, seed, True, 1) for wire in ("W1", "W2", "W9") for seed in range(9)]
    both = replace(
        report(attempted("W1", GOOD), attempted("W2", BAD, GOOD)),
        forecast=forecast(["W1", "W2", "W9"], trials),
    )
    assert [(each.wire, each.was_at_once) for each in both.predicted] == [
        ("W1", True),
        ("W2", False),
    ]
    (right, wrong) = (each.at_once.mean for each in both.predicted)
    assert both.brier_score == pytest.approx(((1 - right) ** 2 + wrong**2) / 2)
    tree = html.fromstring(render_html(TEMPLATE, both, COLOURS))
    rows = tree.xpath("//h2[@id='predicted']/following-sibling::table[1]//tr[td]")
    assert [row.xpath("td")[2].text_content() for row in rows] == [
        "at the first attempt",
        "after a failure",
    ]
    assert report_data(both)["brier_score"] == pytest.approx(both.brier_score, abs=1e-4)


def test_without_a_rehearsal_nothing_is_predicted():
    tree = html.fromstring(render_html(TEMPLATE, report(attempted("W1", GOOD)), COLOURS))
    assert tree.xpath("//h2[@id='predicted']") == []
