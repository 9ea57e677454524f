"""What the order desk makes of preferences, plans and file names; no ROS, no planner."""

import json
import threading
from dataclasses import replace

import msgspec
import pytest
import yaml

from remodel_console.core.order_desk import (
    FIELD_HINTS,
    KINDS,
    NOT_USED,
    WIRE_FIELDS,
    ListColumns,
    chosen_wires,
    entries,
    entry_words,
    gantt_height,
    gantt_plot,
    has_entries,
    new_document,
    new_entry,
    read_document,
    task_times,
    violated_words,
    with_clicked,
    with_entry,
    without_entry,
    write_document,
)
from remodel_console.edge.order_drafts import OrderDrafts, plain_file_name, read_findings
from remodel_console.edge.processes import LIMIT_S, Finished, PlannerProcess
from remodel_console.errors import CommandError
from remodel_console.web.order_panels import can_be_adopted
from remodel_run.findings import NoPlan, Plan
from remodel_run.rehearsal import Failure, Forecast, Share, TriedChange, WireForecast

BEFORE = next(kind for kind in KINDS if kind.fields == ("pick", "before", "weight"))
TEXTS = {"pick": "{colour: [BU, 'BK']}", "before": "all", "weight": "3"}
DOCUMENT = """format: remodel-preferences-1
zones:
  B: [200, 280]
prefer:
  - {name: first, pick: {colour: [BU, BK]}, before: all, weight: 3}
require:
  - {name: away, arm: R, out_of: B, while: operator in B}
"""


def action(kind, arm, start_s, duration_s, wire="", target=""):
    times = {"start_s": start_s, "duration_s": duration_s}
    return {"action": kind, "arm": arm, "wire": wire, "target": target, **times}


PLAN = {
    "cost": 5,
    "makespan_s": 9.0,
    "penalties": {},
    "arms": ["L", "R"],
    "features": ["colour"],
    "segments": [],
    "search": "done",
    "actions": [
        action("tool", "R", 0.0, 2.0, target="thin"),
        action("pick", "L", 0.0, 1.0, "W1"),
        action("handover", "L", 1.0, 1.0, "W1", "R"),
        action("insert", "R", 2.0, 3.0, "W1", "b"),
        action("pick", "L", 3.0, 1.0, "<b>W2"),
        action("insert", "L", 4.0, 5.0, "<b>W2", "a"),
    ],
}


def test_entries_are_added_and_removed():
    entry = new_entry(BEFORE, " first ", TEXTS)
    assert entry == {
        "name": "first",
        "pick": {"colour": ["BU", "BK"]},
        "before": "all",
        "weight": 3,
    }
    document = with_entry(new_document(), BEFORE.list_name, entry)
    assert entries(document, "prefer") == (entry,)
    assert has_entries(document)
    assert entry_words(entry) == "pick: {colour: [BU, BK]}, before: all, weight: 3"
    assert without_entry(document, "prefer", entry) == new_document()
    assert without_entry(new_document(), "prefer", entry) == new_document(), "removed meanwhile"
    assert not has_entries(new_document())


def test_every_field_has_a_hint_and_wires_are_clicked_only_into_such_a_field():
    assert {field for kind in KINDS for field in kind.fields} == set(FIELD_HINTS)
    assert set(WIRE_FIELDS) <= set(FIELD_HINTS)


@pytest.mark.parametrize(
    ("name", "changed", "reason"),
    [
        (" ", {}, "name: give the entry a name"),
        ("a", {"weight": ""}, "weight: fill it in, such as: cost of each"),
        ("a", {"pick": "{colour: "}, "pick: line 1: is no YAML"),
        ("a", {"pick": "[&x [1], *x]"}, "pick: aliases"),
        ("a", {"pick": "!!python/name:os.system x"}, "pick: line 1: is no YAML"),
        ("a", {"pick": "[" * 10_000}, "pick: .* YAML"),
    ],
)
def test_an_entry_that_cannot_be_is_refused_with_its_field(name, changed, reason):
    with pytest.raises(CommandError, match=reason):
        new_entry(BEFORE, name, TEXTS | changed)


