"""A behavior that was cut short followed its chart as far as its operations go."""

import pytest

from flexbe_synthesizer.core.chart.model import Chart
from remodel_states.core.codes import Code
from remodel_supervision.core.run import Execution, Operation
from remodel_supervision.core.runs.attempts import Attempt
from remodel_supervision.core.runs.events import Part
from remodel_supervision.core.runs.replay import path_difference
from remodel_supervision.core.runs.state import PERSON_FIRST

LOST = Code.SERVER_LOST
ASKED = ("/Find wire", "/Connect a/InsertCable")


def attempt(*path, code=LOST):
    operations = tuple(
        Operation(state, "PickCable", "failed", code, "", 2.0, 1.0, state) for state in ASKED
    )
    execution = Execution("W1", "Place Wire W1", 1, "failed", False, 0.0, 3.0, operations)
    return Attempt(execution, Part.WHOLE, "", path)


@pytest.mark.parametrize(
    "path",
    [
        ASKED,
        ("/Find wire_attempts", *ASKED, "/Lay down"),
        (*ASKED, "/Connect a/InsertCable"),
    ],
)
def test_states_without_a_record_do_not_differ(path):
    assert path_difference(attempt(*path), Chart("Place Wire W1", ""), {}, {}) == ""


@pytest.mark.parametrize("code", PERSON_FIRST)
def test_after_an_error_about_which_a_person_is_to_answer_nothing_begins(code):
    entered = (*ASKED, "/Lay down")
    assert path_difference(attempt(*entered, code=code), Chart("", ""), {}, {}) == ""


@pytest.mark.parametrize("path", [ASKED[:1], ASKED[::-1]])
def test_an_operation_that_was_not_entered_in_its_turn_differs(path):
    assert "the engine entered" in path_difference(attempt(*path), Chart("", ""), {}, {})
