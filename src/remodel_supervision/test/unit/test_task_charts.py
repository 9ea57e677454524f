"""Planned tasks become charts that the synthesizer accepts, with the recovery of their use case."""

import os
from dataclasses import replace
from pathlib import Path

import pytest
import yaml
from app_judge import judge
from house import house_order
from lxml import etree

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.error_routes import codes_of_routes
from flexbe_synthesizer.core.chart.model import ErrorRoute
from flexbe_synthesizer.core.chart.names import behavior_file, is_name
from flexbe_synthesizer.core.check.check import check_chart
from flexbe_synthesizer.core.compile import compile_chart
from flexbe_synthesizer.core.export.layout import lay_out as lay_out_machine
from flexbe_synthesizer.core.export.render_python import render_python
from flexbe_synthesizer.core.library.signature import chart_behavior
from flexbe_synthesizer.edge.package_path import find_packages, read_library
from flexbe_testing.edge.doctor import read_packages
from remodel_production.edge.design_files import read_abilities
from remodel_production.errors import InstanceError
from remodel_supervision.core.recovery.decide import Adjustable, with_parameters
from remodel_tasks.core.decomposition.preparation import decompose_order, prepare
from remodel_tasks.core.orders.work_order import order_from
from remodel_tasks.core.problem.problem import End
from remodel_tasks.core.task_charts.planned_tasks import escalating, planned_tasks
from remodel_tasks.core.task_charts.task_chart import (
    behavior_name,
    content_mark,
    emptying,
    task_chart,
)
from remodel_tasks.edge.anytime_planner import plan_problem
from remodel_tasks.edge.document_files import keep_chart
from remodel_tasks.edge.fault_file import read_error_names
from remodel_tasks.edge.use_case_files import find_use_case, read_use_case
from remodel_tasks.errors import UseCaseError

PACKAGE = Path(__file__).parents[3] / "remodel_tasks"
EXAMPLES = ["automotive_harness", "branched_harness", "cabinet", "dialysis_hoses"]


CONNECTOR_FILE = PACKAGE.parent / "remodel_behaviors" / "charts" / "place_connector.xml"
CONNECTOR = parse_chart(CONNECTOR_FILE.read_text(), CONNECTOR_FILE.name)
CONNECTORS = read_use_case(PACKAGE / "test" / "use_cases" / "connectors.yaml")

# Outcomes of PlacePinState in Deliverable 5.1; see the README of flexbe_synthesizer.
BLANKED_BY_THE_APP = ("PlacePin finished normally", "PlacePin takes longer than normal")
ERROR_NAMES = read_error_names()


def tasks_of(text):
    order = order_from(yaml.safe_load(text))
    prepared = prepare(order, find_use_case(order.use_case))
    planned = plan_problem(prepared.preferred.problem, 0.02)
    return {task.name: task for task in planned_tasks(prepared, planned.plan)}


def example(name):
    return tasks_of((PACKAGE / "examples" / f"{name}.yaml").read_text())


def house_tasks(use_case=CONNECTORS):
    prepared = prepare(house_order(use_case), use_case)
    planned = plan_problem(prepared.preferred.problem, 0.0)
    return {task.name: task for task in planned_tasks(prepared, planned.plan)}


@pytest.fixture(scope="module")
def library():
    packages, _ = find_packages(os.environ["ROS_PACKAGE_PATH"])
    names = ("flexbe_states", "remodel_msgs", "remodel_states", "remodel_behaviors")
    wanted = [package for package in packages if package.name in names]
    return read_library(wanted)[0]


@pytest.fixture(scope="module")
def known_to_app():
    flexbe_states = PACKAGE.parent / "flexbe" / "flexbe_states"
    folders = [PACKAGE.parent / name for name in ("remodel_states", "remodel_behaviors")]
    return read_packages([*folders, flexbe_states])


