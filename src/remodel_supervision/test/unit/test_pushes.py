"""How often the robot pushes against a terminal that does not take an end, before a person follows.

Nothing is faked here but the cell: the charts are those that supervisors run, their decisions those
of the table of faults. The walk below follows a chart while one ability always fails with one code.
"""

from pathlib import Path

import pytest
import yaml
from house import house_order
from supervisor_bench import FakeAbilities, FakeCell, FakeEngine, FakeLoop

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.error_routes import codes_of_routes
from flexbe_synthesizer.core.chart.model import Behavior, Container
from remodel_states.core.codes import Code
from remodel_supervision.core.learning.experience import Experience
from remodel_supervision.core.recovery.decide import Failure, Spent, decide
from remodel_supervision.core.run import Operation
from remodel_supervision.core.runs.events import Decided, Part
from remodel_supervision.core.runs.gate import Gate, Permit
from remodel_supervision.edge.known_behaviors import behavior_charts, nested_charts
from remodel_supervision.edge.work_planner import WorkPlanner
from remodel_supervision.supervisors.ports import BehaviorEnd, EndKind
from remodel_supervision.supervisors.task_supervisor import TaskSupervisor
from remodel_tasks.core.orders.work_order import order_from
from remodel_tasks.core.task_charts.task_chart import emptying
from remodel_tasks.core.use_case.fault import Do, Policy
from remodel_tasks.edge.fault_file import read_error_names, read_faults
from remodel_tasks.edge.use_case_files import find_use_case, read_use_case

PACKAGE = Path(__file__).parents[3] / "remodel_tasks"
FAULTS = read_faults()
NESTED = nested_charts()
SHIPPED = [
    parse_chart(file.read_text(), str(file)) for file in sorted(behavior_charts().glob("*.xml"))
]
ASKED_AT_ONCE = sorted(
    code
    for name in FAULTS.names
    for code in FAULTS[name].codes
    if FAULTS[name].responses[0].do is Do.ASK_OPERATOR
)
PERSON_FIRST = [code for code in ASKED_AT_ONCE if FAULTS.of(code).stops_unattended]
ERROR_NAMES = read_error_names()
JAMMED, MISALIGNED = Code.INSERTION_JAMMED, Code.INSERTION_MISALIGNED
NO_CONTACT, SLIPPED = Code.INSERTION_NO_CONTACT, Code.SLIPPED_IN_GRIP
NOT_SEATED, PULLED_OUT, FORCE = Code.NOT_SEATED, Code.PULLED_OUT, Code.INSUFFICIENT_FORCE
NO_SUCCESS = {"failed", "command_error", "exhausted", "timed_out"}
ATTENDED, UNATTENDED = set(Do), set(Do) - {Do.ASK_OPERATOR}
ORDERS = ["connectors", "automotive_harness", "branched_harness", "cabinet", "dialysis_hoses"]


def routed(node, code):
    """Return where a state's error routes lead with a code; empty if none has it."""
    routes = zip(node.on_error, codes_of_routes(node.on_error, ERROR_NAMES), strict=True)
    return next((route.target for route, codes in routes if code in codes), "")


class Walk:
    """One run of a chart in which an ability always fails with a code."""

    def __init__(self, ability, code):
        self.failing = f"{ability}State"
        self.code = code
        self.visited = []

    def through(self, chart, path=""):
        """Return the outcome with which a chart ends."""
        nodes = {node.id: node for node in chart.nodes}
        outcomes = {outcome.name for outcome in chart.outcomes}
        target, visits = chart.initial, {}
        while target not in outcomes:
            node = nodes[target]
            visits[target] = visits.get(target, 0) + 1
            assert visits[target] < 20, "it is tried forever"
            if node.attempts is not None and visits[target] > node.attempts:
                target = {t.event: t.target for t in node.transitions}["exhausted"]
            else:
                target = self._after(node, f"{path}/{node.id}")
        return target

    def _after(self, node, path):
        targets = {t.event: t.target for t in node.transitions}
        if isinstance(node, Container):
            return targets[self.through(node.body, path)]
        if isinstance(node, Behavior):
            return targets[self.through(NESTED[node.type], path)]
        self.visited.append((path, node))
        if node.type != self.failing:
            return next(target for event, target in targets.items() if event not in NO_SUCCESS)
        return routed(node, self.code) or targets["failed"]

    def count(self, ability):
        return sum(node.type == f"{ability}State" for _, node in self.visited)


@pytest.fixture(scope="module", params=ORDERS)
def planner(request):
    if request.param == "connectors":
        use_case = read_use_case(PACKAGE / "test" / "use_cases" / "connectors.yaml")
        order = house_order(use_case)
    else:
        text = (PACKAGE / "examples" / f"{request.param}.yaml").read_text()
        order = order_from(yaml.safe_load(text))
        use_case = find_use_case(order.use_case)
    made = WorkPlanner(order, use_case, Experience(use_case), 0.0)
    made.plan([task.name for task in order.tasks])
    return made


