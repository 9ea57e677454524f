"""The report states what happened, and no text can break its page."""

import dataclasses
from pathlib import Path

from lxml import html

from remodel_planner.core.reports.net_list import net_list
from remodel_planner.core.reports.run_report import (
    AttemptReport,
    Drawing,
    Picture,
    Report,
    render_html,
    report_data,
    timeline,
)
from remodel_production.core.production import Component, Order, TerminalRef, Wire
from remodel_production.core.whole_task import whole_tasks
from remodel_supervision.core.run import Execution, Operation

TEMPLATE = (Path(__file__).parents[2] / "templates" / "report.html.j2").read_text()
COLOURS = {"InsertCable": "#ffb703"}
GOOD = Operation(
    "/Connect a/InsertCable",
    "InsertCable",
    "inserted",
    0,
    text="seated",
    ended_s=12.0,
    elapsed_s=2.0,
)
BAD = Operation(
    "/Connect a/InsertCable",
    "InsertCable",
    "failed",
    301,
    text="jammed <here>",
    ended_s=9.0,
    elapsed_s=3.0,
)


def attempted(name, *operations, placed=True, attempt=1):
    wire = Wire(
        name,
        TerminalRef("Q1", "B1"),
        TerminalRef("Q2", "T1"),
        "BU",
        section_mm2=1.5,
        source="line 7",
    )
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
        (Drawing("chart", "<svg id='drawing'/>"),),
        pictures=(Picture("overhead", "data:image/jpeg;base64,"),),
    )


def report(*attempts, cables=None, also=(), before=()):
    names = dict.fromkeys([*before, *(each.execution.wire for each in attempts), *also])
    tasks = whole_tasks((name, (cables or {}).get(name, "")) for name in names)
    order = Order(
        "house",
        "A <house>",
        "house.qet",
        (Component("Q1", "", ()),),
        wires=(),
        notes=("an assumption",),
    )
    return Report(order, tasks, 12.3, attempts, overview=(), before=frozenset(before))


def test_a_wire_that_failed_once_is_placed_but_not_at_first_pass():
    both = report(attempted("W1", GOOD), attempted("W2", BAD, GOOD))
    assert (both.placed, both.first_pass, both.failures) == (2, 1, 1)
    assert both.complete


def test_a_wire_that_was_fed_again_is_placed_once_and_has_a_row_for_each_attempt():
    failed, second = attempted("W1", BAD, placed=False), attempted("W1", GOOD, attempt=2)
    both = report(failed, second)
    assert (both.placed, both.first_pass, both.complete) == (1, 0, True)
    assert list(timeline(both.attempts, {})) == ["W1", "W1, attempt 2"]
    tree = html.fromstring(render_html(TEMPLATE, both, COLOURS))
    assert len(tree.xpath("//details[@id='W1-1' or @id='W1-2']")) == 2


def test_a_wire_that_was_never_run_makes_the_report_incomplete():
    assert not report(attempted("W1", GOOD), also=["W2"]).complete
    assert not report(attempted("W1", BAD, placed=False)).complete


def test_wires_that_an_earlier_run_has_placed_count():
    both = report(attempted("W2", GOOD), before=["W1"])
    assert (both.placed, both.first_pass, both.complete) == (2, 1, True)


def test_the_page_shows_each_wire_and_its_failures():
    page = render_html(TEMPLATE, report(attempted("W1", GOOD), attempted("W2", BAD, GOOD)), COLOURS)
    tree = html.fromstring(page)
    assert len(tree.xpath("//details[@id='W1-1' or @id='W2-1']")) == 2
    assert len(tree.xpath("//*[@id='drawing']")) == 2
    assert "error 301" in tree.text_content()
    assert "A <house>" in tree.text_content()
    assert not tree.xpath("//house | //here")
    assert "background: #ffb703" in page


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
    stopped = dataclasses.replace(
        report(attempted("W1", GOOD), also=["W2"]), stopped="the engine <died>"
    )
    page = html.fromstring(render_html(TEMPLATE, stopped, COLOURS))
    assert "stopped early: the engine <died>" in page.text_content()
    assert report_data(stopped)["stopped"] == "the engine <died>"


def test_wires_by_hand_are_listed_with_what_decides():
    line = "W9: by hand, section_mm2 is 35.0 <thick>"
    made = dataclasses.replace(report(attempted("W1", GOOD)), triage=(line,))
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


def test_a_wrong_connection_is_shown_in_the_net_list():
    one = attempted("W1", GOOD)
    wires = [dataclasses.replace(one.wire, name=name) for name in ("W1", "W2", "W3", "W4")]
    nets = net_list(
        wires,
        {
            "W1": ("Q1/B1", "Q2/T1", True),
            "W2": ("Q2/T1", "Q1/B1", True),
            "W3": ("Q1/B1", "", False),
            "W4": ("Q1/B1", "Q2/T2", True),
        },
    )
    assert [(net.wire, net.is_right) for net in nets] == [
        ("W1", True),
        ("W2", True),
        ("W3", False),
        ("W4", False),
    ]
    made = dataclasses.replace(report(one), nets=nets)
    cells = html.fromstring(render_html(TEMPLATE, made, COLOURS)).xpath(
        "//h2[.='Net list']/following-sibling::table[1]//tr[td]"
    )
    assert [[td.text_content() for td in row.xpath("td")] for row in cells] == [
        ["W1", "Q1:B1 to Q2:T1", "Q1:B1 to Q2:T1", "as designed"],
        ["W2", "Q1:B1 to Q2:T1", "Q2:T1 to Q1:B1", "as designed"],
        ["W3", "Q1:B1 to Q2:T1", "Q1:B1 to nowhere, not fixed", "wrong"],
        ["W4", "Q1:B1 to Q2:T1", "Q1:B1 to Q2:T2", "wrong"],
    ]
    assert report_data(made)["net_list"][3] == {
        "wire": "W4",
        "design": ["Q1:B1", "Q2:T1"],
        "cell": ["Q1:B1", "Q2:T2"],
        "fixed": True,
        "right": False,
    }