@pytest.mark.parametrize("name", EXAMPLES)
def test_synthesizer_and_app_accept_the_charts_of_all_examples(name, library, known_to_app):
    known = {CONNECTOR_FILE.name: chart_behavior(CONNECTOR, "remodel_behaviors")}
    for task in example(name).values():
        text = write_chart(task.chart)
        chart = parse_chart(text, f"{task.name}.xml")
        assert chart == task.chart
        for done in (chart, escalating(chart)):
            checked = check_chart(done, library, known)
            assert checked.problems == ()
            machine = compile_chart(checked, "remodel_behaviors")
            behavior = render_python(machine, lay_out_machine(machine.root), {})
            for outcome in BLANKED_BY_THE_APP:
                behavior = behavior.replace(outcome, outcome.replace(" ", ""))
            assert judge(behavior, known_to_app) == []


@pytest.fixture(scope="module")
def cabinet():
    return example("cabinet")


def transitions_of(node):
    return {t.event: t.target for t in node.transitions}


def transitions(chart):
    return {node.id: transitions_of(node) for node in chart.nodes}


def flows_of(chart):
    return {(c.output_state_id, c.output, c.input_state_id) for c in chart.connections}


def params_of(node):
    return {param.name: param.value for param in node.params}


def test_what_fails_is_done_again_as_the_use_case_says(cabinet):
    nodes = transitions(cabinet["W1"].chart)
    assert nodes["Find ends"]["failed"] == "Find ends"
    assert nodes["Fix a"]["failed"] == "Insert a"
    assert cabinet["W1"].chart.nodes[0].attempts == 3


def test_what_a_supervisor_handles_first_is_not_tried_again(cabinet):
    task = next(iter(cabinet.values()))
    chart = escalating(task.chart)
    nodes = {node.id: node for node in chart.nodes}
    look = next(node for node in chart.nodes if node.type == "DetectCableState")
    (route,) = look.on_error
    assert route == ErrorRoute("above_behavior", transitions(chart)[look.id]["command_error"])
    assert nodes["Release 2"].on_error == (), "both its failures lead to the same place"
    assert content_mark(chart) != content_mark(task.chart)


def test_changed_parameters_reach_into_nested_behaviors(library):
    types = {"InsertCable": {"force_limit": "float64"}}
    adjustable = Adjustable(types, {CONNECTOR.name: CONNECTOR})
    task = house_tasks()["W1"].chart
    path = "/Connect b/FixCable"
    chart = with_parameters(task, path, {"force_limit": 13.0}, adjustable)
    chart = with_parameters(chart, path, {"force_limit": 18.0}, adjustable)
    text = write_chart(chart)
    known = {CONNECTOR_FILE.name: chart_behavior(CONNECTOR, "remodel_behaviors")}
    assert check_chart(parse_chart(text, "W1.xml"), library, known).problems == ()
    inside = next(node for node in chart.nodes if node.id == "Connect b").body
    forces = {node.id: [(p.name, p.value) for p in node.params] for node in inside.nodes}
    assert forces["InsertCable"] == [("force_limit", 18.0)]
    assert forces["FixCable"] == []
    other = next(node for node in chart.nodes if node.id == "Connect a")
    assert other in task.nodes


@pytest.mark.parametrize(
    ("path", "ability"),
    [
        ("/Find wire", "DetectCable"),
        ("/Connect b/LocateGearboxComponent", "LocateGearboxComponent"),
    ],
)
def test_another_view_is_a_whole_number(path, ability):
    types = {each.name: {p.name: p.type for p in each.parameters} for each in read_abilities()}
    adjustable = Adjustable(types, {CONNECTOR.name: CONNECTOR})
    chart = with_parameters(house_tasks()["W1"].chart, path, {"view": 2.0}, adjustable)
    text = write_chart(chart)
    assert parse_chart(text, "W1.xml") == chart
    root = etree.fromstring(text.encode())
    states = root.xpath("//*[local-name()='param'][@name='view']/..")
    assert [state.get("type") for state in states] == [f"{ability}State"]
    assert states[0].xpath("*[@name='view']/@value") == ["2"]


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_hand_is_emptied_whatever_it_holds(name, library):
    for task in example(name).values():
        chart = task.clear()
        hands = len(tuple(emptying(task.use_case, task.arms)))
        assert [node.type for node in chart.nodes] == ["PlaceCableState"] * hands
        assert [(each.name, each.default) for each in chart.inputs] == [("cable_id", "")]
        assert parse_chart(write_chart(chart), "clear.xml") == chart
        assert check_chart(chart, library, {}).problems == ()


