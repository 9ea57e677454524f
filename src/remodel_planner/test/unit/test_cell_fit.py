"""Import, plan and cell give one answer about each wire, and about the board."""

import re
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest

from remodel_planner.commands import import_design, plan, tasks
from remodel_planner.commands.options.problem_files import design_order
from remodel_production.core.board.board import board_of
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.edge.design_files import catalogue_file, read_catalogue
from remodel_production.errors import OrderError
from remodel_states.edge.exported_tables import read_cell_limits, read_wire_materials
from remodel_supervision.ros.peers.board_message import board_message
from remodel_supervision.ros.server.work import WorkMaker
from remodel_tasks.core.decomposition.cell_fit import misfits
from remodel_tasks.core.orders.board_order import board_order
from remodel_tasks.edge.fault_file import read_faults
from remodel_work.cell.presenting import find_wire_problems
from remodel_work.edge.cell_file import read_cell
from remodel_work.layout import find_problems
from remodel_work.ros.panel_message import panel_from

PROJECTS = sorted(Path("/usr/share/qelectrotech/examples").glob("*.qet"))
PACKAGES = Path(__file__).parents[3]
LARGE_CELL = "large_cabinet"
HARNESSES = (
    PACKAGES / "remodel_tasks/examples/harness.yml",
    PACKAGES / "remodel_production/test/unit/designs/harness.yml",
    PACKAGES / "remodel_production/test/unit/designs/loom.kbl",
    PACKAGES / "remodel_production/test/unit/designs/loom.vec",
    PACKAGES / "remodel_production/test/unit/designs/seat.yml",
    PACKAGES / "remodel_production/test/unit/designs/lamp.yml",
)
QUICK = ("Projet_vierge", "tableau_domestique", "tremie_vibrante")
CELL = "two_arms_cabinet"
LIST = """Wire,From,To,Colour,Section mm2,Length mm
1,K1:1,K2:1,BK,1.5,350
2,K1:2,K2:2,BK,1.5,600
3,K1:3,K2:3,BK,16,900
4,K1:4,K2:4,BK,2.5,3600
"""


@pytest.fixture
def import_list(tmp_path, database, capsys):
    """Return a function that imports a list, and returns what is printed."""

    def imported(text, *options):
        file = tmp_path / "list.csv"
        file.write_text(text)
        assert import_design.main([str(file), "--database", database, *options]) == 0
        return capsys.readouterr().out

    return imported


def triage_of(database, name, use_case, cell=""):
    """Return an order as `import` and `plan` have it."""
    options = SimpleNamespace(use_case=use_case, cell=cell, arms=1)
    with closing(ProductionDatabase(database)) as opened:
        return design_order(opened.order(name).in_cabinet(), options)


def work_of(database, name, use_case, cell=""):
    """Return an order as a supervisor gives it to the cell."""
    with closing(ProductionDatabase(database)) as opened:
        maker = WorkMaker(
            *(opened, read_faults(), "cell", use_case),
            attended=False,
            reconnect_s=1.0,
            lease_s=1.0,
            search_s=0.0,
            cell_design=lambda: cell,
        )
        return maker.work(name, "", 0, owner=1)


def panel_message(database, name, design):
    """Return what the cell would get of an order whose board does not fit."""
    with closing(ProductionDatabase(database)) as opened:
        order = opened.order(name)
    catalogue = read_catalogue(catalogue_file())
    whole = board_order(board_of(order, catalogue), design.use_case, arms=1)
    return board_message(design.panel, whole, design.work.wires_by_hand)


def refused_by(cell, message):
    """Return the sentences with which a cell refuses a panel."""
    design, panel = read_cell(cell), panel_from(message, read_wire_materials())
    found = find_problems(
        panel, design.arms, design.takes, has_magazine=True, has_labels=design.labels
    )
    return (*found, *find_wire_problems(panel))


def assert_agreed(database, name, use_case="cabinet", cell=CELL):
    design = triage_of(database, name, use_case)
    robots = {task.name for task in design.work.tasks}
    if found := misfits(design.panel, design.takes):
        with pytest.raises(OrderError, match=f"the board does not fit cell {cell}: "):
            work_of(database, name, use_case)
        assert refused_by(cell, panel_message(database, name, design)) == found
        return
    if not robots:
        with pytest.raises(OrderError, match="no task is for the robot"):
            work_of(database, name, use_case)
        return
    work = work_of(database, name, use_case)
    assert {wire.id for wire in work.panel.wires} == robots
    assert {task.name for task in work.planner.order.tasks} == robots
    assert refused_by(cell, work.panel) == ()


