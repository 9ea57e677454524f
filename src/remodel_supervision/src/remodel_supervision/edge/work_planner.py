"""Plans what is left of an order: its tasks' order, and how each is done."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from itertools import chain

from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.synthesis import garbage_kept
from remodel_production.edge.design_files import read_abilities
from remodel_supervision.core.learning.experience import Call, Experience, numbers_from
from remodel_supervision.core.recovery.decide import (
    VIEW,
    Adjustable,
    observing_from,
    with_parameters,
)
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import Chosen, Decided, Part
from remodel_supervision.edge.known_behaviors import nested_charts
from remodel_tasks.core.decomposition.preparation import Prepared, prepare
from remodel_tasks.core.orders.work_order import WorkOrder
from remodel_tasks.core.plan.explanation import listing_of
from remodel_tasks.core.problem.part import defer, gathered, with_first
from remodel_tasks.core.problem.problem import Mode
from remodel_tasks.core.task_charts.planned_tasks import (
    Demands,
    PlannedTask,
    continuing_from,
    demands_of,
    escalating,
    planned_task,
    planned_tasks,
    with_other_end,
    with_other_method,
)
from remodel_tasks.core.task_charts.task_chart import step_of
from remodel_tasks.core.use_case.fault import Do
from remodel_tasks.core.use_case.model import UseCase
from remodel_tasks.edge.anytime_planner import plan_problem, replan_problem

# [s] wall time that the search gets when the rest of an order is planned again: what it starts from
# is the result of a longer search, and the robot waits. Beyond so many wires it gets less in
# proportion: the moves that open each search find nearly all there is to find (docs/planning.md).
REPLAN_SEARCH_S = 0.03
_FULL_SEARCH_WIRES = 100


@dataclass(frozen=True)
class _Place:
    """How the latest plan does a task, and the preparation that the plan was made from."""

    prepared: Prepared
    mode: Mode


def replan_search_s(wires: int) -> float:
    """Return the wall time [s] of the search when so many wires are planned again."""
    return REPLAN_SEARCH_S * min(1.0, _FULL_SEARCH_WIRES / max(1, wires))


class WorkPlanner:
    """Plans one order of one use case.

    Tasks are decomposed for the first plan, and all their charts are built once, to find what a use
    case asks for in vain before anything moves. Later plans go by the same decompositions; how a
    task is done is decided again, by what runs have taught since, when its turn comes.

    Attributes:
        order: what is to be done.
        use_case: how such work is done.
        experience: what runs have taught.
        demands: of the first plan on the cell; none of a run that is resumed, which a cell has
            accepted before.
    """

    def __init__(
        self,
        order: WorkOrder,
        use_case: UseCase,
        experience: Experience,
        search_s: float,
        documents: Sequence[tuple[str, object]] = (),
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Take the order.

        Args:
            order: what is to be done.
            use_case: how such work is done.
            experience: what runs have taught; it learns from this one too.
            search_s: [s] of wall time that a search for the best order gets.
            documents: preferences, parsed, with what to call them in errors.
            clock: of searches [s]; see AnytimePlanner.improved.
        """
        self.order = order
        self.use_case = use_case
        self.experience = experience
        self.demands = Demands()
        self._search_s = search_s
        self._documents = documents
        self._clock = clock
        self._adjustable = Adjustable(
            {each.name: {p.name: p.type for p in each.parameters} for each in read_abilities()},
            nested_charts(),
        )
        self._prepared: Prepared | None = None
        self._places: dict[str, _Place] = {}
        self._tasks: dict[str, PlannedTask] = {}

    @garbage_kept()
    def plan(
        self,
        names: Collection[str],
        previous: Sequence[str] = (),
        last: Collection[str] = (),
    ) -> tuple[str, ...]:
        """Return the tasks of these names in the best order that is found in time.

        Garbage cycles are not collected meanwhile: the thousands of objects of a plan would have
        the collector look through the whole process now and then, while the robot waits.

        Args:
            names: of the tasks.
            previous: their order so far, when they are planned again: tasks that were prepared
                before are not prepared again, the search starts from this order and is short, and
                the result costs no more than this order. Empty for a first plan.
            last: tasks that come after all others, as far as the order's constraints let them.

        Raises:
            InstanceError: if there is no plan.
        """
        wanted, base = set(names), self._prepared
        if base is None or not previous or not base.plan_of.keys() >= wanted:
            base = self._prepare(wanted)
        self._prepared = base
        prepared = base.only(wanted) if base.plan_of.keys() > wanted else base
        begun = [cores for cores in self.order.cables.values() if not wanted.issuperset(cores)]
        first = wanted.intersection(chain(*begun)).difference(last)
        problem = defer(with_first(prepared.preferred.problem, first), last)
        if previous:
            modes = {name: place.mode.number for name, place in self._places.items()}
            search_s = min(self._search_s, replan_search_s(len(wanted)))
            planned = replan_problem(problem, previous, modes, search_s, self._clock)
        else:
            search_s = self._search_s if len(wanted) > 1 else 0.0
            planned = plan_problem(problem, search_s, self._clock)
        if not previous and not self._places.keys() >= wanted:
            # What its use case asks for in vain is reported before it begins.
            self.demands = demands_of(task.chart for task in planned_tasks(prepared, planned.plan))
        planned_modes = listing_of(problem, planned.plan).modes
        self._tasks = {name: task for name, task in self._tasks.items() if name not in wanted}
        self._places |= {name: _Place(base, mode) for name, mode in planned_modes.items()}
        return gathered(problem, planned.wires)

    def _prepare(self, names: set[str]) -> Prepared:
        """Return tasks ready for planning; preferences are about the order's other tasks, too."""
        expectations = self.experience.expectations
        if self._documents:
            whole = prepare(self.order, self.use_case, self._documents, expectations=expectations)
            return whole.only(names)
        tasks = tuple(task for task in self.order.tasks if task.name in names)
        order = replace(self.order, tasks=tasks)
        return prepare(order, self.use_case, expectations=expectations)

    def task(
        self, name: str, decisions: Sequence[Decided] = (), connected: Collection[str] = ()
    ) -> PlannedTask:
        """Return a task as it is planned, by the methods that are left after some decisions.

        Args:
            name: of the task.
            decisions: about it so far.
            connected: letters of its ends that sit in their terminals. An earlier plan may have
                connected the end that comes last in this one; then that end comes first.

        Raises:
            InstanceError: if there is no plan for it.
        """
        task = self._tasks.get(name)
        if task is None:
            place = self._place(name)
            task = self._tasks[name] = planned_task(place.prepared, name, place.mode)
        if any(decision.do is Do.OTHER_END for decision in decisions):
            task = with_other_end(self._place(name).prepared, task) or task
        task = continuing_from(self._place(name).prepared, task, connected)
        for decision in decisions:
            if decision.do is Do.OTHER_METHOD:
                task = self._otherwise(task, decision.state_path) or task
        return task

    def expected_s(self, name: str) -> float:
        """Return how long a task is expected to take [s]; 0 as long as it is not planned."""
        task, place = self._tasks.get(name), self._places.get(name)
        if task is not None:
            return task.decomposition.duration_s
        return place.prepared.decomposition(name, place.mode).duration_s if place else 0.0

    def has_other_method(self, name: str, decisions: Sequence[Decided], state_path: str) -> bool:
        """Return whether the step of a task that a state is of can be done by another method."""
        return self._otherwise(self.task(name, decisions), state_path) is not None

    def has_other_end(self, name: str, decisions: Sequence[Decided]) -> bool:
        """Return whether a task can be done with its other end first, and was not yet."""
        if any(decision.do is Do.OTHER_END for decision in decisions):
            return False
        return with_other_end(self._place(name).prepared, self.task(name)) is not None

    def learn(self, name: str, operation: Operation) -> None:
        """Learn from an operation of a task."""
        steps = self._tasks[name].decomposition.steps if name in self._tasks else ()
        title = step_of(operation.state_path)
        step = next((step for step in steps if step.title == title), None)
        if step is not None:
            self.experience.learn(
                Call(
                    operation.ability,
                    step.features,
                    operation.error_code,
                    operation.elapsed_s,
                    parameters=numbers_from(operation.parameters),
                )
            )

    def choose(self, name: str, decisions: Sequence[Decided], seed: str) -> tuple[Chosen, ...]:
        """Return the parameters by which a task is to be done, other than its use case's own.

        What the use case's actions state of a parameter stays, unless it is the force.

        Args:
            name: of the task.
            decisions: about the task so far.
            seed: of what is left to chance.
        """
        task = self.task(name, decisions)
        chosen = (
            Chosen(step.title, ability, parameter, value)
            for step in task.decomposition.steps
            for ability in step.action.abilities
            for parameter, value in self.experience.parameters(
                ability, step.features, task.bounds(step.title), f"{seed} {step.title}"
            ).items()
            if step.action.leaves_open(parameter)
        )
        chart = task.chart
        return tuple(each for each in chosen if self._with(each, chart) != chart)

    def _with(self, chosen: Chosen, chart: Chart) -> Chart:
        """Return a chart with a parameter."""
        types = self._adjustable.parameters.get(chosen.ability, {})
        parameters = {chosen.ability: {p: t for p, t in types.items() if p == chosen.parameter}}
        adjustable = replace(self._adjustable, parameters=parameters)
        return with_parameters(chart, chosen.step, {chosen.parameter: chosen.value}, adjustable)

    def chart(
        self,
        name: str,
        part: Part,
        connected: Collection[str],
        decisions: Sequence[Decided],
        chosen: Sequence[Chosen] = (),
    ) -> Chart:
        """Return the chart of a part of a task.

        Args:
            name: of the task.
            part: which.
            connected: letters of the ends that sit in their terminals.
            decisions: about the task so far; they outdo what was chosen.
            chosen: parameters.
        """
        task = self.task(name, decisions, connected)
        if part is Part.CLEAR:
            return task.clear()
        if part is Part.DISCARD:
            return task.discard()
        chart = task.rest(connected) if part is Part.REST else task.chart
        for each in chosen:
            chart = self._with(each, chart)
        for decision in decisions:
            values, where = dict(decision.change), decision.state_path
            if decision.do is Do.LOOK_AGAIN and values:
                chart = observing_from(chart, int(values[VIEW]), self._adjustable)
            elif values:
                chart = with_parameters(chart, where, values, self._adjustable)
        return escalating(chart)

    def _otherwise(self, task: PlannedTask, state_path: str) -> PlannedTask | None:
        return with_other_method(self._place(task.name).prepared, task, state_path)

    def _place(self, name: str) -> _Place:
        """Return how a task is done; one that was not planned is planned alone."""
        if name not in self._places:
            prepared = self._prepare({name})
            plan = plan_problem(prepared.preferred.problem, 0.0).plan
            modes = listing_of(prepared.preferred.problem, plan).modes
            self._places[name] = _Place(prepared, modes[name])
        return self._places[name]