@pytest.mark.parametrize("order", EXAMPLES[:3])
def test_a_part_is_discarded_by_one_step(order):
    for name, task in example(order).items():
        chart = task.discard()
        (node,) = chart.nodes
        assert chart.name == f"{task.chart.name} Discard"
        assert (node.type, chart.initial) == ("DiscardCableState", node.id)
        assert transitions_of(node) == {
            "discarded": "finished",
            "failed": "failed",
            "command_error": "failed",
        }
        assert [(each.name, each.default) for each in chart.inputs] == [("cable_id", name)]
        assert [each.name for each in node.outputs] == ["error_code", "error_message"]
        assert parse_chart(write_chart(chart), "discard.xml") == chart


def test_a_use_case_without_discarding_says_so():
    task = next(iter(example("dialysis_hoses").values()))
    with pytest.raises(UseCaseError, match="medical_hoses states no `discard` action"):
        task.discard()


def test_a_shipped_behavior_leaves_to_supervisors_what_they_handle_first():
    for node in CONNECTOR.nodes:
        again = transitions_of(node)["failed"] != "failed"
        routed = {c for codes in codes_of_routes(node.on_error, ERROR_NAMES) for c in codes}
        assert routed == (set(ERROR_NAMES["above_behavior"]) if again else set()), node.id


def test_what_is_serious_is_handled_first_by_a_supervisor():
    # An escalating chart gives up at once what is serious, and undoes the rest that it leaves.
    assert set(ERROR_NAMES["serious"]) < set(ERROR_NAMES["above_behavior"])


def test_whatever_is_given_up_with_a_full_hand_ends_in_emptying_it(cabinet):
    nodes = transitions(cabinet["W1"].chart)
    assert nodes["Find ends"]["exhausted"] == "failed"
    for node, event in (
        ("Insert a", "exhausted"),
        ("Hold", "exhausted"),
        ("Hold", "command_error"),
        ("Lay", "command_error"),
        ("Lay", "failed"),
        ("Fix b", "command_error"),
    ):
        assert nodes[node][event] == "Release"
    assert set(nodes["Release"].values()) == {"Release 2"}
    assert set(nodes["Release 2"].values()) == {"failed"}


def test_the_chart_carries_the_task_in_its_inputs(cabinet):
    chart = cabinet["W2"].chart
    defaults = {port.name: port.default for port in chart.inputs}
    assert chart.name == "Place Wire W2"
    assert (defaults["cable_id"], defaults["a_component"], defaults["a_terminal"]) == (
        "W2",
        "Q1",
        "2",
    )
    release = next(node for node in chart.nodes if node.id == "Release")
    assert params_of(release)["target"] == (0.1, -0.1, 0.06, 0.0)


def test_what_one_state_sees_flows_to_the_one_that_needs_it():
    task = example("dialysis_hoses")["H1"]
    first, flows = task.decomposition.first, flows_of(task.chart)
    for end in (first, first.other):
        locate, push = f"Locate {end.letter}", f"Push on {end.letter}"
        assert (locate, "socket_pose", push) in flows