@pytest.mark.parametrize(
    ("text", "clicked", "after"),
    [
        ("", ["W1"], "[W1]"),
        (" \n", ["W1", "W2"], "[W1, W2]"),
        ("W1", ["W2"], "[W1, W2]"),
        ("[W1, W2]", ["W1"], "[W2]"),
        ("[W1, W2]", ["W2", "W3"], "[W1, W2, W3]"),
        ("[W1, W2, W3]", ["W3", "W1"], "[W2]"),
        ("W1", ["W1"], ""),
        ("", ["7"], "['7']"),
        ("", ["all"], "[all]"),
        ("", ["on: [x", "é"], "['on: [x', é]"),
    ],
)
def test_a_click_on_wires_fills_them_in_or_takes_them_away(text, clicked, after):
    assert with_clicked(text, clicked) == after
    before = chosen_wires(text)
    assert set(chosen_wires(after)) in (set(before) | set(clicked), set(before) - set(clicked))


@pytest.mark.parametrize("text", ["all", "{colour: BU}", "{colour: ", "7", "[W1, 7]"])
def test_a_click_keeps_what_a_person_has_typed(text):
    assert chosen_wires(text) is None
    with pytest.raises(CommandError, match=r"is no list of wires; clear the field to click"):
        with_clicked(text, ["W1"])


def test_many_wires_stay_in_one_line():
    wires = [f"W{n}" for n in range(2000)]
    text = with_clicked("", wires)
    assert "\n" not in text
    assert list(chosen_wires(text)) == wires


def test_a_document_is_read_and_written():
    document = read_document(DOCUMENT)
    assert write_document(document) == DOCUMENT.replace("B: [200, 280]", "B:\n  - 200\n  - 280")
    assert read_document(write_document(document)) == document
    assert read_document(" \n") == new_document()


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("prefer: []", "begin with `format: remodel-preferences-1`"),
        ("[1]", "begin with"),
        ("format: remodel-preferences-1\nrequire: {a: 1}", "`require` holds a list"),
        ("format: remodel-preferences-1\nprefer: [1]", "`prefer` holds a list"),
        ("format: remodel-preferences-1\n  x: [", "line 2: is no YAML"),
    ],
)
def test_what_is_no_document_is_refused(text, reason):
    with pytest.raises(CommandError, match=reason):
        read_document(text)


def test_a_plan_has_two_lanes_for_each_arm_and_no_markup():
    plan = read_findings(json.dumps(PLAN), Plan)
    assert [(each.task, each.arm, each.start_s, each.end_s) for each in task_times(plan)] == [
        ("W1", "L", 0.0, 2.0),
        ("W1", "R", 2.0, 5.0),
        ("<b>W2", "L", 3.0, 9.0),
    ]
    plot = gantt_plot(plan)
    assert plot["yAxis"]["data"] == ["L tasks", "L", "R tasks", "R"]
    bars = {series["name"]: series["data"] for series in plot["series"]}
    assert bars["change tool"] == [[3, 0.0, 2.0, "", "change tool thin: 0.0 to 2.0 s"]]
    assert bars["insert"][1][4] == "insert &lt;b&gt;W2 a: 4.0 to 9.0 s"
    assert bars["task"][2][4].startswith("&lt;b&gt;W2")
    assert gantt_height(plan) > 4 * 30


def test_a_cable_is_one_task_of_a_plan():
    actions = [
        action("pick", arm, at, 1.0, wire)
        for arm, wire, at in (("L", "C1.1", 0), ("R", "W1", 0), ("L", "C1.2", 5), ("L", "W2", 9))
    ]
    cables = {"C1": ["C1.1", "C1.2"]}
    plan = read_findings(json.dumps({**PLAN, "actions": actions, "cables": cables}), Plan)
    assert [(each.words, each.arm, each.start_s, each.end_s) for each in task_times(plan)] == [
        ("C1: C1.1, C1.2", "L", 0.0, 6.0),
        ("W1", "R", 0.0, 1.0),
        ("W2", "L", 9.0, 10.0),
    ]


def test_an_answer_that_is_none_of_the_planner_is_refused():
    assert read_findings('{"error": "e", "conflicts": []}', NoPlan) == NoPlan("e")
    for text in ("", "{}", '{"error": 7}', "[1]"):
        with pytest.raises(CommandError, match="of one version"):
            read_findings(text, NoPlan)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("loom.csv", "loom.csv"),
        ("../../etc/passwd", "passwd"),
        ("C:\\designs\\a b.qet", "a b.qet"),
        ("-rf", "rf"),
        (".draft", "draft"),
        ("a\n\x1b[31m.csv", "a[31m.csv"),
        ("", "design"),
        ("..", "design"),
    ],
)
def test_a_file_keeps_its_name_and_nothing_else(text, name):
    assert plain_file_name(text) == name


