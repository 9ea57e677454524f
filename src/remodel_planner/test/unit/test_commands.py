"""The command lines refuse bad input with a reason, and leave nothing behind."""

import json
from contextlib import closing
from itertools import groupby
from pathlib import Path
from types import SimpleNamespace

import pytest
from qet_projects import BREAKER, LAMP, element, project, wire
from wire_lists import workbook

from remodel_planner.commands import (
    charts,
    check,
    draw,
    explain,
    export,
    import_design,
    layout,
    plan,
    tasks,
)
from remodel_planner.commands.runs import run_order
from remodel_planner.core.run_report import Report
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.errors import OrderError
from remodel_supervision.ros.server.work import WorkMaker
from remodel_tasks.core.problem.problem import End
from remodel_tasks.edge.fault_file import read_faults
from remodel_tasks.edge.use_case_files import use_case_folder

DESIGNS = Path(__file__).parents[3] / "remodel_production/test/unit/designs"
PANELS = Path(__file__).parents[3] / "remodel_sim/config"
HARNESS = Path(__file__).parents[3] / "remodel_tasks/examples/harness.yml"
DESIGN = Path("/usr/share/qelectrotech/examples/tableau_domestique.qet")


def refused_import(file, database, capsys):
    """Import what can't be imported; return what is said, the order being nowhere."""
    assert import_design.main([str(file), "--order", "house", "--database", database]) == 1
    with pytest.raises(OrderError, match="no order house"):
        ProductionDatabase(database).order("house")
    return capsys.readouterr().err


def test_a_design_is_imported_once(database, capsys):
    arguments = [str(DESIGN), "--order", "house", "--database", database]
    assert import_design.main(arguments) == 0
    assert "58 wires lie on the plate" in capsys.readouterr().out
    assert import_design.main(arguments) == 1
    assert "has an order house already: give another name" in capsys.readouterr().err


def test_a_wire_that_no_robot_can_lay_is_by_hand_and_the_rest_is_planned(
    tmp_path, database, capsys
):
    file, plan_file = tmp_path / "loom.csv", tmp_path / "plan.json"
    file.write_text("From,To,Section mm2\nK1:1,X1:1,1\nK1:2,X1:2,35\nK1:3,X1:3,0.05\n")
    place = ["--database", database, "--use-case", "automotive_formboard"]
    said = []
    for command, arguments in (
        (import_design, [str(file), "--order", "loom"]),
        (plan, ["--order", "loom", "--output", str(plan_file), "--time-limit", "0.1"]),
        (tasks, ["--order", "loom"]),
    ):
        assert command.main([*arguments, *place]) == 0
        said.append(capsys.readouterr().out)
    for text in said:
        assert "  tasks for the robot: 1, by hand: 2\n" in text
        assert "    W2: by hand, section_mm2 is 35.0, and must be a number from 0.13" in text
        assert "    W3: by hand, section_mm2 is 0.05, and must be a number from 0.13" in text
    assert check.main([str(plan_file), "--order", "loom", *place]) == 0


CABLES = """connectors: {X1: {pincount: 8}, X2: {pincount: 6}, X3: {pincount: 6}, X4: {pincount: 3}}
cables:
  C1: {wirecount: 3, gauge: 0.5 mm2}
  C2: {wirecount: 3, gauge: 0.5 mm2}
  C3: {wirecount: 3, gauge: 0.5 mm2}
  W1: {category: bundle, wirecount: 2, gauge: 1.5 mm2}
connections:
  - [X1: [1-3], C1: [1-3], X2: [1-3]]
  - [X1: [4-6], C2: [1-3], X3: [1-3]]
  - [X1: [7, 8], W1: [1, 2], X3: [4, 5]]
  - [X4: [1-3], C3: [1-3], X2: [4-6]]
"""