def failed_for_good(planner, ability, code, possible):
    """Have a task fail with a code until something lasting is decided; return walks, decisions."""
    name = planner.order.tasks[0].name
    walks, decisions, codes = [], [], []
    while not decisions or not decisions[-1].do.is_lasting:
        walk = Walk(ability, code)
        assert walk.through(planner.chart(name, Part.WHOLE, (), decisions)) == "failed"
        walks.append(walk)
        codes.append(code)
        path = next(path for path, node in reversed(walk.visited) if node.type == walk.failing)
        forces = (("force_limit", "8.0"),)
        fault = FAULTS.diagnose(codes)
        failure = Failure(name, fault, code, ability, path, "no", 1.0, forces)
        earlier = [(each.fault, each.do) for each in decisions]
        spent = Spent(len(walks), 10.0, len(walks), 10.0)
        made = decide(failure, earlier, spent, Policy(), possible)
        decisions.append(
            Decided(
                name, fault.name, code, ability, path, "no", made.do, made.change, "", "policy", 1.0
            )
        )
    return walks, decisions


@pytest.mark.parametrize(
    ("possible", "lasting"), [(ATTENDED, Do.ASK_OPERATOR), (UNATTENDED, Do.SET_ASIDE)]
)
def test_a_jammed_terminal_is_pushed_against_twice_at_most(planner, possible, lasting):
    walks, decisions = failed_for_good(planner, "InsertCable", JAMMED, possible)
    assert [each.do for each in decisions] == [Do.LOOK_AGAIN, lasting]
    assert sum(walk.count("InsertCable") for walk in walks) == 2


def emptied_hands(planner):
    """Return the states that empty all hands of a task that is given up."""
    arms = planner.task(planner.order.tasks[0].name).arms
    return ["PlaceCableState" for _ in emptying(planner.use_case, arms)]


def test_a_jammed_end_is_withdrawn_before_the_wire_is_carried_away(planner):
    walk, name = Walk("InsertCable", JAMMED), planner.order.tasks[0].name
    walk.through(planner.chart(name, Part.WHOLE, (), ()))
    types = [node.type for _, node in walk.visited]
    jam = types.index("InsertCableState")
    # Where no action undoes it, the ability has drawn the end out itself.
    pulls = any(
        action.recover or action.is_behavior for action in planner.use_case.actions.values()
    )
    assert types[jam + 1 :] == ["ExtractCableState"] * pulls + emptied_hands(planner)


def test_what_is_serious_is_not_pulled_at_first(planner):
    walk, name = Walk("InsertCable", 307), planner.order.tasks[0].name
    walk.through(planner.chart(name, Part.WHOLE, (), ()))
    types = [node.type for _, node in walk.visited]
    assert types[types.index("InsertCableState") + 1 :] == emptied_hands(planner)


def test_the_second_push_is_made_from_what_another_viewpoint_shows(planner):
    walks, _ = failed_for_good(planner, "InsertCable", JAMMED, UNATTENDED)
    observing = {"LocateGearboxComponentState", "DetectCableState"}
    views = [
        {dict((p.name, p.value) for p in n.params).get("view", 0) for _, n in walk.visited
         if n.type in observing}
        for walk in walks
    ]  # fmt: skip
    assert views == [{0}, {1}]
    assert all(
        type(param.value) is int
        for _, node in walks[1].visited
        for param in node.params
        if param.name == "view"
    ), "the goal's field is an integer"


@pytest.mark.parametrize("possible", [ATTENDED, UNATTENDED], ids=["attended", "unattended"])
@pytest.mark.parametrize(
    ("ability", "code"),
    [("InsertCable", code) for code in (MISALIGNED, NO_CONTACT, SLIPPED, FORCE)]
    + [("FixCable", code) for code in (NOT_SEATED, PULLED_OUT)],
)
def test_no_terminal_is_pushed_against_more_than_nine_times(planner, ability, code, possible):
    walks, _ = failed_for_good(planner, ability, code, possible)
    pushes = [walk.count("InsertCable") for walk in walks]
    assert sum(pushes) <= 9, pushes


@pytest.mark.parametrize("ability", ["InsertCable", "RouteWire", "PickCable"])
def test_an_arm_that_was_stopped_by_something_does_not_go_there_again(planner, ability):
    if ability not in planner.use_case.expectations.stated:
        ability = "LayWire"
    for possible, lasting in ((ATTENDED, Do.ASK_OPERATOR), (UNATTENDED, Do.STOP)):
        walks, decisions = failed_for_good(planner, ability, 307, possible)
        assert [each.do for each in decisions] == [lasting]
        assert walks[0].count(ability) == 1