class Planner:
    """A planner whose commands end at once; they print PLAN unless another value is given.

    Attributes:
        given: words, database and time limit of each command [s].
    """

    def __init__(self, **printed):
        self.given, self._printed = [], printed

    def run(self, words, folder, database, report, limit_s):
        self.given.append((words, database, limit_s))
        return Finished(0, json.dumps(self._printed.get(words[0], PLAN)), "")

    def end_in(self, folder):
        pass


def test_drafts_are_removed_by_people_alone(tmp_path):
    drafts = OrderDrafts(tmp_path / "drafts", Planner())
    made = [drafts.new("a.csv") for _ in range(30)]
    with pytest.raises(CommandError, match="there are 30 drafts; remove one"):
        drafts.new("b.csv")
    drafts.remove(made[3].key)
    assert not made[3].folder.exists()
    assert drafts.get(made[3].key) is None
    assert drafts.new("b.csv") in drafts.all()
    drafts.end()
    assert not (tmp_path / "drafts").exists()


COLUMNS = {
    "headings": ["Ab", "An", "Q", ""],
    "rows": [["K1:1", "X1:1", "1", ""]],
    "fields": ["from", "to", "section", "wire", "shade"],
    "columns": {"section": "Q"},
    "units": {"section": "mm2", "length": "mm", "position": "mm"},
    "separator": "tab",
    "terminal_separator": ":",
}


def test_columns_become_a_mapping_by_choosing_what_they_mean():
    columns = read_findings(json.dumps(COLUMNS), ListColumns)
    assert columns.choices["from"] == "First end: component and terminal"
    assert columns.choices["shade"] == "shade", "a field of a newer planner"
    assert [columns.meaning(each) for each in columns.headings[:3]] == ["", "", "section"]
    ends = ({}, {"from": "Ab"}, {"from": "Ab", "to_component": "An"})
    assert [replace(columns, columns=each).has_ends for each in ends] == [False, False, True]
    pins = {"wire": "Ab", "component": "An", "terminal": "Q"}
    assert replace(columns, columns=pins).has_ends
    chosen = {"Ab": "from", "An": "to", "Q": NOT_USED}
    assert yaml.safe_load(columns.mapping(chosen, {"section": "awg"}, "-")) == {
        "format": "remodel-wire-list-1",
        "columns": {"from": "Ab", "to": "An"},
        "units": {"section": "awg", "length": "mm", "position": "mm"},
        "separator": "tab",
        "terminal_separator": "-",
    }
    with pytest.raises(CommandError, match="'Ab' and 'An' are both 'Wire'"):
        columns.mapping({"Ab": "wire", "An": "wire"}, {}, "")


def test_a_violated_preference_is_shown_on_its_wires():
    violations = [
        {"reason": "blue first", "wires": ["W1", "<b>W2"], "words": "W1 before W2"},
        *({"reason": "", "wires": ["W1"], "words": f"other {n}"} for n in range(3)),
    ]
    plan = read_findings(json.dumps({**PLAN, "violations": violations}), Plan)
    assert violated_words(plan, ["<b>W2"]) == "blue first: W1 before W2"
    assert violated_words(plan, ["W1"]) == "blue first: W1 before W2; other 0; other 1; and 1 more"
    tasks = gantt_plot(plan)["series"][0]["data"]
    assert tasks[2][3] == "⚠ <b>W2"
    assert "(blue first: W1 before W2)" in tasks[2][4]


class HeldPlanner:
    """A planner whose commands report a stage, and last until they are ended."""

    def __init__(self):
        self.begun, self.ended = threading.Event(), threading.Event()
        self.commands = []

    def run(self, words, folder, database, report, limit_s):
        self.commands.append(words[0])
        report("2/4: laying out the board")
        self.begun.set()
        assert self.ended.wait(30)
        raise CommandError(f"`planner {words[0]}` was ended")

    def end_in(self, folder):
        self.ended.set()


def test_what_a_draft_does_is_shown_and_cancelled_at_once(tmp_path):
    planner = HeldPlanner()
    drafts = OrderDrafts(tmp_path / "drafts", planner)
    draft = drafts.new("loom.csv")
    failed = []

    def read():
        with pytest.raises(CommandError) as refused:
            draft.read()
        failed.append(str(refused.value))

    thread = threading.Thread(target=read)
    thread.start()
    assert planner.begun.wait(30)
    assert (draft.now.doing, draft.now.stage) == ("reading the file", "2/4: laying out the board")
    assert draft.cancel() == "cancelled"
    thread.join(30)
    assert failed == ["cancelled"]
    assert (draft.now.doing, draft.now.error) == ("", "cancelled")
    assert planner.commands == ["import"], "nothing else begins"


