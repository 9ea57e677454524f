"""The rest of an order is planned again at once, and no worse than it was."""

import gc
import random
import threading
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from remodel_production.core.board.board import board_of
from remodel_production.core.production import Component, Order, Side, Terminal, TerminalRef, Wire
from remodel_production.edge.design_files import catalogue_file, read_catalogue
from remodel_supervision.core.learning.experience import Call, Experience
from remodel_supervision.core.runs.events import Decided, Part
from remodel_supervision.edge import work_planner
from remodel_supervision.edge.work_planner import WorkPlanner
from remodel_tasks.core.decomposition.decomposition import Decomposer
from remodel_tasks.core.decomposition.preparation import prepare
from remodel_tasks.core.orders.board_order import board_order
from remodel_tasks.core.problem.part import defer, part_of
from remodel_tasks.core.problem.preferences import FORMAT
from remodel_tasks.core.problem.problem import Mode, Under
from remodel_tasks.core.search import tables_of
from remodel_tasks.core.use_case.fault import Do
from remodel_tasks.core.use_case.model import Bounds
from remodel_tasks.edge.anytime_planner import AnytimePlanner
from remodel_tasks.edge.search_kernel import Kernel, KernelSearch
from remodel_tasks.edge.use_case_files import read_use_case

GRIPPERS = read_use_case(Path(__file__).parents[3] / "remodel_tasks/test/use_cases/grippers.yaml")
LEARNING = replace(GRIPPERS, learned={"InsertCable": {"force_limit": Bounds(40.0, 32.0, 48.0, 5)}})
CATALOGUE = read_catalogue(catalogue_file())
WIRES = 40


def cabinet_order(arms):
    """Return an order of the wires of the board."""
    return board_order(cabinet_board(), GRIPPERS, arms)


@cache
def cabinet_board():
    """Return a board of wires between random terminals of eight devices."""
    chance = random.Random(3)
    ends = [(f"Q{i // 10}", f"{'TB'[i % 2]}{i}") for i in range(2 * WIRES)]
    terminals = {name: [] for name, _ in ends}
    for name, terminal in ends:
        terminals[name].append(Terminal(terminal, Side.TOP if terminal[0] == "T" else Side.BOTTOM))
    chance.shuffle(ends)
    wires = tuple(
        Wire(
            f"W{i}",
            TerminalRef(*ends[2 * i]),
            TerminalRef(*ends[2 * i + 1]),
            chance.choice(["BK", "BU", "RD"]),
            chance.choice([0.75, 1.5, 2.5, 6.0]),
            "test",
        )
        for i in range(WIRES)
    )
    components = tuple(Component(name, "", tuple(there)) for name, there in terminals.items())
    return board_of(Order("test", "", "", components, wires), CATALOGUE)


def planner_of(order, search_s=0.02, documents=()):
    experience = Experience(GRIPPERS)
    return WorkPlanner(order, GRIPPERS, experience, search_s, documents, clock=as_if_idle)


def as_if_idle():
    """Return a time that stands still: searches do all their work, on a busy machine too."""
    return 0.0


def planned(order, search_s=0.02, documents=()):
    """Return a planner of an order, and the names of its tasks as planned."""
    planner = planner_of(order, search_s, documents)
    return planner, planner.plan([task.name for task in order.tasks])


def modes_of(planner, names):
    """Return how a planner does tasks, by the kernel's numbers."""
    arms = [arm.name for arm in planner.order.arms]
    tasks = {name: planner.task(name) for name in names}
    return {
        name: Mode(arms.index(task.arms[0]), task.decomposition.first, len(task.arms) > 1).number
        for name, task in tasks.items()
    }


def cost(order, names, modes, last=()):
    """Return what doing the tasks of these names in this order costs."""
    tasks = tuple(task for task in order.tasks if task.name in names)
    tables = tables_of(
        defer(prepare(replace(order, tasks=tasks), GRIPPERS).preferred.problem, last)
    )
    number = {name: i for i, name in enumerate(tables.wires)}
    listed = np.array([number[name] for name in names], np.int32)
    kept = np.array([modes[name] for name in tables.wires], np.int32)
    planned = AnytimePlanner(Kernel(), tables).patched(listed, kept)
    assert [tables.wires[i] for i in planned.order] == list(names), "it is done in this order"
    return planned.cost


