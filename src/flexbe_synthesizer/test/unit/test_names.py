import keyword

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosgraph.names import is_legal_name

from flexbe_synthesizer.core.chart import names


@pytest.mark.parametrize("name", ["Insert", "PlacePin takes longer than normal", "a-1.b_c", "Über"])
def test_names_that_flexbe_can_carry(name):
    assert names.is_name(name)


@pytest.mark.parametrize(
    "name", ["", "1st", " a", "a ", "a  b", "a/b", "a'b", "a\nb", "a def b", "def x", "a{}", "_a"]
)
def test_names_that_flexbe_cannot_carry(name):
    assert not names.is_name(name)


def test_a_behavior_gets_the_names_that_the_app_would_give_it():
    assert names.behavior_class("Example Behavior") == "ExampleBehaviorSM"
    assert names.behavior_module("Example Behavior") == "example_behavior_sm"
    assert names.behavior_file("Wire-Task 2.1") == "wire_task_2_1"
    assert names.behavior_class("my_first_behavior") == "my_first_behaviorSM"


@pytest.mark.parametrize(
    ("name", "snake"),
    [
        ("LocateGearbox 2", "locate_gearbox_2"),
        ("HTTPServer", "http_server"),
        ("a-b", "a_b"),
        ("Ä1", "state_1"),
        ("é", "state"),
    ],
)
def test_snake_case_is_what_one_would_write(name, snake):
    assert names.snake_case(name) == snake


@given(st.text(min_size=1))
def test_snake_case_is_always_an_identifier_when_joined(name):
    key = names.snake_case(name) + "_x"
    assert key.isidentifier()
    assert not keyword.iskeyword(key)


def test_a_taken_name_is_numbered():
    assert names.take_unused("a", ()) == "a"
    assert names.take_unused("a", {"a", "a_2"}) == "a_3"


def test_a_message_names_what_comes_near_and_shortens_long_lists():
    known = [f"State{n:02}" for n in range(20)]
    assert "and 8 more" in names.allowed("x", known)
    assert names.allowed("insrt", ["Insert", "Fix"]) == (
        "allowed: 'Insert', 'Fix'. Did you mean 'Insert'?"
    )
    assert names.allowed("x", []) == "allowed: none."
    assert names.misspelt("insrt", ["Insert", "Fix"]) == "Insert"
    assert names.misspelt("Fxi", ["Fix", "Insert"]) == "Fix"
    assert names.misspelt("RemoveCableState", ["ExtractCableState"]) is None


def test_keys_are_identifiers_that_userdata_can_hold():
    assert names.is_key("pose_2")
    assert names.is_key("größe")
    for key in ("2pose", "a b", "class", "_private", "", "\ufb01x", "o\u0308"):
        assert not names.is_key(key)


def test_among_thousands_a_name_is_found_that_differs_in_a_letter_or_two():
    known = names.Vocabulary(f"Insert{n}" for n in range(5000))
    assert names.misspelt("insrt77", known) == "Insert77"
    assert names.misspelt("Insert99999", known) is None
    assert names.allowed("Isnert4321", known).endswith("and 4988 more. Did you mean 'Insert4321'?")
    assert names.misspelt("x" * 1_000_000, known) is None


def test_a_long_name_is_shown_by_its_beginning():
    assert len(names.allowed("x", ["y" * 10_000])) < 200


@pytest.mark.parametrize("name", ["Place Wire", "Ä Wire", "a", "T" * 200])
def test_a_chart_may_have_a_name_that_files_and_a_class_can_have(name):
    assert names.is_behavior_name(name)


@pytest.mark.parametrize("topic", ["a", "/a", "~a", "~/a", "cell_1/locate", "/cell/2"])
def test_a_topic_may_be_relative_global_or_private(topic):
    assert names.is_topic(topic)


@pytest.mark.parametrize(
    "topic", ["", "/", "~", "1a", "a/", "//a", "a//b", "a b", "ä", "a-b", "a\n"]
)
def test_a_topic_that_ros_refuses_is_none(topic):
    assert not names.is_topic(topic)


@given(st.text("a1_/~ -.ä\n"))
def test_what_ros_refuses_is_no_topic(text):
    assert is_legal_name(text) or not names.is_topic(text)
