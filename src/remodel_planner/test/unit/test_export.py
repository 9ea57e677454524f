"""What is exported parses, and states the costs of the plan; the benchmarks solve it."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pddl.parser.domain import DomainParser
from pddl.parser.problem import ProblemParser
from random_panel import random_panel

from remodel_pddl import hddl, pddl
from remodel_pddl.symbolic import steps_of, symbols_of
from remodel_planner.commands import export as export_command
from remodel_planner.commands import plan as plan_command
from remodel_production.errors import InstanceError
from remodel_tasks.core.problem.instance import problem_from
from remodel_tasks.core.problem.part import first_picks
from remodel_tasks.core.problem.problem import Plan
from remodel_tasks.edge.anytime_planner import plan_problem

# The action's static function, and which of its parameters that takes.
COSTS = {
    "change-tool": ("change-cost", (0,)),
    "pick-heavy": ("pick-cost", (2, 3, 0, 4)),
    "pick-light": ("pick-cost", (2, 3, 0, 4)),
    "violate-soft-order": ("soft-order-weight", (0,)),
    "aim": ("approach", (0, 1)),
    "locate": ("look-cost", ()),
    "insert-first": ("insert-cost", (0, 1)),
    "insert-second": ("insert-cost", (0, 1)),
    "route": ("route-cost", (0,)),
    "fix": ("fix-cost", (0,)),
}


def problem(wires, seed):
    data = random_panel(wires, seed, 1)
    names = [wire["id"] for wire in data["wires"]]
    data["soft_order"] = [{"groups": [names[::2], names[1::2]], "weight": 4}]
    data["weights"]["cable"] = 30
    for number, wire in enumerate(data["wires"]):
        wire |= {"cable": f"C{seed * number % 5}"} if number % 3 else {}
    return problem_from(data)


def test_domain_and_problem_parse():
    # This parser reads no functions without that requirement.
    domain = DomainParser()(pddl.domain_text(has_numeric_fluents=True))
    assert {action.name for action in domain.actions} == {*COSTS, "keep-soft-order", "take"}
    parsed = ProblemParser()(pddl.problem_text(symbols_of(problem(12, 3))))
    assert parsed.domain_name == domain.name
    wires = [name for name in parsed.objects if name.type_tag == "wire"]
    assert len(wires) == 12


def test_the_hierarchical_domain_has_the_same_actions_and_its_tasks():
    text = hddl.domain_text()
    assert pddl.ACTIONS in text
    for task in ("wire-all", "lay-wire", "equip", "resolve", "put-in"):
        assert f"(:task {task} :parameters" in text
        assert f":task ({task}" in text
    stated = hddl.problem_text(symbols_of(problem(5, 1)))
    assert "(:htn\n    :ordered-subtasks (and (wire-all)))" in stated
    assert text.count("(") == text.count(")")
    assert stated.count("(") == stated.count(")")


@given(st.integers(2, 30), st.integers(0, 999))
def test_the_exported_plan_costs_what_the_plan_does(wires, seed):
    stated = problem(wires, seed)
    planned = plan_problem(stated, 0.01)
    symbols = symbols_of(stated)
    value = {cost.term: cost.value for cost in symbols.costs}
    total = 0
    for name, *parameters in steps_of(stated, planned.plan, symbols):
        if name in COSTS:
            function, places = COSTS[name]
            total += value[function, *(parameters[i] for i in places)]
    assert total == planned.cost + first_picks(stated)


def test_what_cannot_be_exported_is_refused():
    with pytest.raises(InstanceError, match="has 2 arms"):
        symbols_of(problem_from(random_panel(4, 1, 2)))
    data = random_panel(4, 1, 1)
    wire = data["wires"][0]["id"]
    data["init"]["arms"]["A"]["holding"] = wire
    data["init"]["wires"] = {wire: {"stage": "held"}}
    with pytest.raises(InstanceError, match=f"the arm holds wire {wire}"):
        symbols_of(problem_from(data))
    stated = problem(4, 1)
    plan = plan_problem(stated, 0.01).plan
    located = next(i for i, action in enumerate(plan.actions) if action.kind.value == "locate")
    early = Plan(plan.problem, (plan.actions[located], *plan.actions[: located - 1]))
    with pytest.raises(InstanceError, match="earlier than needed"):
        steps_of(stated, early, symbols_of(stated))


def test_the_command_states_numeric_fluents_on_demand(tmp_path, capsys):
    instance = tmp_path / "panel.json"
    instance.write_text(json.dumps(random_panel(5, 1, 1)))
    for form in ("pddl", "hddl"):
        options = [str(instance), "--format", form, "--output", str(tmp_path)]
        for asked, stated in (([], False), (["--numeric-fluents"], True)):
            assert export_command.main([*options, *asked]) == 0
            domain = (tmp_path / f"domain.{form}").read_text()
            assert (":numeric-fluents" in domain) == stated
    assert (
        export_command.main(
            [str(instance), "--format", "pddl", "--numeric-fluents", "--output", str(tmp_path)]
        )
        == 0
    )
    domain = DomainParser()((tmp_path / "domain.pddl").read_text())
    assert ProblemParser()((tmp_path / "problem.pddl").read_text()).domain_name == domain.name


def test_the_command_writes_all_files(tmp_path, capsys):
    instance, plan = tmp_path / "panel.json", tmp_path / "plan.json"
    instance.write_text(json.dumps(random_panel(5, 1, 1)))
    assert plan_command.main([str(instance), "--output", str(plan), "--time-limit=0"]) == 0
    capsys.readouterr()
    folder = tmp_path / "out" / "pddl"
    options = ["--format", "pddl", "--output", str(folder)]
    assert export_command.main([str(instance), str(plan), *options]) == 0
    printed = capsys.readouterr().out.split()
    assert printed == [str(folder / name) for name in ("domain.pddl", "problem.pddl", "plan.txt")]
    cost = (folder / "plan.txt").read_text().splitlines()[-1]
    assert cost.startswith("; cost = ")
    assert export_command.main([str(instance), *options[:2], "--output", str(plan)]) == 1
    assert f"{plan}: cannot be made a folder: File exists" in capsys.readouterr().err
    document = json.loads(plan.read_text())
    document["actions"].pop()
    plan.write_text(json.dumps(document))
    assert export_command.main([str(instance), str(plan), *options]) == 1
    assert export_command.main([str(plan), *options]) == 1
