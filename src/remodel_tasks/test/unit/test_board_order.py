"""Imported designs become orders of use cases: cabinets and harnesses, planned and charted."""

from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from boards import order
from wire_lists import CATALOGUE, MAPPINGS

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.check.check import check_chart
from remodel_production.core.board.board import board_of
from remodel_production.core.imports.formats import built_in_formats, format_of, import_design
from remodel_production.core.production import (
    TWISTED,
    Cable,
    Component,
    Node,
    Order,
    Role,
    Side,
    Terminal,
    TerminalRef,
    Wire,
    sealed_kind,
)
from remodel_production.errors import InfeasibleError, InstanceError, OrderError
from remodel_run.findings import ByHand
from remodel_tasks.core.decomposition.cell_fit import triaged
from remodel_tasks.core.decomposition.preparation import prepare
from remodel_tasks.core.orders.board_order import board_order, kind_of
from remodel_tasks.core.problem.defects import require_sound
from remodel_tasks.core.problem.problem import End
from remodel_tasks.core.task_charts.planned_tasks import planned_tasks
from remodel_tasks.core.use_case.model import DesignKind
from remodel_tasks.edge.anytime_planner import plan_problem
from remodel_tasks.edge.use_case_files import VARIABLE, find_use_case, read_use_case, use_case_for
from remodel_tasks.errors import UseCaseError

DESIGNS = Path(__file__).parents[3] / "remodel_production/test/unit/designs"
FORMATS = built_in_formats(MAPPINGS)
QET = Path("/usr/share/qelectrotech/examples")
NAMES = ("industrial", "tableau_domestique", "Projet_vierge")
CABINET, FORMBOARD, BRANCHES = map(
    find_use_case, ("cabinet", "automotive_formboard", "branched_harness")
)
GRIPPERS = read_use_case(Path(__file__).parents[1] / "use_cases" / "grippers.yaml")


def imported(file):
    data = file.read_bytes()
    form = format_of(data, FORMATS)
    return import_design(data, form, file.stem, file.name, CATALOGUE).order


def loom():
    return imported(DESIGNS / "loom.kbl")


def project(name):
    return imported(QET / f"{name}.qet")


def work(stored, use_case=GRIPPERS, arms=2):
    return board_order(board_of(stored, CATALOGUE), use_case, arms)


def problem(stored, use_case=GRIPPERS, arms=2):
    return prepare(work(stored, use_case, arms), use_case).preferred.problem


@pytest.mark.parametrize("arms", [1, 2])
@pytest.mark.parametrize("name", NAMES)
def test_every_project_is_a_sound_planning_problem(name, arms):
    found = problem(project(name), arms=arms)
    require_sound(found)
    assert len(found.wires) == len(project(name).in_cabinet().wires)
    assert [arm.name for arm in found.arms] == ["robot_1", "robot_2"][:arms]


def test_a_harness_is_routed_clip_by_clip_and_handed_over():
    made = work(loom(), FORMBOARD)
    task = next(task for task in made.tasks if task.name == "11")
    assert task.routes[0].segments == ("S1", "S2")
    assert task.meeting_mm is not None
    wire = next(wire for wire in loom().wires if wire.name == "11")
    names = [clip.name for clip in loom().clips_of(wire)]
    assert names
    assert [clip.name for clip in task.routes[0].clips] == names
    assert problem(loom(), FORMBOARD).wire["11"].handover.position_mm == task.meeting_mm


def test_a_harness_is_mounted_trunk_first_then_each_branch_from_its_fork():
    made = work(loom(), BRANCHES, arms=1)
    tasks = {task.name: task for task in made.tasks}
    assert {name: task.terminals for name, task in tasks.items()} == {
        "trunk": ("X2:trunk", "X1:trunk"),
        "X3": ("X3 begin:X3", "X3:X3"),
    }
    assert [clip.name for clip in tasks["trunk"].routes[0].clips] == ["CL3", "CL2", "CL1"]
    assert tasks["X3"].routes[0].clips == ()  # the clip at the fork holds the trunk
    assert tasks["X3"].slot_mm == tasks["X3"].routes[0].path_mm[0]
    assert tasks["X3"].characteristics == {"part": "branch", "level": 1}
    assert made.components["X3 begin"] == {"kind": "root"}
    assert [(under.before, under.after) for under in made.unders] == [("trunk", "X3")]
    prepare(made, BRANCHES)