@pytest.mark.parametrize("arms", [1, 2])
@pytest.mark.parametrize("search_s", [0.0, 0.02])
def test_a_replan_costs_no_more_than_the_order_before_with_the_task_put_off(arms, search_s):
    order = cabinet_order(arms)
    planner, (done, failed, *rest) = planned(order, search_s)
    previous = (*rest, failed)
    before = cost(order, previous, modes_of(planner, previous), last=[failed])
    again = planner.plan(set(previous), previous, last=[failed])
    assert again[-1] == failed
    assert sorted(again) == sorted(previous)
    assert done not in again
    assert cost(order, again, modes_of(planner, again), last=[failed]) <= before


@pytest.mark.parametrize("arms", [1, 2])
def test_a_poor_order_is_improved(arms):
    order = cabinet_order(arms)
    planner, names = planned(order)
    previous = names[::-1]
    before = cost(order, previous, modes_of(planner, previous))
    again = planner.plan(names, previous)
    assert cost(order, again, modes_of(planner, again)) < before


def test_a_cable_that_is_begun_is_finished_first_but_for_a_core_put_off():
    plain = cabinet_order(2)
    x = {terminal.name: terminal.position_mm[0] for terminal in plain.terminals}
    reach = plain.arms[0].reach_mm
    cores = [t.name for t in plain.tasks if max(map(x.get, t.terminals)) <= reach[1]][:4]
    tasks = tuple(
        replace(t, characteristics={**t.characteristics, "cable": "C1" if t.name in cores else ""})
        for t in plain.tasks
    )
    planner, names = planned(replace(plain, tasks=tasks))
    first = min(map(names.index, cores))
    assert set(names[first : first + 4]) == set(cores)
    done = next(name for name in names if name in cores)
    left = [name for name in names if name != done]
    waiting = [name for name in left if name not in cores] + [n for n in left if n in cores]
    again = planner.plan(waiting, waiting)
    assert set(again[:3]) == set(cores) - {done}
    deferred = again[0]
    again = planner.plan(waiting, waiting, last=[deferred])
    assert set(again[:2]) == set(cores) - {done, deferred}
    assert again[-1] == deferred


def test_a_replan_prepares_and_decomposes_nothing_again(monkeypatch):
    planner, (first, *rest) = planned(cabinet_order(1))
    prepared, decomposed = [], []
    decompose = Decomposer.decompose
    monkeypatch.setattr(work_planner, "prepare", lambda *a, **b: prepared.append(a))
    monkeypatch.setattr(
        Decomposer, "decompose", lambda *a, **b: decomposed.append(a) or decompose(*a, **b)
    )
    again = planner.plan([*rest, first], [*rest, first])
    planner.plan(again[1:], again[1:])
    assert all(planner.expected_s(name) > 0 for name in again)
    assert (prepared, decomposed) == ([], [])
    assert planner.chart(again[1], Part.WHOLE, (), ()).name == f"Wire {again[1]}"
    assert len(decomposed) == 1, "the task whose turn it is"


