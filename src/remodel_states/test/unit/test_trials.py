"""What the conformance command is given, and when it cancels a goal."""

import pytest
from remodel_msgs.msg import DetectCableAction, PlaceCableGoal, PlaceCableResult

from remodel_states.conformance.clauses import CANCEL
from remodel_states.conformance.probe import GoalError, action_class, read_goal
from remodel_states.conformance.rules import Exchange, Result
from remodel_states.conformance.trial import Trials


@pytest.mark.parametrize("name", ["DetectCable", "DetectCableAction", "remodel_msgs/DetectCable"])
def test_an_action_has_several_names(name):
    assert action_class(name) is DetectCableAction


@pytest.mark.parametrize(
    "name", ["a/b/c", "/x", "x/", "", "std_msgs/String", "no_such_package/Grasp", "DetectCables"]
)
def test_what_is_no_action_is_refused(name):
    with pytest.raises(GoalError, match=r"no action|cannot load"):
        action_class(name)


@pytest.mark.parametrize(
    ("source", "found"),
    [("raise RuntimeError('no drivers')", "RuntimeError: no drivers"), ("class (", "SyntaxError")],
)
def test_a_package_that_cannot_be_imported_is_named(tmp_path, monkeypatch, source, found):
    package = f"broken_{found.partition(':')[0].lower()}"
    (tmp_path / package / "msg").mkdir(parents=True)
    (tmp_path / package / "__init__.py").write_text("")
    (tmp_path / package / "msg/__init__.py").write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(GoalError, match=f"cannot load {package}/GraspAction: {found}"):
        action_class(f"{package}/Grasp")


@pytest.mark.parametrize(
    "text",
    [
        "{timeout: abc}",
        "{timeout: 2020-99-99}",
        "{id: 5}",
        "{robot_name: [1]}",
        "{robot_name: {a: 1}}",
        "{target_pose: {pose: {position: {x: ~}}}}",
    ],
)
def test_a_goal_with_a_value_of_another_type_is_refused(text):
    with pytest.raises(GoalError, match=r"does not fit|cannot read the goal"):
        read_goal(action_class("PlaceCable"), text)


def test_a_goal_may_have_names_in_any_script():
    assert (
        read_goal(action_class("PlaceCable"), "{cable_id: Größe, timeout: 3}").cable_id == "Größe"
    )


BEGINS_AT_S = 1.0


class SlowMachine:
    """Where goals reach the server late, and cancels at once: those have a connection of their own.

    As actionlib does, it ends a goal that was cancelled before it arrived with an empty result.
    """

    def __init__(self):
        self.now_s = 0.0

    def send(self, goal):
        self.sent_s = self.now_s
        self.exchange = Exchange(goal, self.now_s)
        return self.exchange

    def cancel(self, exchange):
        is_late = self.now_s < self.sent_s + BEGINS_AT_S
        result = PlaceCableResult()
        if not is_late:
            result = PlaceCableResult(id=exchange.goal.id, error_code=2, error_message="cancelled")
            result.elapsed_time = self.now_s - self.sent_s
        exchange.cancelled_wall_s = self.now_s
        exchange.results.append(Result(self.now_s, self.now_s, 2, "", result))

    def wait(self, condition, limit_s):
        end = self.now_s + limit_s
        while not condition() and self.now_s < end:
            self.now_s += 0.1
            if self.now_s >= self.sent_s + BEGINS_AT_S:
                self.exchange.active_ros_s = self.now_s
        return condition()


def test_a_goal_is_cancelled_only_when_the_server_works_on_it():
    trials = Trials(SlowMachine(), PlaceCableGoal(id="good", timeout=3.0), {0, 2})
    trials._nominal_s = 0.6
    trial = trials._cancel()
    assert (trial.name, trial.faults, trial.unjudged) == (CANCEL.name, (), "")


@pytest.mark.parametrize(
    ("command", "problem"),
    [
        ("sleep 3 &", ""),  # as one that starts a server
        ("echo no arm >&2; exit 3", "the command failed with 3: no arm"),
        ("exec sleep 3", "the command did not end within 1 s"),
    ],
)
def test_a_restart_ends_with_its_command(command, problem):
    trials = Trials(SlowMachine(), PlaceCableGoal(id="good", timeout=3.0), {0}, command, 1.0)
    assert trials._restart_problem() == problem