@pytest.mark.parametrize(
    "project",
    [
        pytest.param(each, id=each.stem, marks=() if each.stem in QUICK else pytest.mark.slow)
        for each in PROJECTS
    ],
)
def test_import_plan_and_cell_agree_about_each_wire_of_a_project(project, database, capsys):
    order = re.sub(r"\W+", "_", project.stem)
    if import_design.main([str(project), "--database", database]) == 1:
        assert "there is nothing to wire" in capsys.readouterr().err
        return
    assert f"cell {CELL}: " in capsys.readouterr().out
    assert_agreed(database, order)


@pytest.mark.parametrize(
    "project",
    [
        pytest.param(each, id=each.stem, marks=() if each.stem == "perceuse" else pytest.mark.slow)
        for each in PROJECTS
    ],
)
def test_the_large_cell_takes_the_board_of_each_project(project, database, capsys):
    arguments = [str(project), "--order", "order", "--database", database]
    if import_design.main(arguments) == 1:
        assert "there is nothing to wire" in capsys.readouterr().err
        return
    said = capsys.readouterr().out
    small = misfits(triage_of(database, "order", "").panel, read_cell_limits(CELL))
    assert (f"; cell:={LARGE_CELL} takes it\n" in said) is bool(small)
    if small:
        with pytest.raises(OrderError, match=rf"does not fit .*; cell:={LARGE_CELL} takes it$"):
            work_of(database, "order", "cabinet")
    design = triage_of(database, "order", "cabinet", LARGE_CELL)
    assert misfits(design.panel, design.takes) == ()
    if design.work.tasks:
        work = work_of(database, "order", "cabinet", LARGE_CELL)
        assert refused_by(LARGE_CELL, work.panel) == ()


@pytest.mark.parametrize("design", HARNESSES, ids=lambda design: design.name)
def test_they_agree_about_each_wire_of_a_harness(design, database, capsys):
    arguments = [str(design), "--order", "harness", "--use-case", "harness_formboard"]
    assert import_design.main([*arguments, "--database", database]) == 0
    assert "  cell two_arms_formboard: " in capsys.readouterr().out
    assert_agreed(database, "harness", "harness_formboard", "two_arms_formboard")


def test_a_list_with_wires_that_no_robot_places_is_accepted_without_them(import_list, database):
    said = import_list(LIST, "--use-case", "cabinet")
    assert (
        f"  cell {CELL}: 1 wire for robots, 3 by hand (1 shorter than 0.42 m, 1 whose "
        "section_mm2 is above 10, 1 longer than 3 m); the board fits\n"
    ) in said
    assert (
        f"1: by hand, length is 0.35 m, 0.07 m too little; allowed: 0.42 to 3 m (cell {CELL})\n"
    ) in said
    assert_agreed(database, "list")


CROWDED = """Wire,From,To,Colour,Section mm2,Length mm,From x,From y,To x,To y
1,F1:2,K1:1,BK,1.5,620,60,300,200,80
2,F2:2,K2:1,BK,1.5,620,70,300,260,80
"""


def test_components_whose_places_overlap_are_reported_at_import(import_list, database):
    said = import_list(CROWDED)
    overlap = "components 'F1' and 'F2' overlap by 8.0 mm: places farther apart"
    assert f"; the board does not fit: {overlap}\n" in said
    assert_agreed(database, "list")


def test_a_wire_that_is_shorter_than_its_route_is_by_hand(import_list, database):
    row = "".join(f"{n},K{n}:1,K{n + 1}:2,BK,1.5,900\n" for n in range(1, 21))
    heading = "Wire,From,To,Colour,Section mm2,Length mm\n"
    said = import_list(f"{heading}{row}far,K1:3,K21:3,BK,1.5,480\n")
    assert f"  cell {CELL}: 20 wires for robots, 1 by hand (1 shorter than their routes); " in said
    assert "    far: by hand, it is 0.48 m long and its route " in said
    assert_agreed(database, "list")


def test_of_many_wires_by_hand_the_first_are_printed_and_what_lists_all(
    import_list, tmp_path, database, capsys
):
    rows = "".join(f"{n},K1:{n},K2:{n},BK,1.5,{900 if n == 1 else 350}\n" for n in range(1, 32))
    text = f"Wire,From,To,Colour,Section mm2,Length mm\n{rows}"
    said = import_list(text)
    assert said.count(": by hand, length is 0.35 m") == 20
    assert said.endswith("    and 10 more by hand (--verbose lists them)\n")
    verbose = import_list(text, "--verbose", "--order", "again")
    assert verbose.count(": by hand, length is 0.35 m") == 30
    order = ["--order", "list", "--database", database]
    assert plan.main([*order, "--output", str(tmp_path / "plan.json"), "--time-limit", "0.1"]) == 0
    assert "    and 10 more by hand (remodel tasks lists them)\n" in capsys.readouterr().out
    assert tasks.main(order) == 0
    assert capsys.readouterr().out.count(": by hand, length is 0.35 m") == 30