def test_connectors_that_share_a_node_have_branches_of_their_own():
    harness = loom()
    moved = tuple(replace(c, node="N2") if c.name == "X3" else c for c in harness.components)
    tasks = {t.name: t for t in work(replace(harness, components=moved), BRANCHES).tasks}
    assert set(tasks) == {"trunk", "N4", "X3"}
    assert tasks["N4"].terminals == ("N4 begin:N4", "N4 end:N4")
    assert tasks["X3"].routes[0].segments == ()


def test_what_has_no_branches_is_refused():
    with pytest.raises(OrderError, match="industrial has no segments that say them; choose"):
        work(project("industrial"), BRANCHES)
    harness = loom()
    for node in ("", "N9"):
        loose = tuple(replace(c, node=node) if c.name == "X3" else c for c in harness.components)
        apart = replace(harness, components=loose, nodes=(*harness.nodes, Node("N9", None)))
        with pytest.raises(OrderError, match="loom: X3 sit at no node of the harness's segments"):
            work(apart, BRANCHES)


def test_tools_zones_and_characteristics_follow_from_sections_and_places():
    one = problem(order(("Q1:B1", "Q2:T1"), ("Q1:B2", "Q2:T2")), arms=1)
    first, arm = one.wires[0], one.arms[0]
    assert (first.tool, first.heavy, first.preferred_arm) == ("medium_gripper", True, None)
    said = dict(first.characteristics)
    assert (said["section_mm2"], said["colour"], said["cable"]) == (2.5, "BK", "")
    ends = [one.terminal[name].position_mm for name in first.terminals]
    assert said["left_end_mm"] == min(x for x, _ in ends)
    assert said["length_mm"] > max(abs(a - b) for a, b in zip(*ends, strict=True))
    assert all(arm.reaches(terminal.position_mm) for terminal in one.terminals)
    assert {wire.slot_mm[1] for wire in one.wires} == {arm.station_mm[1]}


def test_terminals_whose_names_read_the_same_stay_apart():
    refs = (TerminalRef("A:1", "2"), TerminalRef("A", "1:2"))
    components = tuple(
        Component(ref.component, "", (Terminal(ref.terminal, Side.TOP),)) for ref in refs
    )
    wires = (Wire("W1", *refs, "", 7.0, "test"),)
    made = work(Order("test", "", "", components, wires=wires))
    assert [terminal.name for terminal in made.terminals] == ["A:1:2", "A:1:2#2"]
    assert made.tasks[0].characteristics["section_mm2"] == 7.0
    assert "colour" not in made.tasks[0].characteristics


def test_wires_whose_names_differ_in_capitals_alone_have_tasks_of_their_own():
    found = order(("Q1:B1", "Q2:T1"), ("Q1:B2", "Q2:T2"))
    wires = tuple(replace(w, name=n) for w, n in zip(found.wires, ("l1", "L1"), strict=True))
    assert [task.name for task in work(replace(found, wires=wires)).tasks] == ["l1", "L1#2"]


AWAY = ByHand("W1", ("W1",), "it leaves the plate, M1:T1 is outside")


def test_wires_that_leave_the_cabinet_are_no_tasks():
    made = work(order(("Q1:B1", "M1:T1"), ("Q1:B2", "Q2:T2"), outside=("M1",)))
    assert ([task.name for task in made.tasks], made.outside) == (["W2"], (AWAY,))
    for use_case in ("cabinet", "automotive_formboard", "branched_harness"):
        away = work(order(("Q1:B1", "M1:T1"), outside=("M1",)), find_use_case(use_case))
        assert (away.tasks, away.by_hand, away.outside) == ((), (), (AWAY,))


def test_what_cannot_be_an_order_is_refused():
    own = replace(CABINET, name="ropes", designs=None)
    with pytest.raises(OrderError, match="ropes takes no imported designs"):
        work(project("industrial"), own)
    thick = order(("Q1:B1", "Q2:T1"), section_mm2=400.0)
    with pytest.raises(InstanceError, match=r"task W1: section_mm2 is 400\.0, and must be"):
        problem(thick)


