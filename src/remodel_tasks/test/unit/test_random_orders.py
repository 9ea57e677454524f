"""Random orders of all use cases: every plan is valid, and every task has its chart."""

from hypothesis import given
from hypothesis import strategies as st

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.check.check import check_chart
from remodel_production.errors import InstanceError
from remodel_tasks.core.decomposition.preparation import prepare
from remodel_tasks.core.orders.work_order import Route, RouteClip, Task, WorkOrder
from remodel_tasks.core.plan.checker import check
from remodel_tasks.core.problem.problem import ActionKind, PlannedArm, PlannedTerminal
from remodel_tasks.core.task_charts.planned_tasks import planned_tasks
from remodel_tasks.edge.anytime_planner import plan_problem
from remodel_tasks.edge.use_case_files import find_use_case

USE_CASES = [
    find_use_case(name) for name in ("automotive_formboard", "branched_harness", "medical_hoses")
]
PLACES = st.tuples(st.integers(0, 1000), st.integers(0, 500))


def values(characteristic):
    """Return what a characteristic may be; for colours, some."""
    if characteristic.allowed:
        return st.sampled_from(characteristic.allowed)
    if isinstance(characteristic.default, bool):
        return st.booleans()
    if isinstance(characteristic.default, str):
        return st.sampled_from([characteristic.default, "red"])
    least, most = int(characteristic.least) + 1, int(characteristic.most)
    return st.integers(least, max(least, min(most, 25)))


def stated(characteristics):
    optional = {name: values(c) for name, c in characteristics.items()}
    return st.fixed_dictionaries({}, optional=optional)


@st.composite
def orders(draw):
    use_case = draw(st.sampled_from(USE_CASES))
    hands_over = "hand_over" in use_case.methods
    count = draw(st.integers(1, 5))
    components = {f"K{i}": draw(stated(use_case.component_characteristics)) for i in range(3)}
    terminals, tasks = [], []
    for i in range(count):
        ends = [draw(PLACES), draw(PLACES)]
        names = [f"K{draw(st.integers(0, 2))}:{i}{letter}" for letter in "ab"]
        terminals += [
            PlannedTerminal(name, name.partition(":")[0], place)
            for name, place in zip(names, ends, strict=True)
        ]
        middle = draw(PLACES)
        clips = tuple(RouteClip(f"C{i}{j}", middle) for j in range(draw(st.integers(0, 2))))
        tasks.append(
            Task(
                f"T{i}",
                (names[0], names[1]),
                draw(PLACES),
                draw(stated(use_case.task_characteristics)),
                routes=(
                    Route((ends[0], middle, ends[1]), clips, draw(st.sampled_from([(), ("s",)]))),
                ),
                meeting_mm=draw(PLACES) if hands_over and draw(st.booleans()) else None,
            )
        )
    reaches = draw(st.sampled_from([((0, 1000),), ((0, 700), (300, 1000)), ((0, 1000), (0, 1000))]))
    arms = tuple(
        PlannedArm(f"R{i}", (500, -100), reach, (500, 0), tool="narrow", holding=None)
        for i, reach in enumerate(reaches)
    )
    return use_case, WorkOrder(
        "random", use_case.name, arms, components, terminals=tuple(terminals), tasks=tuple(tasks)
    )


@given(orders())
def test_plans_of_random_orders_are_valid_and_their_tasks_have_charts(library, drawn):
    use_case, order = drawn
    try:
        prepared = prepare(order, use_case)
    except InstanceError as error:
        assert "unreachable" in str(error)
        return
    planned = plan_problem(prepared.preferred.problem, 0.005)
    assert check(prepared.preferred.problem, planned.plan).violations == ()
    tasks = list(planned_tasks(prepared, planned.plan))
    assert sorted(task.name for task in tasks) == sorted(task.name for task in order.tasks)
    for task in tasks:
        assert parse_chart(write_chart(task.chart), "task.xml") == task.chart
        assert check_chart(task.chart, library, {}).problems == ()
        handed = [a for a in planned.plan.actions if a.wire == task.name]
        gives = any(action.kind is ActionKind.HAND_OVER for action in handed)
        assert len(task.arms) == 1 + gives