@pytest.mark.parametrize(
    ("possible", "lasting"), [(ATTENDED, Do.ASK_OPERATOR), (UNATTENDED, Do.SET_ASIDE)]
)
def test_while_an_end_is_stuck_no_new_wire_is_fed(possible, lasting):
    stuck = Failure("W1", FAULTS.of(306), 306, "ExtractCable", "/Extract a", "stuck", 1.0)
    assert decide(stuck, (), Spent(1, 1.0, 1, 1.0), Policy(), possible).do is lasting


class WalkedEngine(FakeEngine):
    """Its behaviors end when a chart was walked through."""

    def __init__(self, walk):
        super().__init__()
        self.walk = walk

    def start(self, behavior):
        self.end = None
        self.walk()
        self.end = BehaviorEnd(EndKind.FINISHED, "failed")


class SupervisedWalk(Walk):
    """A run of a chart whose states a supervisor grants; an ability fails once, with a code."""

    def __init__(self, chart, ability, code, event, lead):
        """Run the chart; `lead` (ability, code) fails before, if that is not None."""
        super().__init__(ability, code)
        self.event, self.lead = event, lead
        self.has_failed = False
        self.begun_after = []
        engine = WalkedEngine(lambda: self.through(chart))
        self.tasks = TaskSupervisor(
            FakeLoop(), engine, FakeAbilities(), FakeCell(), Gate(), lambda operation: None
        )
        self.tasks.stop_all(1.0)
        self.tasks.run(chart.name, lambda operation: None)

    def _after(self, node, path):
        targets = {t.event: t.target for t in node.transitions}
        if isinstance(node, Container | Behavior) or "command_error" not in targets:
            return super()._after(node, path)
        behavior, ability = self.tasks.behavior, node.type.removesuffix("State")
        permit, _ = self.tasks.begin_operation(behavior, path, ability)
        if permit is not Permit.GRANTED:
            return targets["command_error"]
        if self.has_failed:
            self.begun_after.append(path)
        code, event = self._end_of(node, ability)
        self.visited.append((path, node))
        goal = f"{path}#{len(self.visited)}"
        done = Operation(path, ability, event, code, "", 1.0, 1.0, goal)
        assert self.tasks.keep_record(behavior, done) == (True, "")
        if not code:
            return next(target for name, target in targets.items() if name not in NO_SUCCESS)
        return (routed(node, code) if event == "failed" else "") or targets[event]

    def _end_of(self, node, ability):
        """Return error code and outcome of an operation."""
        if node.type == self.failing and not self.has_failed:
            self.has_failed = True
            return self.code, self.event
        return (self.lead[1], "failed") if self.lead and ability == self.lead[0] else (0, "done")


def abilities_of(chart):
    """Return the abilities that a chart calls, in the behaviors that it nests as well."""
    found = set()
    for node in chart.nodes:
        if isinstance(node, Container):
            found |= abilities_of(node.body)
        elif isinstance(node, Behavior):
            found |= abilities_of(NESTED[node.type])
        elif "command_error" in {t.event for t in node.transitions}:
            found.add(node.type.removesuffix("State"))
    return found


# What fails before, so that a chart comes to the abilities with which it undoes something.
LEADS = [None, *(("InsertCable", code) for code in (JAMMED, MISALIGNED, SLIPPED))]


def charts_of(planner):
    """Return the charts of a task's parts; not all use cases can discard one."""
    parts = [Part.WHOLE, Part.AGAIN, Part.CLEAR] + [Part.DISCARD] * bool(planner.use_case.discard)
    name = planner.order.tasks[0].name
    return [planner.chart(name, part, (), ()) for part in parts]


@pytest.mark.parametrize("event", ["failed", "command_error"])
@pytest.mark.parametrize("code", PERSON_FIRST)
def test_nothing_of_a_behavior_begins_before_a_person_has_answered(planner, code, event):
    for chart in (*charts_of(planner), *SHIPPED):
        for ability in abilities_of(chart):
            walks = [SupervisedWalk(chart, ability, code, event, lead) for lead in LEADS]
            walks = [walk for walk in walks if walk.has_failed]
            assert walks, f"{chart.name} does not come to {ability}"
            assert [walk.begun_after for walk in walks] == [[]] * len(walks), chart.name


@pytest.mark.parametrize("code", ASKED_AT_ONCE)
@pytest.mark.parametrize("chart", SHIPPED, ids=lambda chart: chart.name)
def test_a_shipped_chart_ends_at_once_when_a_person_is_needed(chart, code):
    for ability in abilities_of(chart):
        walk = Walk(ability, code)
        walk.through(chart)
        assert walk.count(ability) <= 1
        assert not walk.count(ability) or walk.visited[-1][1].type == walk.failing