MIXED = """Wire,From,To,Colour,Section,Length mm
1,K1:1,K2:1,WHBU,AWG 14,900
2,K1:2,K2:2,YEGN,0.5 mm2,900
3,K1:3,K2:3,DB,AWG 18,900
4,K1:4,K2:4,puce,AWG 26,900
5,K1:6,K2:6,RED,1.5 mm2,900
6,K1:6,K2:7,RED,1.5 mm2,900
7,K1:6,K2:8,RED,1.5 mm2,900
8,K1:9,K2:9,ours,1.5 mm2,900
J1,K1:9,K1:10,JUMPER,,
"""
MAPPING = """format: remodel-wire-list-1
name: list
columns: {wire: Wire, from: From, to: To, colour: Colour, section: Section, length: Length mm}
colours: {ours: XX}
"""


def test_any_section_and_colour_and_full_terminals_are_judged_alike(
    import_list, tmp_path, database
):
    mapping = tmp_path / "mapping.yaml"
    mapping.write_text(MAPPING)
    said = import_list(MIXED, "--mapping", str(mapping), "--use-case", "cabinet")
    assert (
        f"  cell {CELL}: 5 wires for robots, 3 by hand (1 thinner than 2.5 mm, 1 at terminals "
        "that are full, 1 of no known colour); the board fits\n"
    ) in said
    assert "1 colour not known, such as line 5: colour 'puce' is no known colour, BK taken" in said
    assert "1 left out: it is a jumper or bar, a part for a person to set" in said
    assert "7: by hand, K1:6 takes 2 wires, and has 3: it needs a bridge or a bar" in said
    assert "8: by hand, its colour is 'XX'; allowed: BK BN RD" in said
    assert_agreed(database, "list")


def test_a_spring_that_takes_more_than_robots_push_with_is_for_a_person(import_list, database):
    rows = "1,K1:1,X1:1,BK,4,600\n2,K1:2,X1:2,BK,2.5,600\n"
    import_list(f"Wire,From,To,Colour,Section mm2,Length mm\n{rows}")
    with closing(ProductionDatabase(database)) as opened:
        order = opened.order("list").in_cabinet()
    blocks = tuple(replace(each, kind="push-in block") for each in order.components)
    options = SimpleNamespace(use_case="cabinet", cell="", arms=1)
    work = design_order(replace(order, components=blocks), options).work
    assert [task.name for task in work.tasks] == ["2"]
    (stiff,) = work.by_hand
    assert stiff.task == "1"
    assert "lets a ferrule in with 15 N, and robots push with 14 N" in stiff.reason


def test_a_users_own_cell_decides(import_list, tmp_path, database, capsys):
    cell = tmp_path / "mine.yaml"
    cell.write_text(
        "name: mine\n"
        "takes: {plate: {x: 0.2, y: 0.2}, devices: 1, wire_length: {least: 0.3, most: 9}, "
        "wire_diameter: {least: 0.001, most: 0.02}}\n"
    )
    said = import_list(LIST, "--cell", str(cell))
    assert "  cell mine: 3 wires for robots, 1 by hand (1 whose section_mm2 is above 10)" in said
    assert "; the board does not fit: the plate's size in x is 0." in said
    assert "2 devices are on the plate, 1 too many; allowed: 1: a cell without labels" in said
    cell.write_text("name: mine\n")
    for wrong, words in (
        (str(cell), "missing: takes"),
        ("nowhere", f"no such cell or file; there are: cabinet, .*{CELL}"),
    ):
        other = ["--order", "other", "--database", database, "--cell", wrong]
        assert import_design.main([str(tmp_path / "list.csv"), *other]) == 1
        assert re.search(words, capsys.readouterr().err)
        with pytest.raises(OrderError, match="no order other"):
            ProductionDatabase(database).order("other")


def test_the_limits_that_are_planned_with_are_those_of_the_cell():
    for name in ("two_arms_cabinet", "two_arms_formboard", "one_panda", LARGE_CELL):
        assert read_cell_limits(name) == read_cell(name).takes