def test_a_task_that_no_robot_can_do_is_by_hand_and_the_rest_is_planned():
    made = order(("Q1:B1", "Q2:T1"), ("Q1:B2", "Q2:T2"), ("Q1:B3", "Q2:T3"))
    wires = [replace(w, section_mm2=s) for w, s in zip(made.wires, (1.5, 400.0, 2.5), strict=True)]
    thick = work(replace(made, wires=tuple(wires)))
    found = triaged(thick, GRIPPERS)
    assert [task.name for task in found.tasks] == ["W1", "W3"]
    assert list(map(str, found.by_hand)) == [
        "W2: by hand, section_mm2 is 400.0, and must be a number from 0.05 to 300 "
        "(characteristics.task.section_mm2 in grippers.yaml)"
    ]
    assert list(map(str, found.other_methods)) == [
        "W3 by methods.pick.medium in grippers.yaml: not thin: section_mm2 is 2.5, not at most 1.5"
    ]
    planned = plan_problem(prepare(found, GRIPPERS).preferred.problem, time_limit_s=0.05)
    assert planned.makespan > 0


def test_the_method_of_the_second_end_is_no_other_one_and_two_robots_are_planned_as_one():
    made = work(order(("Q1:B1", "Q2:T1"), ("Q1:B2", "Q2:T2")), CABINET)
    assert [arm.name for arm in made.arms] == ["robot_1"]
    assert triaged(made, CABINET).other_methods == ()


def test_a_task_that_no_method_does_is_by_hand_with_what_rules_out_each_method():
    made = order(("Q1:B1", "Q2:T1"), ("Q1:B2", "Q2:T2"))
    thick = replace(made, wires=(replace(made.wires[0], section_mm2=6.0), made.wires[1]))
    thin = replace(GRIPPERS, methods={**GRIPPERS.methods, "pick": GRIPPERS.methods["pick"][:2]})
    found = triaged(work(thick, thin), thin)
    assert [task.name for task in found.tasks] == ["W2"]
    assert str(found.by_hand[0]).startswith(
        "W1: by hand, no method of grippers.yaml does it: pick thin: "
    )


def test_a_wire_that_its_terminal_has_no_place_for_is_by_hand():
    ends = [(f"Q1:B{n}", f"Q{n + 1}:T1") for n in (1, 2, 3, 4)]
    made = order(*ends)
    q1 = next(component for component in made.components if component.name == "Q1")
    shared = replace(q1, terminals=tuple(replace(end, point="B") for end in q1.terminals))
    others = tuple(component for component in made.components if component != q1)
    found = triaged(work(replace(made, components=(shared, *others))), GRIPPERS)
    assert [task.name for task in found.tasks] == ["W1", "W2"]
    assert list(map(str, found.by_hand)) == [
        f"{name}: by hand, Q1:B takes 2 wires, and has 4: it needs a bridge or a bar"
        for name in ("W3", "W4")
    ]


def test_of_a_task_that_no_method_does_only_what_rules_methods_out_is_a_reason():
    gently = {"name": "gently", "insert": {"component": "Q2"}, "force_n": 20}
    document = {"format": "remodel-preferences-1", "require": [gently]}
    found = triaged(work(order(("Q1:B1", "Q2:T1"))), GRIPPERS)
    with pytest.raises(InfeasibleError) as refused:
        prepare(found, GRIPPERS, [("preferences", document)])
    assert str(refused.value).endswith(
        "no method of grippers.yaml does it: insert push in and close: push_in pushes with 40 N, "
        "over 20 N (`gently`)"
    )


def test_an_order_without_a_task_for_the_robot_has_an_empty_plan():
    found = triaged(work(order(("Q1:B1", "Q2:T1"), section_mm2=400.0)), GRIPPERS)
    assert (found.tasks, [each.task for each in found.by_hand]) == ((), ["W1"])
    planned = plan_problem(prepare(found, GRIPPERS).preferred.problem, time_limit_s=0.05)
    assert (planned.cost, planned.plan.actions) == (0, ())
    assert not triaged(work(order(("Q1:B1", "Q2:T1"))), GRIPPERS).by_hand