def test_a_failed_insertion_is_undone_before_it_is_tried_again():
    task = example("dialysis_hoses")["H1"]
    nodes = transitions(task.chart)
    assert nodes["Push on a"]["failed"] == "Extract a"
    assert nodes["Extract a"] == {
        "extracted": "Locate a",
        "failed": "Lay aside",
        "command_error": "Lay aside",
    }
    assert ("Locate a", "socket_pose", "Extract a") in flows_of(task.chart)


def test_who_takes_over_does_what_follows_the_handover():
    task = example("automotive_harness")["W1"]
    assert len(task.arms) == 2
    robots = [
        robot
        for node, robot in robots_of(task.chart).items()
        if not node.startswith(("Extract", "Lay aside"))
    ]
    given = robots.index(task.arms[1])
    assert set(robots[:given]) == {task.arms[0]}
    assert set(robots[given:]) == {task.arms[1]}


def robots_of(chart):
    """Return the robots of a chart's nodes by their ids."""
    named = {node.id: params_of(node).get("robot_name") for node in chart.nodes}
    return {node: robot for node, robot in named.items() if robot}


def test_two_robots_do_a_wire_by_name(cabinet, library):
    chart = cabinet["W1"].chart
    assert list(robots_of(chart).items())[:7] == [
        ("Hold", "robot_2"),
        ("Grasp", "robot_1"),
        ("Insert a", "robot_1"),
        ("Fix a", "robot_1"),
        ("Lay", "robot_2"),
        ("Insert b", "robot_2"),
        ("Fix b", "robot_2"),
    ]
    flows = flows_of(chart)
    assert ("Locate first", "socket_pose", "Insert a") in flows
    assert ("Locate second", "socket_pose", "Insert b") in flows
    for chart in (cabinet["W1"].chart, cabinet["W1"].clear(), cabinet["W1"].discard()):
        assert check_chart(escalating(chart), library, {}).problems == ()


def test_a_task_that_is_given_up_empties_the_hands_of_all_its_robots(cabinet):
    robots = robots_of(cabinet["W1"].chart)
    assert (robots["Release"], robots["Release 2"]) == ("robot_1", "robot_2")
    handed_over = example("automotive_harness")["W1"]
    robots = robots_of(handed_over.chart)
    assert (robots["Lay aside"], robots["Lay aside 2"]) == handed_over.arms


def test_what_is_left_begins_with_all_that_it_needs_in_order(cabinet):
    left = [step.title for step in cabinet["W1"].left("a")]
    assert left == ["Find ends", "Locate second", "Hold", "Lay", "Insert b", "Fix b"]


def test_unchanged_charts_are_kept_and_changed_ones_have_another_mark(tmp_path, cabinet):
    text = (PACKAGE / "examples" / "cabinet.yaml").read_text()
    again, other = tasks_of(text), tasks_of(text.replace("section_mm2: 2.5", "section_mm2: 4.0"))
    assert content_mark(again["W2"].chart) == content_mark(cabinet["W2"].chart)
    assert content_mark(other["W2"].chart) != content_mark(cabinet["W2"].chart)
    file, written = keep_chart(cabinet["W2"].chart, tmp_path / "charts")
    assert (file.name, written) == ("place_wire_w2.xml", True)
    assert keep_chart(again["W2"].chart, tmp_path / "charts") == (file, False)
    assert keep_chart(other["W2"].chart, tmp_path / "charts") == (file, True)


def test_a_folder_that_cannot_be_written_is_refused(tmp_path, cabinet):
    (tmp_path / "charts").write_text("")
    with pytest.raises(InstanceError, match=r"charts/place_wire_w1\.xml: cannot be used: "):
        keep_chart(cabinet["W1"].chart, tmp_path / "charts")


def test_a_value_that_the_task_lacks_is_named():
    carry = replace(CONNECTORS.actions["carry"], params=(("path", "$carry_path"),))
    own = replace(CONNECTORS, actions={**CONNECTORS.actions, "carry": carry})
    with pytest.raises(UseCaseError, match=r"task W1: carry refers to \$carry_path, which it does"):
        _ = house_tasks(own)["W1"].chart


