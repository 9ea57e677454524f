"""How often the robot pushes against a terminal that does not take an end, before a person follows.

Nothing is faked here but the cell: the charts are those that supervisors run, their decisions those
of the table of faults. The walk below follows a chart while one ability always fails with one code.
"""

from pathlib import Path

import pytest
import yaml
from house import HOUSE

from flexbe_synthesizer.core.chart.error_routes import codes_of_routes
from flexbe_synthesizer.core.chart.model import Behavior, Container
from remodel_planner.core.cell_order import cell_order
from remodel_planner.core.learning.experience import Experience
from remodel_planner.core.panel_layout import PanelRules, lay_out
from remodel_planner.core.recovery.decide import decide
from remodel_planner.core.recovery.failure import Failure, Spent
from remodel_planner.core.recovery.fault import Do
from remodel_planner.core.recovery.policy import Policy
from remodel_planner.core.supervision.events import Decided, Part
from remodel_planner.core.use_case.work_order import order_from
from remodel_planner.edge.catalogue_file import read_catalogue
from remodel_planner.edge.fault_file import read_error_names, read_faults
from remodel_planner.edge.nested_charts import nested_charts
from remodel_planner.edge.use_case_files import find_use_case
from remodel_planner.edge.work_planner import WorkPlanner
from remodel_states.core.codes import Code

PACKAGE = Path(__file__).parents[2]
FAULTS = read_faults()
NESTED = nested_charts()
ERROR_NAMES = read_error_names()
JAMMED, MISALIGNED = Code.INSERTION_JAMMED, Code.INSERTION_MISALIGNED
NO_CONTACT, SLIPPED = Code.INSERTION_NO_CONTACT, Code.SLIPPED_IN_GRIP
NOT_SEATED, PULLED_OUT, FORCE = Code.NOT_SEATED, Code.PULLED_OUT, Code.INSUFFICIENT_FORCE
NO_SUCCESS = {"failed", "command_error", "exhausted", "timed_out"}
ATTENDED, UNATTENDED = set(Do), set(Do) - {Do.ASK_OPERATOR}
ORDERS = ["house", "automotive_harness", "branched_harness", "cabinet", "dialysis_hoses"]


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
            assert visits[target] < 20, "it is tried for ever"
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
        routed = codes_of_routes(node.on_error, ERROR_NAMES)
        taken = (
            r.target for r, codes in zip(node.on_error, routed, strict=True) if self.code in codes
        )
        return next(taken, targets["failed"])

    def count(self, ability):
        return sum(node.type == f"{ability}State" for _, node in self.visited)


@pytest.fixture(scope="module", params=ORDERS)
def planner(request):
    if request.param == "house":
        catalogue = read_catalogue(PACKAGE / "config" / "catalogue.yaml")
        order = cell_order(lay_out(HOUSE, catalogue, PanelRules()))
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


def test_a_jammed_end_is_withdrawn_before_the_wire_is_carried_away(planner):
    walk = Walk("InsertCable", JAMMED)
    walk.through(planner.chart(planner.order.tasks[0].name, Part.WHOLE, (), ()))
    types = [node.type for _, node in walk.visited]
    jam = types.index("InsertCableState")
    assert types[jam + 1] == "ExtractCableState"
    assert types[jam + 2 :] == ["PlaceCableState"]


def test_what_is_serious_is_not_pulled_at_first(planner):
    walk = Walk("InsertCable", 307)
    walk.through(planner.chart(planner.order.tasks[0].name, Part.WHOLE, (), ()))
    types = [node.type for _, node in walk.visited]
    assert types[types.index("InsertCableState") + 1 :] == ["PlaceCableState"]


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
    for possible, lasting in ((ATTENDED, Do.ASK_OPERATOR), (UNATTENDED, Do.STOP)):
        walks, decisions = failed_for_good(planner, ability, 307, possible)
        assert [each.do for each in decisions] == [lasting]
        assert walks[0].count(ability) == 1


@pytest.mark.parametrize(
    ("possible", "lasting"), [(ATTENDED, Do.ASK_OPERATOR), (UNATTENDED, Do.STOP)]
)
def test_while_an_end_is_stuck_no_new_wire_is_fed(possible, lasting):
    stuck = Failure("W1", FAULTS.of(306), 306, "ExtractCable", "/Extract a", "stuck", 1.0)
    assert decide(stuck, (), Spent(1, 1.0, 1, 1.0), Policy(), possible).do is lasting
