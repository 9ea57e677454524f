"""Use cases are data: read with all names checked, found in folders, refused with the place."""

from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from remodel_production.errors import InstanceError
from remodel_tasks.core.decomposition.decomposed import Limits, outline
from remodel_tasks.core.decomposition.decomposition import Decomposer
from remodel_tasks.core.decomposition.preparation import decompose_order, decomposer_of, prepare
from remodel_tasks.core.orders.work_order import order_from
from remodel_tasks.core.problem.problem import End
from remodel_tasks.core.task_charts.planned_tasks import Demands, demands_of, planned_tasks
from remodel_tasks.core.use_case.model import Expectation, Macro
from remodel_tasks.edge.anytime_planner import plan_problem
from remodel_tasks.edge.use_case_files import VARIABLE, find_use_case, read_use_case
from remodel_tasks.errors import UseCaseError

PACKAGE = Path(__file__).parents[2]
FOLDER = PACKAGE / "config" / "use_cases"
HOSES = PACKAGE / "examples" / "dialysis_hoses.yaml"
CABINET = PACKAGE / "examples" / "cabinet.yaml"


def order(file):
    return order_from(yaml.safe_load(file.read_text()))


def decomposed(file, limits=None, expectations=None):
    """Return the decompositions of an example's tasks, by name."""
    found = order(file)
    plans = decompose_order(found, find_use_case(found.use_case), limits, expectations)
    return {plan.alone.task.name: plan.alone for plan in plans}


def actions(decomposition):
    return [step.action.name for step in decomposition.steps]


@pytest.mark.parametrize("file", sorted(FOLDER.glob("*.yaml")), ids=lambda file: file.stem)
def test_every_use_case_of_the_package_reads(file):
    use_case = read_use_case(file)
    assert use_case.name == file.stem
    assert {macro.value for macro in Macro} - {"locate", "hand_over"} <= set(use_case.methods)


def test_characteristics_choose_the_methods():
    hoses = decomposed(HOSES)
    assert ("insert", "push over the barb") in hoses["H1"].steps[3].methods
    assert "clamp" in actions(hoses["H1"])
    assert "widen" in actions(hoses["H2"])  # its second port is fragile
    assert "clamp" not in actions(hoses["H3"])  # there is no pressure in it


def test_what_is_unknown_is_to_check_and_what_moved_is_to_check_again():
    names = actions(decomposed(HOSES)["H1"])
    assert names[:2] == ["find_ends", "grasp"]
    assert names[names.index("push_on") - 1] == "locate_port"
    after = names[names.index("push_on") + 1 :]
    assert after[:4] == ["clamp", "find_ends", "regrasp", "lead"]


def test_the_charts_of_an_order_tell_what_it_demands_of_the_cell():
    found = order(HOSES)
    prepared = prepare(found, find_use_case(found.use_case))
    plan = plan_problem(prepared.preferred.problem, 0.0).plan
    demands = demands_of(task.chart for task in planned_tasks(prepared, plan))
    assert demands.robots == ("robot_1", "robot_2")
    assert demands.forces_n == (("InsertCable", 35.0),)
    assert demands_of(()) == Demands()


def test_a_clip_has_its_own_part_of_the_route():
    steps = decomposed(PACKAGE / "examples" / "branched_harness.yaml")["trunk"].steps
    leads = [step for step in steps if step.action.name == "lead"]
    assert [step.clip.name for step in leads] == ["C1", "C2", "C3"]
    assert [step.route.path_mm[-1] for step in leads] == [(200, 0), (500, 0), (800, 0)]


def test_a_force_limit_chooses_the_gentler_method():
    free = decomposed(HOSES)["H1"]
    limited = decomposed(HOSES, Limits({"H1": (20.0, "gently")}))["H1"]
    assert (free.force_n, limited.force_n) == (35.0, 12.0)
    printed = "\n".join(outline(limited))
    assert "push_on pushes with 35 N, over 20 N (`gently`)" in printed


def test_a_forbidden_segment_chooses_another_route():
    file = PACKAGE / "examples" / "automotive_harness.yaml"
    assert decomposed(file)["W3"].route.segments == ("upper",)
    limits = Limits({}, {"upper": "keep off"})
    assert decomposed(file, limits)["W3"].route.segments == ("trunk_left", "stub")
    with pytest.raises(InstanceError, match=r"route 2: goes through upper \(`keep off`\)"):
        decomposed(file, Limits({}, {"upper": "keep off", "stub": "keep off"}))


def test_no_method_is_an_error_with_the_reason_of_each():
    with pytest.raises(InstanceError, match=r"H1: no method .* slip_on pushes with 12 N, over 5 N"):
        decomposed(HOSES, Limits({"H1": (5.0, "hands off")}))


