"""Cases that need no running nodes."""

import pytest

from flexbe_testing.core.case import Case
from flexbe_testing.ros.run_case import run_case

STATES = "flexbe_states"


def case(module, class_name, **keys):
    return Case("it", f"{STATES}.{module}", class_name, **keys)


def test_a_state_that_does_what_it_should():
    verdict = run_case(
        case(
            "calculation_state",
            "CalculationState",
            params={"calculation": "lambda x: 2 * x"},
            inputs={"input_value": 2},
            outputs={"output_value": 4},
            outcome="done",
        )
    )
    assert verdict.complaints == ()


def test_a_state_that_does_not():
    (complaint,) = run_case(
        case(
            "check_condition_state",
            "CheckConditionState",
            params={"predicate": "lambda x: x > 3"},
            inputs={"input_value": 2},
            outcome="true",
        )
    ).complaints
    assert complaint == "outcome is 'false'; expected was 'true'"


def test_a_state_is_only_imported_if_that_is_all_that_is_asked():
    assert run_case(case("wait_state", "WaitState", import_only=True)).is_good


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (case("nothing_state", "A"), "cannot import flexbe_states.nothing_state"),
        (case("wait_state", "A"), "has no class 'A'"),
        (Case("it", "pathlib", "Path"), "is neither a state nor a behavior"),
        (case("wait_state", "WaitState"), "missing 1 required positional argument"),
        (case("wait_state", "WaitState", params={"wait_time": "!/t"}), "needs a bag"),
    ],
)
def test_what_cannot_be_run_is_reported(wrong, text):
    assert text in run_case(wrong).check("pass").complaint