@pytest.mark.parametrize("arms", ["1", "2"])
def test_a_cable_is_one_task_from_its_file_to_the_plan(arms, tmp_path, database, capsys):
    file, plan_file = tmp_path / "loom.yml", tmp_path / "plan.json"
    file.write_text(CABLES)
    order = ["--order", "loom", "--database", database, "--arms", arms]
    assert import_design.main([str(file), *order]) == 0
    counts = (
        "  tasks for the robot: 5, by hand: 0\n"
        "    3 are cables of 9 cores, placed one after another by one arm\n"
    )
    assert counts in capsys.readouterr().out
    assert tasks.main(order) == 0
    said = capsys.readouterr().out
    heads = [line.partition(":")[0] for line in said.splitlines() if not line.startswith(" ")]
    assert sorted(heads) == ["C1", "C2", "C3", "W1.1", "W1.2"]
    assert "\nC2: cable of 3 cores, " in said
    assert "\n  C2.1: " in said
    assert counts in said
    assert plan.main([*order, "--output", str(plan_file), "--moves", "20000"]) == 0
    assert counts in capsys.readouterr().out
    assert plan.main([*order, "--output", str(plan_file), "--moves", "20000", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["cables"]["C2"] == ["C2.1", "C2.2", "C2.3"]
    assert printed["triage"]["cables"] == printed["cables"]
    assert sorted(printed["triage"]["robot"]) == sorted(heads)
    assert (printed["split_cables"], printed["penalties"]["cable"]) == ([], 0)
    picks = [each for each in printed["actions"] if each["action"] == "pick"]
    runs = [
        cable
        for arm in printed["arms"]
        for cable, _ in groupby(p["wire"].partition(".")[0] for p in picks if p["arm"] == arm)
        if cable in printed["cables"]
    ]
    assert sorted(runs) == ["C1", "C2", "C3"], "no arm takes up a cable twice, nor do both arms"
    assert check.main([str(plan_file), *order]) == 0


def test_a_cable_by_hand_is_one_task_too(tmp_path, database, capsys):
    file = tmp_path / "loom.yml"
    file.write_text(CABLES.replace("C2: {wirecount: 3, gauge: 0.5", "C2: {wirecount: 3, gauge: 50"))
    order = ["--order", "loom", "--database", database]
    assert import_design.main([str(file), *order]) == 0
    said = capsys.readouterr().out
    assert "  tasks for the robot: 4, by hand: 1\n    2 are cables of 6 cores, " in said
    assert "    C2 (C2.1 C2.2 C2.3): by hand, section_mm2 is 50.0, and must be " in said
    assert import_design.main([str(file), "--order", "again", *order[2:], "--json"]) == 0
    (one,) = json.loads(capsys.readouterr().out)["triage"]["by_hand"]
    assert (one["task"], one["wires"]) == ("C2", ["C2.1", "C2.2", "C2.3"])


def test_a_cable_that_requirements_tear_apart_is_planned_and_named(tmp_path, database, capsys):
    file, plan_file = tmp_path / "loom.yml", tmp_path / "plan.json"
    file.write_text(CABLES)
    order = ["--order", "loom", "--database", database, "--arms", "1"]
    assert import_design.main([str(file), *order]) == 0
    apart = tmp_path / "apart.yaml"
    apart.write_text(
        "format: remodel-preferences-1\nrequire:\n"
        "  - {name: first, route: C1.1, before: W1.1}\n"
        "  - {name: then, route: W1.1, before: C1.2}\n"
    )
    wanted = ["--preferences", str(apart), "--output", str(plan_file), "--moves", "20000"]
    assert plan.main([*order, *wanted]) == 0
    said = capsys.readouterr().out
    assert "\ncable C1 is in 2 parts: " in said
    assert " by robot_1; order constraints keep its cores apart\n" in said
    late = tmp_path / "late.yaml"
    late.write_text(
        "format: remodel-preferences-1\nprefer:\n"
        "  - {name: late, pick: C1.2, before: C1.1, weight: 1}\n"
    )
    assert plan.main([*order, *wanted, "--preferences", str(late), "--json"]) == 0
    printed = capsys.readouterr()
    assert {"reason": "late", "wires": ["C1.2", "C1.1"]}.items() <= next(
        each for each in json.loads(printed.out)["violations"] if each["reason"]
    ).items()
    assert printed.err.splitlines() == [
        "stage 1/3: reading the order",
        "stage 2/3: making a first plan",
        "stage 3/3: searching for a better plan",
    ]
    assert check.main([str(plan_file), *order, *wanted[:2]]) == 0


PORCH = project(
    ([element(BREAKER, "q", "Q1"), element(LAMP, "h", "H1")], [wire("q", "b1", "h", "l")])
).decode()
NONE_FOR_ROBOTS = {
    "feeder.csv": (
        "From,To,Section mm2\nK1:1,X1:1,35\n",
        "  tasks for the robot: 0, by hand: 1\n    W1: by hand, section_mm2",
        "no task is for the robot: all 1 are by hand, such",
    ),
    "porch.qet": (
        PORCH,
        "  tasks for the robot: 0, by hand: 0\n    1 wire leaves the plate and is no task of the ",
        "no wire has both its ends in the cabinet",
    ),
}


@pytest.mark.parametrize("name", NONE_FOR_ROBOTS)
def test_an_order_without_a_task_for_robots_is_accepted_by_every_command(
    name, tmp_path, database, capsys
):
    file, plan_file = tmp_path / name, str(tmp_path / "plan.json")
    text, line, refusal = NONE_FOR_ROBOTS[name]
    file.write_text(text)
    order = ["--order", "feeder", "--database", database, "--use-case", "automotive_formboard"]
    for command, arguments in (
        (import_design, [str(file)]),
        (tasks, []),
        (plan, ["--output", plan_file, "--time-limit", "0.1"]),
        (check, [plan_file]),
        (charts, [plan_file, "--output", str(tmp_path / "charts")]),
        (explain, [plan_file]),
        (draw, [plan_file, "--output", str(tmp_path / "plan.svg")]),
        (export, [plan_file, "--format", "planbench", "--output", str(tmp_path)]),
    ):
        assert command.main([*arguments, *order]) == 0
        said = capsys.readouterr().out
        if command in (import_design, tasks, plan):
            assert line in said
    assert json.loads(Path(plan_file).read_text())["actions"] == []
    with closing(ProductionDatabase(database)) as opened:
        cell = cell_with(opened, order[-1])
        with pytest.raises(OrderError, match=refusal):
            cell.work("feeder", "", 0, owner=1)


def cell_with(database, use_case=""):
    """Return what makes the work of a cell whose supervisor has this default use case."""
    return WorkMaker(
        *(database, read_faults(), "cell", use_case),
        attended=False,
        reconnect_s=1.0,
        lease_s=1.0,
        search_s=0.0,
    )


def test_paths_of_a_harness_are_those_of_the_panel_that_the_cell_builds(database):
    import_design.main([str(HARNESS), "--order", "harness", "--database", database])
    with closing(ProductionDatabase(database)) as opened:
        work = cell_with(opened, "harness_formboard").work("harness", "", 2, owner=1)
    routes = {wire.id: [(p.x, p.y) for p in wire.route] for wire in work.panel.wires}
    assert len(work.planner.order.tasks) == 2
    for task in work.planner.order.tasks:
        assert [pose[:2] for pose in dict(task.values)["path"]] == [
            pytest.approx(point) for point in routes[task.name]
        ]


def test_a_run_is_resumed_with_all_its_tasks_though_others_of_the_order_are_by_hand(database):
    import_design.main([str(DESIGN), "--order", "house", "--database", database])
    with closing(ProductionDatabase(database)) as opened:
        cell = cell_with(opened)
        begun = [task.name for task in cell.work("house", "", 2, owner=1).planner.order.tasks]
        assert begun == ["W3", "W7"], "the first two that are not by hand"
        resumed = cell.work("house", "cabinet", begun, owner=1)
        assert [task.name for task in resumed.planner.order.tasks] == begun
        with pytest.raises(OrderError, match="house: W1, which a run began with, is no task for"):
            cell.work("house", "cabinet", [*begun, "W1"], owner=1)


def test_preferences_have_wires_by_hand_and_say_at_which_end_one_begins(database, capsys):
    import_design.main([str(DESIGN), "--order", "house", "--database", database])
    with closing(ProductionDatabase(database)) as opened:
        before = {t.name: t for t in cell_with(opened).work("house", "", 0, 1).planner.order.tasks}
        first = before["W7"].first
        other = "b" if first is End.A else "a"
        requirements = [
            {"name": "too stiff", "by_hand": ["W3"]},
            {"name": "as rehearsed", "begin": "W7", "at": other},
        ]
        opened.set_preferences(
            "house", {"format": "remodel-preferences-1", "require": requirements}
        )
        work = cell_with(opened).work("house", "", 0, owner=1)
        after = {task.name: task for task in work.planner.order.tasks}
        assert before.keys() - after.keys() == {"W3"}
        assert [wire.reason for wire in work.by_hand if wire.name == "W3"] == [
            "required: too stiff"
        ]
        assert (first, after["W7"].first) == (first, End[other.upper()])
        ways = [[pose[:2] for pose in dict(each["W7"].values)["path"]] for each in (before, after)]
        assert ways[0] == ways[1][::-1]
        work.planner.plan(list(after))
        opened.set_preferences(
            "house",
            {"format": "remodel-preferences-1", "require": [{"name": "x", "by_hand": "W99"}]},
        )
        with pytest.raises(OrderError, match="preferences require something of W99"):
            cell_with(opened).work("house", "", 0, owner=1)
        opened.set_preferences(
            "house", {"format": "remodel-preferences-1", "require": requirements}
        )
    capsys.readouterr()
    assert tasks.main(["--order", "house", "--database", database]) == 0
    assert "W3: by hand, required: too stiff" in capsys.readouterr().out


def test_an_order_is_done_by_the_use_case_for_such_designs_unless_one_is_named(database):
    for name, file in (("house", DESIGN), ("harness", HARNESS)):
        import_design.main([str(file), "--order", name, "--database", database])
    with closing(ProductionDatabase(database)) as opened:
        cell, other = cell_with(opened), cell_with(opened, "harness_formboard")
        chosen = [
            made.work(order, asked, 5, owner=1).planner.use_case.name
            for made, order, asked in (
                (cell, "house", ""),
                (cell, "harness", ""),
                (other, "harness", ""),
                (other, "harness", "automotive_formboard"),
            )
        ]
    assert chosen == ["cabinet", "automotive_formboard", "harness_formboard", chosen[1]]


def test_preferences_come_with_the_order_and_must_fit_it(tmp_path, database, capsys):
    file = tmp_path / "preferences.yaml"
    preference = "{name: first, pick: W3, before: %s, weight: 2}"
    arguments = [str(DESIGN), "--order", "house", "--database", database]
    arguments += ["--preferences", str(file)]
    file.write_text(f"format: remodel-preferences-1\nprefer: [{preference % 'W9999'}]\n")
    assert import_design.main(arguments) == 1
    said = capsys.readouterr().err
    assert f"{file}: " in said
    assert "W9999" in said
    contradiction = "[{name: up, route: W3, before: W7}, {name: down, route: W7, before: W3}]"
    file.write_text(f"format: remodel-preferences-1\nrequire: {contradiction}\n")
    assert import_design.main(arguments) == 1
    said = capsys.readouterr().err
    assert f"`up` ({file}, require[0])" in said
    assert f"`down` ({file}, require[1])" in said
    file.write_text(f"format: remodel-preferences-1\nprefer: [{preference % 'W7'}]\n")
    assert import_design.main(arguments) == 0
    store = ProductionDatabase(database)
    assert store.preferences("house")["prefer"][0]["before"] == "W7"
    assert "InsertCable" in [ability.name for ability in store.abilities()]
    store.close()


def test_an_account_and_a_plan_are_printed_for_programs(tmp_path, database, capsys):
    file, plan_file = tmp_path / "loom.csv", tmp_path / "plan.json"
    file.write_text("From,To,Section mm2,Shelf\nK1:1,X1:1,1,a\nK1:2,X1:2,35,b\nK1:3,X1:3,2.5,c\n")
    place = ["--database", database, "--use-case", "automotive_formboard", "--json"]
    assert import_design.main([str(file), "--order", "loom", *place]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["order"], said["counts"]["wires"]) == ("loom", 3)
    assert said["account"]["unused_columns"] == [
        {"source": "column 'Shelf'", "reason": "its heading is not known"}
    ]
    assert {"cabinet", "medical_hoses"} <= set(said["use_cases"])
    triage = said["triage"]
    assert (triage["robot"], triage["by_hand"][0]["task"]) == (["W1", "W3"], "W2")
    assert "characteristics.task.section_mm2" in triage["by_hand"][0]["reason"]
    planning = ["--order", "loom", "--output", str(plan_file), "--moves", "100", *place]
    assert plan.main(planning) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["triage"] == triage
    picked = [action["wire"] for action in said["actions"] if action["action"] == "pick"]
    assert sorted(picked) == ["W1", "W3"]
    ends = [action["start_s"] + action["duration_s"] for action in said["actions"]]
    assert max(ends) == pytest.approx(said["makespan_s"])
    assert "section_mm2" in said["features"]
    file = tmp_path / "preferences.yaml"
    entries = ["{name: up, route: W1, before: W3}", "{name: down, route: W3, before: W1}"]
    document = f"format: remodel-preferences-1\nrequire: [{', '.join(entries)}]\n"
    file.write_text(document)
    assert plan.main([*planning, "--preferences", str(file)]) == 1
    printed = capsys.readouterr()
    said = json.loads(printed.out)
    (conflict,) = said["conflicts"]
    assert [(each["entry"]["name"], each["index"]) for each in conflict] == [("up", 0), ("down", 1)]
    assert printed.err == f"stage 1/3: reading the order\nplan: {said['error']}\n"


def test_a_placement_says_what_is_in_the_door(tmp_path, database, capsys):
    file, placement = tmp_path / "feeder.csv", tmp_path / "placement.yaml"
    file.write_text("Wire,From,To\n7,K1:1,S1:13\n8,K1:2,X1:1\n")
    placement.write_text("devices: {S1: door}\n")
    arguments = [str(file), "--database", database, "--placement", str(placement), "--verbose"]
    assert import_design.main(arguments) == 0
    out = capsys.readouterr().out
    assert "1 wire lies on the plate, 1 leaves it" in out
    assert "7: by hand, it leaves the plate, S1:13 is in the door" in out
    placement.write_text("devices: {S1: roof}\n")
    assert import_design.main(arguments) == 1
    assert f"{placement}: line 1: devices: S1: 'roof' found" in capsys.readouterr().err


def test_a_list_with_headings_of_its_own_needs_its_mapping(tmp_path, database, capsys):
    file, mapping = tmp_path / "mine.csv", tmp_path / "mine.yaml"
    file.write_text("Hier;Dort\nA:1;B:1\n")
    assert "a CSV file with other headings needs --mapping" in refused_import(
        file, database, capsys
    )
    assert import_design.main([str(file), "--database", database, "--print-mapping"]) == 0
    assert '  # not used: "Hier"\n' in capsys.readouterr().out
    printing = [str(file), "--database", database, "--print-mapping", "--json"]
    assert import_design.main(printing) == 0
    columns = json.loads(capsys.readouterr().out)
    assert (columns["headings"], columns["rows"]) == (["Hier", "Dort"], [["A:1", "B:1"]])
    assert (columns["columns"], columns["fields"][0]) == ({}, "from")
    mapping.write_text("format: remodel-wire-list-1\ncolumns: {from: Hier, to: Da}\n")
    arguments = [str(file), "--order", "mine", "--database", database, "--mapping", str(mapping)]
    assert import_design.main(arguments) == 1
    assert "the mapping's headings: hier, da" in capsys.readouterr().err
    mapping.write_text("format: remodel-wire-list-1\ncolumns: {from: Hier, to: Dort}\n")
    assert import_design.main(arguments) == 0
    mapping.write_text("columns: {}")
    assert import_design.main([*arguments[:2], "more", *arguments[3:]]) == 1
    assert f"{mapping}: line 1: format none found" in capsys.readouterr().err


def test_a_format_can_be_forced(tmp_path, database, capsys):
    file = tmp_path / "list.txt"
    file.write_text("From,To\nA:1,B:1\n")
    arguments = [str(file), "--database", database, "--verbose", "--format"]
    assert import_design.main([*arguments, "qet"]) == 1
    assert "is no XML" in capsys.readouterr().err
    assert import_design.main([*arguments, "csv"]) == 0
    assert "line 2: colour not given, BK taken" in capsys.readouterr().out


def test_a_file_that_is_larger_than_any_design_is_refused(tmp_path, database, capsys):
    file = tmp_path / "large.csv"
    with file.open("wb") as stream:
        stream.truncate(100_000_001)
    assert f"{file}: is larger than 100 MB" in refused_import(file, database, capsys)


def test_the_board_of_an_order_is_drawn(tmp_path, database, capsys):
    import_design.main([str(DESIGN), "--order", "house", "--database", database])
    drawing = tmp_path / "house.svg"
    arguments = ["house", "--output", str(drawing), "--database", database]
    assert layout.main(arguments) == 0
    assert "58 wires" in capsys.readouterr().out
    assert drawing.read_text().startswith("<svg")
    assert layout.main(["hosue", *arguments[1:]]) == 1
    assert "layout: the database has no order hosue; it has: house" in capsys.readouterr().err


@pytest.mark.parametrize(("name", "design"), [("household", DESIGN), ("harness", HARNESS)])
def test_the_panel_of_an_order_is_written_for_the_cell(name, design, tmp_path, database, capsys):
    import_design.main([str(design), "--order", name, "--database", database])
    panel = tmp_path / f"{name}.yaml"
    assert layout.main([name, "--panel", str(panel), "--database", database]) == 0
    assert f"panel: {panel}" in capsys.readouterr().out
    # If it differs because the board does: write the file again by this command.
    assert panel.read_text() == (PANELS / f"{name}.yaml").read_text()
    with pytest.raises(SystemExit):
        layout.main([name, "--database", database])
    assert "give --output FILE, --panel FILE, or both" in capsys.readouterr().err


def test_an_order_is_planned_by_its_preferences(tmp_path, database, capsys):
    preferences = tmp_path / "preferences.yaml"
    preference = "{name: first, pick: W7, before: W3, weight: 5}"
    preferences.write_text(
        f"format: remodel-preferences-1\nweights: {{heavy: 0}}\nprefer: [{preference}]\n"
    )
    stored = ["--order", "house", "--database", database]
    import_design.main([str(DESIGN), *stored, "--preferences", str(preferences)])
    made = str(tmp_path / "plan.json")
    assert plan.main([*stored, "--output", made, "--time-limit", "0.1"]) == 0
    assert check.main([made, *stored]) == 0
    assert len(json.loads(Path(made).read_text())["actions"]) >= 52 * 5
    capsys.readouterr()
    assert plan.main(["--output", made, "--order", "hosue", "--database", database]) == 1
    assert "has no order hosue; it has: house" in capsys.readouterr().err
    assert plan.main(["--output", made]) == 1
    assert "give either the file of a problem or order, or --order NAME" in capsys.readouterr().err
    preferences.write_text("format: remodel-preferences-1\nprefer: [{pick: W77777, before: W3}]\n")
    assert plan.main([*stored, "--output", made, "--preferences", str(preferences)]) == 1
    assert f"{preferences}: " in capsys.readouterr().err


@pytest.mark.parametrize("name", ["loom.kbl", "harness.yml", "eplan.csv"])
def test_every_imported_order_is_worked_with_by_every_command(name, tmp_path, database, capsys):
    stored = ["--order", "mine", "--database", database]
    assert import_design.main([str(DESIGNS / name), *stored]) == 0
    made, folder = str(tmp_path / "plan.json"), tmp_path / "out"
    for arms in ("1", "2"):
        options = [*stored, "--arms", arms]
        assert plan.main([*options, "--output", made, "--time-limit", "0.05"]) == 0
        assert check.main([made, *options]) == 0
        assert explain.main([made, *options]) == 0
        assert draw.main([made, *options, "--output", str(tmp_path / "plan.svg")]) == 0
        assert tasks.main(options) == 0
        assert charts.main([*options, made, "--output", str(folder)]) == 0
        numeric = ["--format", "planbench", "--output", str(folder)]
        assert export.main([*options, made, *numeric]) == 0
        capsys.readouterr()
        assert check.main([str(folder / "problem.json"), str(folder / "plan.json")]) == 0
        assert json.loads(capsys.readouterr().out)["valid"]
        refused = 0 if arms == "1" or name == "eplan.csv" else 1  # cabinets have one arm
        assert export.main([*options, "--format", "pddl", "--output", str(folder)]) == refused
    written = list(folder.glob("*.xml"))
    assert len(written) == len(json.loads((folder / "problem.json").read_text())["wires"])


def test_the_use_case_of_an_order_is_chosen_and_refused_by_name(
    tmp_path, database, capsys, monkeypatch
):
    monkeypatch.setenv("REMODEL_USE_CASES", str(tmp_path))
    stored = ["--order", "mine", "--database", database]
    import_design.main([str(DESIGN), *stored])
    assert tasks.main([*stored, "--use-case", "cabinet"]) == 0
    assert "Insert a" in capsys.readouterr().out
    own = (use_case_folder() / "cabinet.yaml").read_text().replace("name: cabinet", "name: ours")
    before, designs = own.split("\ndesigns:")
    (tmp_path / "ours.yaml").write_text(before + designs[designs.index("\n\n") :])
    assert tasks.main([*stored, "--use-case", "ours"]) == 1
    assert "tasks: order mine: use case ours takes no" in capsys.readouterr().err
    assert tasks.main([*stored, "--use-case", "hosen"]) == 1
    error = capsys.readouterr().err
    assert "no use case hosen; there are automotive_formboard, " in error
    assert f"(searched: {tmp_path}, /" in error
    assert tasks.main([str(DESIGNS / "loom.kbl"), "--use-case", "cabinet"]) == 1
    assert "--use-case is for --order NAME" in capsys.readouterr().err


CUT_LIST = workbook(List=[["Article", "Qty", "Length"], ["FLRY 0.5", 100, 250]])


@pytest.mark.parametrize(
    ("content", "reasons"),
    [
        (None, ["cannot be read: No such file or directory"]),
        (b"<project>\n  <diagram>\n</project>", ["line 3"]),
        (CUT_LIST, ["no sheet of the workbook has the headings", "how wires are cut"]),
    ],
    ids=["missing", "no XML", "a cut list"],
)
def test_what_is_no_design_is_refused_with_its_file_and_the_reason(
    content, reasons, tmp_path, database, capsys
):
    file = tmp_path / "design"
    if content is not None:
        file.write_bytes(content)
    said = refused_import(file, database, capsys)
    assert said.startswith(f"import: {file}: ")
    assert all(reason in said for reason in reasons)


def test_an_unknown_order_is_refused_before_anything_starts(database, capsys):
    assert run_order.main(["nowhere", "--database", database]) == 1
    assert "the database has no order nowhere; it has: none" in capsys.readouterr().err


def test_an_order_that_ended_is_reported_though_its_report_cannot_be_written(
    tmp_path, database, capsys, monkeypatch, full_disk
):
    assert import_design.main([str(DESIGN), "--order", "house", "--database", database]) == 0
    ended = SimpleNamespace(number=7, run=lambda wires, **options: None)
    order = ProductionDatabase(database).order("house")
    report = Report(order, (), 1.0, (), ())
    for name, stands_for in (
        ("require_master", lambda wait_s: None),
        ("join_interruptibly", lambda name: None),
        ("RunFollower", lambda log, order: ended),
        ("order_report", lambda *_: report),
    ):
        monkeypatch.setattr(run_order, name, stands_for)
    with full_disk():
        code = run_order.main(["house", "--database", database, "--output", str(tmp_path)])
    printed = capsys.readouterr()
    assert code == (0 if report.complete else 1)
    assert "explanation:" in printed.out
    assert "run: the report cannot be written: [Errno" in printed.err


def test_no_wires_is_wrong_usage(database, capsys):
    with pytest.raises(SystemExit) as exit_info:
        run_order.main(["house", "--wires", "0", "--database", database])
    assert exit_info.value.code == 2
    assert "--wires must be at least 1, found 0" in capsys.readouterr().err


def test_files_before_a_harness_and_modules_are_read_for_the_formats_that_have_them(
    tmp_path, database, capsys
):
    common, main, wires = (tmp_path / name for name in ("common.yml", "main.yml", "list.csv"))
    common.write_text("templates: [&wire {wirecount: 1, gauge: 1 mm2}]\n")
    main.write_text(
        "connectors: {X: {pincount: 1}}\ncables: {W1: *wire}\n"
        "connections: [[{X.A: 1}, {W1: 1}, {X.B: 1}]]\n"
    )
    wires.write_text("From,To\nA:1,B:1\n")
    place = ["--database", database, "--verbose"]
    assert import_design.main([str(main), "--prepend", str(common), *place]) == 0
    said = capsys.readouterr().out
    assert "lines 1 to 1 are those of common.yml; its own begin at line 2" in said
    assert import_design.main([str(wires), "--prepend", str(common), *place]) == 1
    assert import_design.main([str(wires), "--module", "M1", *place]) == 1
    assert import_design.main([str(wires), "--variant", "A", *place]) == 1
    assert import_design.main([str(DESIGNS / "loom.kbl"), "--module", "M1", *place]) == 1
    assert import_design.main([str(DESIGNS / "loom.kbl"), "--variant", "A", *place]) == 1
    said = capsys.readouterr().err.splitlines()
    assert [line.rsplit(": ", 1)[-1] for line in said[1:3]] == [
        f"{option} is for files of format kbl and vec; this is one of csv"
        for option in ("--module", "--variant")
    ]
    assert "no module or harness configuration M1: omit --module" in said[3]
    assert "no variant code A: omit --variant" in said[4]