def test_the_first_end_asked_for_is_kept(cabinet):
    assert {task.decomposition.first for task in cabinet.values()} == {End.A}


def test_any_name_of_a_wire_names_a_chart_of_its_own():
    use_case = find_use_case("cabinet")
    wires = ("W1", "24", "24#2", "24+2", "-X1 1", "-X1.1", "Größe", "Gr_e", "class", "=A1/+B 2")
    names = [behavior_name(use_case, wire) for wire in wires]
    assert names[:2] == ["Place Wire W1", "Place Wire 24"]
    assert all(map(is_name, names))
    assert len(set(map(behavior_file, names))) == len(wires)


def limited(limit):
    """Return an order of one wire whose first terminal bears little."""
    data = yaml.safe_load((PACKAGE / "examples" / "automotive_harness.yaml").read_text())
    data["components"] = [{"id": component["id"]} for component in data["components"]]
    data["tasks"][0]["characteristics"]["seal"] = False
    first = data["tasks"][0]["a"]
    terminal = next(t for t in data["terminals"] if t["id"] == first)
    terminal |= {"force_limit_n": limit, "clearance_m": 0.002, "approach": [0, 0, -1]}
    return data


def test_no_chart_pushes_harder_than_the_terminal_bears():
    data = limited(9)
    chart = tasks_of(yaml.safe_dump(data))[data["tasks"][0]["id"]].chart
    forces = {node.id: params_of(node).get("force_limit") for node in chart.nodes}
    assert forces["Insert a"] == 9
    assert forces["Insert b"] > 9


def test_an_action_without_a_force_parameter_is_not_used_where_it_is_too_strong():
    use_case = find_use_case("automotive_formboard")
    order = order_from(limited(9))
    deaf = {
        name: replace(action, params=tuple(p for p in action.params if p[1] != "$force_n"))
        for name, action in use_case.actions.items()
    }
    with pytest.raises(InstanceError, match="push_in pushes with 40 N, over 9 N that the terminal"):
        prepare(order, replace(use_case, actions=deaf))


def test_actions_may_refer_to_the_access_of_a_terminal():
    use_case = find_use_case("automotive_formboard")
    asked = (("approach", "$approach"), ("clearance", "$clearance_m"))
    actions = {
        name: replace(action, params=(*action.params, *asked)) if "push" in name else action
        for name, action in use_case.actions.items()
    }
    order = order_from(limited(9))
    decomposition = decompose_order(order, use_case)[0].alone
    component_of = {terminal.name: terminal.component for terminal in order.terminals}
    asking = replace(use_case, actions=actions)
    steps = tuple(replace(s, action=actions[s.action.name]) for s in decomposition.steps)
    first_only = replace(decomposition, steps=steps[:4])
    chart = task_chart(asking, first_only, component_of, ("left",))
    params = params_of(next(node for node in chart.nodes if node.id == "Insert a"))
    assert (params["approach"], params["clearance"]) == ((0.0, 0.0, -1.0), 0.002)
    with pytest.raises(UseCaseError, match=r"push_in refers to \$approach, which it does not have"):
        task_chart(asking, replace(decomposition, steps=steps), component_of, ("left",))


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("force_limit_n", 0, "force_limit_n: expected a number above 0, found 0"),
        ("clearance_m", "wide", "clearance_m: expected a number above 0, found 'wide'"),
        ("approach", [0, 0, 2], "approach: expected three numbers, of a vector of length 1"),
        ("approach", [1, 0], "approach: expected three numbers"),
    ],
)
def test_an_access_that_cannot_be_is_refused_by_place(key, value, message):
    data = limited(9)
    data["terminals"][0][key] = value
    with pytest.raises(InstanceError, match=rf"terminals\[0\]\.{message}"):
        order_from(data)
