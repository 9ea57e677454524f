"""The message files say what they must, field by field."""

import re
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[2]
FILES = sorted([*PACKAGE.glob("action/*"), *PACKAGE.glob("msg/*"), *PACKAGE.glob("srv/*")])
ACTIONS = sorted(PACKAGE.glob("action/*"))

GOAL = ("string id", "float64 timeout")
RESULT = (
    "string id",
    "bool success",
    "string message",
    "float64 elapsed_time",
    "int16 error_code",
    "string error_message",
)
FEEDBACK = ("string id", "string message", "float64 elapsed_time", "float64 completed_percentage")

# Deliverable 5.1, 3.1.
PLACE_PIN = (
    "string id",
    "string robot_1_name",
    "string robot_2_name",
    "float64 path_space",
    "float64 connector_space",
    "bool centered",
    "bool rotate",
    "bool show_in_TF",
    "float64 timeout",
)


def fields(text):
    lines = [re.sub(r"\s*#.*", "", line).strip() for line in text.splitlines()]
    return tuple(" ".join(line.split()) for line in lines if line and "=" not in line)


def parts(file):
    return [fields(part) for part in file.read_text().split("---")]


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_every_field_has_a_comment(file):
    for line in file.read_text().splitlines():
        if line and not line.startswith("#") and line != "---" and "=" not in line:
            assert re.search(r"# \S", line), f"{file.name}: {line}"


@pytest.mark.parametrize("file", ACTIONS, ids=lambda file: file.stem)
def test_every_ability_keeps_the_common_contract(file):
    goal, result, feedback = parts(file)
    assert goal[0] == GOAL[0]
    assert goal[-1] == GOAL[-1]
    assert result[: len(RESULT)] == RESULT
    assert feedback[: len(FEEDBACK)] == FEEDBACK


def test_place_pin_is_the_deliverables_field_for_field():
    assert parts(PACKAGE / "action" / "PlacePin.action") == [PLACE_PIN, RESULT, FEEDBACK]


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_no_text_constant_swallows_a_comment(file):
    for line in file.read_text().splitlines():
        assert not re.match(r"string \w+=.*#", line), f"{file.name}: {line}"
