"""What a test case says."""

import pytest

from flexbe_testing.core.case import CaseError, Check, behavior_place, compare, read_case, value_of


def test_a_case_says_what_to_run_and_what_must_come_out():
    case = read_case("double", {"path": "a.b", "class": "C", "params": {"x": 1}, "outcome": "done"})
    assert (case.module, case.class_name, case.params, case.outcome) == (
        "a.b",
        "C",
        {"x": 1},
        "done",
    )


def test_a_behavior_is_found_by_the_rules_of_the_app():
    case = read_case("it", {"path": "my_behaviors", "name": "Place Pin, v2"})
    assert (case.module, case.class_name) == ("my_behaviors.place_pin__v2_sm", "PlacePinv2SM")
    assert behavior_place("p", "A") == ("p.a_sm", "ASM")


@pytest.mark.parametrize(
    ("found", "text"),
    [
        (["path"], "a mapping of keys"),
        ({"class": "C"}, "path is missing"),
        ({"path": "a"}, "class, or name of a behavior, is missing"),
        ({"path": "a", "class": "C", "params": 3}, "params must be of type dict, found 3"),
        ({"path": "a", "class": "C", "outcom": "x"}, "outcom is unknown. There are: path"),
    ],
)
def test_a_case_that_makes_no_sense_is_refused(found, text):
    with pytest.raises(CaseError, match=text):
        read_case("case", found)


def test_values_are_literal_functions_or_messages():
    messages = {"/topic": "a message"}
    value = value_of({"f": "lambda x: x + 1", "m": ["!/topic"], "n": 3, "s": "text"}, messages.get)
    assert value["f"](1) == 2
    assert (value["m"], value["n"], value["s"]) == (["a message"], 3, "text")


def test_a_topic_is_a_message_if_the_case_has_a_bag_and_text_otherwise():
    written = ["/topic", "//topic", "!/topic", "None", ("/topic",)]
    messages = {"/topic": 1}
    assert value_of(written, messages.get, has_bag=True) == [1, "/topic", 1, None, (1,)]
    assert value_of(written, messages.get) == ["/topic", "/topic", 1, None, ("/topic",)]


def test_a_function_that_is_not_python_is_reported():
    with pytest.raises(CaseError, match="'lambda x' is not a Python function"):
        value_of("lambda x", None)


def test_everything_that_differs_is_reported():
    good = compare("done", "done", {"x": 1}, {"x": 1, "y": 2})
    assert good == (Check("outcome"), Check("output_x"))
    assert compare(None, "anything", {}, {}) == ()
    assert compare("done", "failed", {"x": 1, "y": 2}, {"x": 3}) == (
        Check("outcome", "outcome is 'failed'; expected was 'done'"),
        Check("output_x", "output 'x' is 3; expected was 1"),
        Check("output_y", "output 'y' was not written; expected was 2"),
    )