class Learned:
    """Expectations in which pushing hoses on has turned out to fail."""

    def __init__(self, frozen):
        self.frozen = frozen

    def expect(self, ability, features):
        if ability == "InsertCable" and features.get("component.port") == "barb":
            return Expectation(30.0, 0.3)
        return self.frozen.expect(ability, features)


def test_learned_expectations_change_durations_and_methods():
    use_case = find_use_case("medical_hoses")
    learned = decomposed(HOSES, None, Learned(use_case.expectations))["H1"]
    frozen = decomposed(HOSES)["H1"]
    assert learned.cost_s > frozen.cost_s
    assert learned.expected_s(Macro.INSERT, learned.first) > 25
    assert learned.expected_s(Macro.ROUTE) == frozen.expected_s(Macro.ROUTE)


def test_attempts_make_success_likelier_and_take_longer():
    once = Expectation(10.0, 0.5)
    assert once.tried(1) == once
    assert once.tried(2) == Expectation(15.0, 0.75)
    assert Expectation(10.0, 0.0).tried(3) == Expectation(30.0, 0.0)


MINIMAL = """
format: remodel-use-case-1
name: ropes
title: Lay Rope {task}
description: Ropes, laid by hand.
characteristics: {task: {colour: {default: grey}}}
abilities: {PickCable: {duration_s: 1, success: 1}}
actions:
  take: {title: Take, state: PickCableState, done: picked, abilities: [PickCable], grasps: true,
         inputs: {cable_id: $task, cable_end: $first_end}}
methods:
  pick: [{name: take it, do: [take]}]
  insert: [{name: lies there, do: []}]
  route: [{name: lies there, do: []}]
  fix: [{name: lies there, do: []}]
give_up: take
cell: {speed_m_s: 1, change_tool_s: 0, extract_s: 0, failure_s: 0, carry_height_m: 0.1}
"""


def test_a_use_case_is_added_by_a_file_alone(tmp_path, monkeypatch):
    (tmp_path / "ropes.yaml").write_text(MINIMAL)
    with pytest.raises(UseCaseError, match="no use case ropes; there are automotive_formboard"):
        find_use_case("ropes")
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    use_case = find_use_case("ropes")
    cabinet = order(CABINET)
    rope = replace(cabinet.tasks[0], characteristics={"colour": "white"})
    component_of = {terminal.name: terminal.component for terminal in cabinet.terminals}
    decomposer = Decomposer(use_case, cabinet.components, component_of)
    assert actions(decomposer.decompose(rope, cabinet.tasks[0].first)) == ["take"]


def test_methods_may_differ_between_the_end_that_is_inserted_first_and_the_other_one():
    found, use_case = order(CABINET), find_use_case("cabinet")
    task = found.tasks[0]
    decomposer = decomposer_of(found, use_case, None)
    for first in End:
        decomposition = decomposer.decompose(task, first)
        pushes = [step for step in decomposition.steps if "push_in" in step.action.name]
        assert [(step.action.name, step.end) for step in pushes] == [
            ("push_in_first", first),
            ("push_in_second", first.other),
        ]
        assert ("insert", "the first end") in pushes[0].methods


def test_an_order_for_two_robots_at_each_wire_demands_both():
    use_case = find_use_case("cabinet")
    prepared = prepare(order(CABINET), use_case)
    plan = plan_problem(prepared.preferred.problem, 0.0).plan
    demands = demands_of(task.chart for task in planned_tasks(prepared, plan))
    force_n = use_case.actions["push_in_first"].force_n
    assert demands == Demands(("robot_1", "robot_2"), (("InsertCable", force_n),))