def test_a_replan_searches_for_less_time_the_more_wires_there_are(monkeypatch):
    planner, names = planned(cabinet_order(1), search_s=0.05)
    limits = []
    replan = work_planner.replan_problem
    monkeypatch.setattr(
        work_planner, "replan_problem", lambda *a: limits.append(a[3]) or replan(*a)
    )
    planner.plan(names, names)
    monkeypatch.setattr(work_planner, "_FULL_SEARCH_WIRES", WIRES // 4)
    planner.plan(names, names)
    assert limits == [work_planner.REPLAN_SEARCH_S, work_planner.REPLAN_SEARCH_S / 4]


def test_no_garbage_is_collected_while_the_rest_is_planned_again(monkeypatch):
    planner, names = planned(cabinet_order(1))
    collecting, replan = [], work_planner.replan_problem
    monkeypatch.setattr(
        work_planner, "replan_problem", lambda *a: collecting.append(gc.isenabled()) or replan(*a)
    )
    planner.plan(names, names)
    assert collecting == [False]
    assert gc.isenabled()


def test_all_moves_of_a_search_are_done_in_its_own_thread(monkeypatch):
    planner, names = planned(cabinet_order(2))
    threads, anneal = [], KernelSearch.anneal

    def annealed(search, *arguments):
        threads.append(threading.get_ident())
        return anneal(search, *arguments)

    monkeypatch.setattr(KernelSearch, "anneal", annealed)
    planner.plan(names, names)
    assert threads
    assert threading.get_ident() not in threads


def test_what_is_left_of_a_preparation_is_what_preparing_it_gives():
    order = cabinet_order(2)
    preferences = {
        "format": FORMAT,
        "prefer": [
            {
                "name": "blue first",
                "pick": {"colour": "BU"},
                "before": "all",
                "weight": 2,
                "if_any": True,
            }
        ],
        "require": [
            {"name": "rank", "route": "all", "in_order_of": "section_mm2", "from": "least"}
        ],
    }
    whole = prepare(order, GRIPPERS, [("preferences", preferences)])
    chance = random.Random(3)
    for count in (1, 2, 13, WIRES):
        names = {f"W{i}" for i in chance.sample(range(WIRES), count)}
        tasks = tuple(task for task in order.tasks if task.name in names)
        alone = prepare(replace(order, tasks=tasks), GRIPPERS, [("preferences", preferences)])
        left = whole.only(names)
        assert left.order == alone.order
        assert left.plans == alone.plans
        mine, other = left.preferred.problem, alone.preferred.problem
        assert set(mine.tools) >= set(other.tools)
        assert ancestors(mine.unders) == ancestors(other.unders)
        assert replace(mine, tools=(), unders=()) == replace(other, tools=(), unders=())


def ancestors(unders):
    """Return what must come before each wire."""
    before = {}
    for under in unders:
        before.setdefault(under.after, set()).add(under.before)

    def of(wire):
        return set().union(*({each} | of(each) for each in before.get(wire, ())))

    return {wire: of(wire) for wire in before}


def test_a_preference_about_a_task_that_is_done_is_no_error():
    preferences = {"format": FORMAT, "require": [{"name": "below", "route": "W7", "before": "W8"}]}
    planner, names = planned(cabinet_order(1), documents=[("preferences", preferences)])
    assert names.index("W7") < names.index("W8")
    left = [name for name in names if name != "W7"]
    assert sorted(planner.plan(left, left)) == sorted(left)


def test_a_resumed_order_keeps_preferences_that_name_tasks_done_before():
    order = cabinet_order(1)
    preferences = {
        "format": FORMAT,
        "require": [
            {"name": "below", "route": "W7", "before": "W8"},
            {"name": "late", "route": "W8", "before": "W9"},
        ],
    }
    left = [task.name for task in order.tasks if task.name != "W7"]
    names = planner_of(order, documents=[("preferences", preferences)]).plan(left)
    assert sorted(names) == sorted(left)
    assert names.index("W8") < names.index("W9")


def test_tasks_put_off_come_last_unless_another_must_come_after_them():
    unders = (Under("W3", "W5"), Under("W5", "W6"))
    planner, names = planned(replace(cabinet_order(1), unders=unders))
    again = planner.plan(names, names, last=["W3", "W9"])
    assert sorted(again[-4:]) == ["W3", "W5", "W6", "W9"]
    assert again.index("W3") < again.index("W5") < again.index("W6")


def test_a_part_of_a_problem_keeps_what_its_wires_ask_for():
    problem = prepare(cabinet_order(1), GRIPPERS).preferred.problem
    ranking = problem.rankings[0]
    part = part_of(problem, ranking.groups[0])
    assert part.rankings == (), "wires of one rank can be picked in any order"
    assert [wire.name for wire in part.wires] == [
        wire.name for wire in problem.wires if wire.name in ranking.groups[0]
    ]


def test_a_task_that_was_never_planned_is_planned_alone():
    order = cabinet_order(1)
    planner = planner_of(order)
    assert planner.expected_s("W4") == 0.0
    assert planner.chart("W4", Part.WHOLE, (), ()).name == "Wire W4"
    names = [task.name for task in order.tasks]
    assert sorted(planner.plan(names, names)) == sorted(names)


def test_how_a_task_is_done_is_decided_again_when_it_was_planned_again():
    planner, names = planned(cabinet_order(1))
    before_s = planner.task(names[1]).decomposition.duration_s
    step = planner.task(names[0]).decomposition.steps[0]
    for _ in range(50):
        planner.experience.learn(Call("DetectCable", step.features, 0, 60.0))
    assert planner.task(names[1]).decomposition.duration_s == before_s
    planner.plan(names, names)
    assert planner.task(names[1]).decomposition.duration_s > before_s + 30


def test_the_chart_that_discards_is_a_part_of_a_task():
    order = cabinet_order(1)
    chart = planner_of(order).chart("W4", Part.DISCARD, (), ())
    assert chart.name == "Wire W4 Discard"
    assert [node.type for node in chart.nodes] == ["DiscardCableState"]


@pytest.mark.parametrize("arms", [1, 2])
def test_an_end_that_another_plan_has_connected_is_not_taken_for_the_last(arms):
    planner, names = planned(cabinet_order(arms))
    for name in names:
        first = planner.task(name).decomposition.first
        usual = planner.task(name, connected=first.letter)
        assert usual == planner.task(name)
        turned = planner.task(name, connected=first.other.letter)
        assert turned.arms == usual.arms[::-1]
        (inserted,) = (step.end for step in turned.left(first.other.letter) if is_insertion(step))
        assert inserted is first, f"{name}: {first.letter} is left"
        chart = planner.chart(name, Part.REST, first.other.letter, ())
        pushed = [node.id for node in chart.nodes if node.type == "InsertCableState"]
        assert pushed == [f"Insert {first.letter}"]
        with pytest.raises(ValueError, match=f"{name} connects {first.letter} first"):
            usual.left(first.other.letter)
    assert usual.left("ab") == ()


def test_a_task_begins_at_its_other_end_once_that_was_decided():
    planner, (name, *_) = planned(cabinet_order(1))
    first = planner.task(name).decomposition.first
    assert planner.has_other_end(name, ())
    where = ("slipped", 202, "InsertCable", "/Insert", "it slips")
    decided = (Decided(name, *where, Do.OTHER_END, (), because="so", by="policy", at_s=1.0),)
    turned = planner.task(name, decided)
    assert turned.decomposition.first is first.other
    assert not planner.has_other_end(name, decided), "once"
    after = planner.task(name, decided, connected=first.other.letter)
    assert after == turned, "what is connected then is not taken for the last"
    states = planner.chart(name, Part.WHOLE, (), decided).nodes
    pushed = [node.id for node in states if node.type == "InsertCableState"]
    assert pushed == [f"Insert {end.letter}" for end in (first.other, first)]


def test_the_end_that_a_use_case_states_stays_the_first():
    order = cabinet_order(1)
    fixed = replace(GRIPPERS, designs=replace(GRIPPERS.designs, first="a"))
    planner = WorkPlanner(order, fixed, Experience(fixed), 0.0)
    assert not planner.has_other_end(order.tasks[0].name, ())


def chosen_forces(requirements=(), use_case=LEARNING):
    """Return the forces that 40 attempts at a wire try instead of the use case's own."""
    document = {"format": FORMAT, "require": list(requirements)}
    order = board_order(cabinet_board(), use_case, 1)
    experience = Experience(use_case, explore=True)
    planner = WorkPlanner(order, use_case, experience, 0.02, [("preferences", document)])
    name = planner.plan([task.name for task in order.tasks])[0]
    attempts = [planner.choose(name, (), str(seed)) for seed in range(40)]
    forces = {each.value for chosen in attempts for each in chosen}
    for chosen in attempts:
        chart = planner.chart(name, Part.WHOLE, (), (), chosen=chosen)
        pushed = {p.value for node in chart.nodes for p in node.params if p.name == "force_limit"}
        assert pushed <= {40.0, *forces}
        assert {each.value for each in chosen} <= pushed
    return forces


def test_a_learned_force_replaces_the_stated_one_within_what_requirements_allow():
    gently = {"name": "gently", "insert": "all", "force_n": 44}
    assert max(chosen_forces()) > 44.0
    assert 40.0 < max(chosen_forces([gently])) <= 44.0


def test_a_force_that_an_action_states_as_a_number_is_not_learned():
    stated = replace(
        LEARNING.actions["push_in"], params=(("robot_name", "$arm"), ("force_limit", 40.0))
    )
    fixed = replace(LEARNING, actions={**LEARNING.actions, "push_in": stated})
    assert chosen_forces(use_case=fixed) == set()


def test_each_arm_that_has_a_part_in_a_task_is_cleared():
    planner, names = planned(cabinet_order(2))
    handed_over = 0
    for name in names:
        arms = planner.task(name).arms
        handed_over += len(arms) > 1
        chart = planner.chart(name, Part.CLEAR, (), ())
        cleared = [p.value for node in chart.nodes for p in node.params if p.name == "robot_name"]
        assert cleared == list(arms)
        following = [*(node.id for node in chart.nodes[1:]), "finished"]
        for node, then in zip(chart.nodes, following, strict=True):
            targets = {each.event: each.target for each in node.transitions}
            refused = "failed" if then == "finished" else then
            assert targets == {"placed": then, "failed": "failed", "command_error": refused}
    assert handed_over


def is_insertion(step):
    return step.action.type == "InsertCableState"
