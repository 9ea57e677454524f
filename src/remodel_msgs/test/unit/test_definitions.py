"""The message files say what they must, field by field."""

import re
from pathlib import Path

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


def lines_of_all_files():
    return [(file.name, line) for file in FILES for line in file.read_text().splitlines() if line]


def test_every_field_has_a_comment():
    fields_only = [
        (name, line)
        for name, line in lines_of_all_files()
        if not line.startswith("#") and line != "---" and "=" not in line
    ]
    assert len(fields_only) > 100
    assert [found for found in fields_only if not re.search(r"# \S", found[1])] == []


def test_every_ability_keeps_the_common_contract():
    assert len(ACTIONS) > 10
    common = {file.stem: common_parts(*parts(file)) for file in ACTIONS}
    assert {name: part for name, part in common.items() if part != (GOAL, RESULT, FEEDBACK)} == {}


def common_parts(goal, result, feedback):
    """Return what of an action's parts is to be common."""
    return (goal[0], goal[-1]), result[: len(RESULT)], feedback[: len(FEEDBACK)]


def test_place_pin_is_the_deliverables_field_for_field():
    assert parts(PACKAGE / "action" / "PlacePin.action") == [PLACE_PIN, RESULT, FEEDBACK]


def test_no_text_constant_swallows_a_comment():
    found = lines_of_all_files()
    assert [each for each in found if re.match(r"string \w+=.*#", each[1])] == []