def test_the_default_use_case_follows_from_the_design_and_the_users_own_come_first(
    tmp_path, monkeypatch
):
    assert kind_of(board_of(loom(), CATALOGUE)) is DesignKind.HARNESS
    assert kind_of(board_of(project("industrial"), CATALOGUE)) is DesignKind.CABINET
    assert use_case_for(DesignKind.HARNESS).name == "automotive_formboard"
    assert use_case_for(DesignKind.CABINET).name == "cabinet"
    own = yaml.safe_load(
        (
            (Path(__file__).parents[3] / "remodel_tasks/config/use_cases") / "cabinet.yaml"
        ).read_text()
    )
    own |= {"name": "own", "designs": {**own["designs"], "arms": ["left", "right"]}}
    (tmp_path / "own.yaml").write_text(yaml.safe_dump(own))
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    use_case = use_case_for(DesignKind.CABINET)
    assert [arm.name for arm in work(order(("Q1:B1", "Q2:T1")), use_case).arms] == ["left", "right"]
    monkeypatch.setattr("remodel_tasks.edge.use_case_files.use_case_folder", lambda: tmp_path)
    with pytest.raises(UseCaseError, match=r"no use case says `designs: \{default_for: harness\}`"):
        use_case_for(DesignKind.HARNESS)


@pytest.mark.parametrize("arms", [1, 2])
@pytest.mark.parametrize(
    ("file", "use_case"),
    [
        (DESIGNS / "loom.kbl", FORMBOARD),
        (DESIGNS / "loom.kbl", BRANCHES),
        (DESIGNS / "harness.yml", FORMBOARD),
        (DESIGNS / "eplan.csv", CABINET),
        (QET / "tableau_domestique.qet", CABINET),
    ],
    ids=lambda value: value.name,
)
def test_the_synthesizer_accepts_the_charts_of_every_format(file, use_case, arms, library):
    board = board_of(imported(file), CATALOGUE)
    prepared = prepare(triaged(board_order(board, use_case, arms), use_case), use_case)
    plan = plan_problem(prepared.preferred.problem, 0.02).plan
    tasks = list(planned_tasks(prepared, plan))
    assert {task.name for task in tasks} == {task.name for task in prepared.order.tasks}
    for task in tasks[:5]:
        text = write_chart(task.chart)
        assert check_chart(parse_chart(text, "x.xml"), library, {}).problems == ()


def test_seals_and_twisted_wires_are_known_to_tasks_and_an_end_in_a_splice_is_not_pulled():
    made = order(("X1:1", "X2:1"), ("X1:2", "X2:2"), ("X1:3", "S1:1"), section_mm2=0.5)
    kinds = {"X1": Role.CONNECTOR, "X2": Role.CONNECTOR, "S1": Role.JOINT}
    components = [replace(c, role=kinds[c.name]) for c in made.components]
    first, *rest = components[0].terminals
    sealed = replace(first, kind=sealed_kind("T-1", "S-9"))
    components[0] = replace(components[0], terminals=(sealed, *rest))
    wires = [replace(w, cable="TW" if w.name != "W3" else "") for w in made.wires]
    cables = (Cable("TW", TWISTED, None, shielded=False, source="line 1"),)
    made = replace(made, components=tuple(components), wires=tuple(wires), cables=cables)
    formboard = find_use_case("automotive_formboard")
    found = work(made, formboard)
    said = {t.name: (t.characteristics["seal"], t.characteristics["twisted"]) for t in found.tasks}
    assert said == {"W1": (True, True), "W2": (False, True), "W3": (False, False)}
    slots = {t.name: t.slot_mm for t in found.tasks}
    assert slots["W1"] == slots["W2"] != slots["W3"]
    assert found.cables == {"TW": ("W1", "W2")}
    assert len({t.preferred_arm for t in found.tasks if t.name != "W3"}) == 1
    steps = {
        plan.alone.task.name: [(step.title, step.action.name) for step in plan.alone.steps]
        for plan in prepare(found, formboard).plans
    }
    assert ("Release b", "release_end") in steps["W3"]
    assert ("Pull b", "pull_test") in steps["W2"]


def test_a_use_case_states_which_end_is_inserted_first():
    example = imported(Path(__file__).parents[2] / "examples" / "harness.yml")
    formboard = find_use_case("harness_formboard")
    made = board_order(board_of(example, CATALOGUE), formboard, arms=1)
    assert {task.first for task in made.tasks} == {End.A}
    assert {plan.alone.first for plan in prepare(made, formboard).plans} == {End.A}
    free = replace(formboard, designs=replace(formboard.designs, first=None))
    freely = board_order(board_of(example, CATALOGUE), free, arms=1)
    assert {task.first for task in freely.tasks} == {None}