def learned(ability, frozen, least, most, values):
    bounds = f"frozen: {frozen}, at_least: {least}, at_most: {most}, values: {values}"
    return f"learned: {{{ability}: {{force: {{{bounds}}}}}}}"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("name: ropes", "name: rope"), "name: expected ropes, as the file is called, found rope"),
        (
            ("success: 1", "success: 2"),
            "abilities.PickCable.success: found 2; allowed: 1 or less",
        ),
        (("give_up: take", ""), "methods, cell; missing: give_up"),
        (("give_up: take", "give_up: drop"), "give_up: no action drop; there are take"),
        (("give_up: take", "give_up: [take, drop]"), "give_up: no action drop; there are take"),
        (("give_up: take", "give_up: []"), "give_up: found []; allowed: "),
        (
            ("give_up: take", "give_up: take\ndiscard: drop"),
            "discard: no action drop; there are take",
        ),
        (("do: [take]", "do: [grip]"), "methods.pick.take it: no task grip; there are fix, insert"),
        (("do: [take]", "do: [pick]"), "decomposition without end: pick needs pick"),
        (("[PickCable], ", "[Grip], "), "actions.take.abilities: no ability Grip; there are Pick"),
        (
            ("grasps: true", "needs: [ends]"),
            "actions.take.needs: no unknown fact ends; there are non",
        ),
        (
            ("name: take it, do", "name: take it, when: {size: 3}, do"),
            "methods.pick.take it.when: no characteristic size; there are clips, colour, end, le",
        ),
        (("  pick: [{name: take it, do: [take]}]\n", ""), "methods: none for pick"),
        (
            ("title: Lay Rope {task}", "title: Lay Rope"),
            "title: found 'Lay Rope'; allowed: text that matches",
        ),
        (("format", "["), "is no YAML: "),
        (
            ("abilities:", "unknown: {ends: {of: task, look: take}}\nabilities:"),
            "unknown.ends.look: take does not reveal it",
        ),
        (
            ("{duration_s: 1, success: 1}", "[{when: {colour: red}, duration_s: 1, success: 1}]"),
            "abilities.PickCable: the last entry must have no `when`",
        ),
        (
            ("actions:", learned("PickCable", 9, 4, 8, values=5) + "\nactions:"),
            "learned.PickCable: bounds must be low <= frozen <= high",
        ),
        (
            ("actions:", learned("Grip", 6, 4, 8, values=5) + "\nactions:"),
            "learned: no ability Grip; there are PickCable",
        ),
        (
            ("actions:", learned("PickCable", 6, 4, 8, values=1) + "\nactions:"),
            "learned.PickCable.force.values: found 1; allowed: 2 or more",
        ),
    ],
)
def test_malformed_use_cases_are_refused_with_the_place(tmp_path, change, message):
    file = tmp_path / "ropes.yaml"
    assert change[0] in MINIMAL
    file.write_text(MINIMAL.replace(*change, 1))
    with pytest.raises(UseCaseError) as caught:
        read_use_case(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert message in str(caught.value)


LOOKING = """
unknown: {near: {of: task, look: look_near}, far: {of: task, look: look_far}}
actions:
  look_near: {title: Near, state: S, done: d, abilities: [PickCable], reveals: [near], FORGETS}
  look_far: {title: Far, state: S, done: d, abilities: [PickCable], reveals: [far], forgets: [near]}
"""


@pytest.mark.parametrize(
    ("needs", "forgets", "message"),
    [
        ("[near, far]", "forgets: [far]", "take is never ready: observing near undoes far undoes"),
        (
            "{near: key}",
            "forgets: []",
            "actions.look_near.reveals: name the output that carries near",
        ),
        ("[near, far]", "needs: [near]", "decomposition without end: look_near needs look_near"),
    ],
)
def test_looking_that_leads_nowhere_is_refused(tmp_path, needs, forgets, message):
    file = tmp_path / "ropes.yaml"
    text = MINIMAL.replace("grasps: true", f"needs: {needs}")
    file.write_text(text.replace("actions:", LOOKING.replace("FORGETS", forgets).strip()))
    with pytest.raises(UseCaseError) as caught:
        read_use_case(file)
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            ("port: push_fit", "port: flange"),
            "component filter: port is flange, and must be one of",
        ),
        (("sterile: true", "sterile: 3"), "task H3: sterile is 3, and must be a bool, as False is"),
        (
            ("pressure_kpa: 40", "pressure_kpa: -1"),
            "pressure_kpa is -1, and must be a number from 0",
        ),
        (("pressure_kpa: 40", "pressure: 40"), "task H2: no characteristic pressure; the use case"),
        (('b: "pump:in"', 'b: "pump:up"'), "task H3, end b: no terminal pump:up"),
        (("comp: filter, x: 400", "comp: sieve, x: 400"), "filter:in: component sieve is missing"),
        (
            ("id: filter,", "id: pump,"),
            "components[1].id: expected a name of its own, found 'pump'",
        ),
        (("slot: [260, -150]", "slot: 3"), r"tasks[2].slot: expected two integers"),
        (("ways: [{path: [[580, 100]", "ways: [{path: [[1]"), r"tasks[2].ways[0].path.0: expected"),
        (("slot: [260, -150]", "meeting: [1, 1]\n    slot: [0, 0]"), "no method for hand_over"),
    ],
)
def test_malformed_orders_are_refused_with_the_place(tmp_path, change, message):
    file = tmp_path / "order.yaml"
    text = HOSES.read_text()
    assert change[0] in text
    file.write_text(text.replace(*change, 1))
    with pytest.raises(InstanceError) as caught:
        decomposed(file)
    assert message in str(caught.value)