@pytest.mark.parametrize(("tasks", "is_planned"), [(3000, True), (3001, False)])
def test_a_long_order_is_planned_only_when_a_person_says_so(tmp_path, tasks, is_planned):
    account = {"unit": "lines", "connections": tasks, "assumptions": [], "left_out": []}
    imported = {
        "order": "a",
        "title": "a",
        "counts": {"wires": tasks},
        "wires_in_cabinet": tasks,
        "account": account,
        "lengths": {},
        "triage": {"use_case": "cabinet", "robot": [f"W{n}" for n in range(tasks)]},
    }
    planner = Planner(**{"import": imported})
    draft = OrderDrafts(tmp_path / "drafts", planner).new("a.csv")
    draft.read()
    commands = [words[0] for words, *_ in planner.given]
    assert ("plan" in commands, draft.now.is_planned) == (is_planned, is_planned)
    draft.plan()
    assert draft.now.is_planned


def forecast(changes=(), adopted=None, picture=""):
    """Return the forecast of an order whose only wire jams, with these changes tried of it."""
    share = Share(0.5, 0.2, 0.8)
    tried = tuple(TriedChange(text, share) for text in changes)
    jammed = Failure("InsertCable", "INSERTION_JAMMED", "end a stopped 4.0 mm deep")
    wire = WireForecast("W1", 10, share, share, jammed, 60.0, picture, tried)
    return Forecast((wire,), 0.5, (60.0, 50.0, 70.0), adopted)


def test_a_stored_order_is_rehearsed_in_the_production_database(tmp_path):
    found = forecast(picture="abc.png")
    planner = Planner(rehearse=msgspec.to_builtins(found))
    draft = OrderDrafts(tmp_path / "drafts", planner).new("a.csv")
    draft.now = replace(draft.now, stored_as="house", use_case="cabinet")
    assert draft.rehearse("sqlite:///p", seeds=10, wires=3) == "rehearsed: 50% without a failure"
    ((words, database, limit_s),) = planner.given
    assert words[:6] == ["rehearse", "house", "--seeds", "100-109", "--wires", "3"]
    assert words[6:8] == ["--use-case", "cabinet"] and words[-1] == "--json"
    assert database == "sqlite:///p" and limit_s > 10 * LIMIT_S
    assert draft.now.forecast.failing == found.wires
    assert draft.picture("abc.png").parent.name == "pictures"
    assert draft.picture("../../orders.sqlite") == draft.picture("orders.sqlite")
    draft.rehearse("sqlite:///p", seeds=10, wires=3, adopts=True)
    assert "--adopt" in planner.given[1][0] and "--adopt" not in words


@pytest.mark.parametrize(
    ("changes", "adopted", "expected"),
    [((), None, False), (("8 cm longer",), None, True), (("8 cm longer",), (), False)],
)
def test_only_changes_that_are_not_adopted_yet_can_be(changes, adopted, expected):
    assert can_be_adopted(forecast(changes, adopted)) == expected
    assert not can_be_adopted(None)


def test_two_drafts_of_one_file_have_two_names(tmp_path):
    drafts = OrderDrafts(tmp_path / "drafts", HeldPlanner())
    names = [drafts.new(file).name for file in ("a.csv", "b.csv", "a.csv")]
    assert names == ["a.csv", "b.csv", "a.csv (2)"]
    drafts.remove(drafts.all()[-1].key)
    assert drafts.new("a.csv").name == "a.csv (3)", "no name is given twice"


def test_a_command_reports_its_stages_and_keeps_its_errors(tmp_path):
    script = 'echo "stage 1/2: reading" >&2; echo "import: wrong" >&2; echo printed; exit 3'
    stages = []
    process = PlannerProcess(("sh", "-c", script))
    assert process.run([], tmp_path, "", stages.append) == Finished(3, "printed\n", "import: wrong")
    assert stages == ["1/2: reading"]


def test_a_command_is_ended_with_all_that_it_has_started(tmp_path):
    process = PlannerProcess(("sh", "-c", 'echo "stage 1/1: on" >&2; sleep 600 & wait', "sh"))
    with pytest.raises(CommandError, match="`remodel import` was ended"):
        process.run(["import"], tmp_path, "", lambda stage: process.end_in(tmp_path))
