"""Each state that needs no ROS, alone."""

import pytest

from flexbe_core.testing import run_state
from flexbe_states.calculation_state import CalculationState
from flexbe_states.check_condition_state import CheckConditionState
from flexbe_states.decision_state import DecisionState
from flexbe_states.flexible_calculation_state import FlexibleCalculationState
from flexbe_states.flexible_check_condition_state import FlexibleCheckConditionState
from flexbe_states.operator_decision_state import OperatorDecisionState
from flexbe_states.user_data_state import UserDataState


def fail(*args, **kwargs):
    raise ValueError("on purpose")


def result(state, **inputs):
    outcome, data = run_state(state, inputs)
    return outcome, data.get("output_value", "nothing")


def test_a_calculation_is_applied():
    assert result(CalculationState(lambda x: x + 1), input_value=1) == ("done", 2)


@pytest.mark.parametrize("function", [None, fail])
def test_a_failing_calculation_gives_none(function):
    assert result(CalculationState(function), input_value=1) == ("done", None)
    assert result(FlexibleCalculationState(function, ["a"]), a=1) == ("done", None)


def test_a_flexible_calculation_gets_keywords():
    state = FlexibleCalculationState(lambda a, b: a - b, ["b", "a"])
    assert result(state, a=5, b=3) == ("done", 2)


@pytest.mark.parametrize(("value", "outcome"), [(1, "true"), (0, "false")])
def test_a_condition_is_checked(value, outcome):
    assert run_state(CheckConditionState(lambda x: x > 0), {"input_value": value})[0] == outcome
    flexible = FlexibleCheckConditionState(lambda values: values[0] > values[1], ["a", "b"])
    assert run_state(flexible, {"a": value, "b": 0})[0] == outcome


def test_a_failing_condition_is_false_at_first():
    assert run_state(CheckConditionState(fail), {"input_value": 1})[0] == "false"
    assert run_state(FlexibleCheckConditionState(fail, ["a"]), {"a": 1})[0] == "false"


def test_a_function_decides_when_it_names_an_outcome():
    answers = iter(["?", fail, "b"])

    def choose(value):
        answer = next(answers)
        return answer() if answer is fail else answer

    assert run_state(DecisionState(["a", "b"], choose), {"input_value": 1})[0] == "b"


def test_an_operator_is_waited_for_without_a_suggestion():
    assert run_state(OperatorDecisionState(["a"], hint=None))[0] is None
    assert run_state(OperatorDecisionState(["a"], suggestion="other"))[0] is None
    assert run_state(OperatorDecisionState(["a"], suggestion="a"))[0] == "a"


def test_a_constant_is_provided():
    outcome, data = run_state(UserDataState([1, 2]))
    assert (outcome, data["data"]) == ("done", [1, 2])
