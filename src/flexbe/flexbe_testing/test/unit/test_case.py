"""What a test case says."""

from __future__ import annotations

import pytest

from flexbe_testing.core.case import (
    Case,
    CaseError,
    Check,
    behavior_place,
    compare,
    read_case,
    value_of,
)
from flexbe_testing.edge.case_files import case_files, read_case_file
from flexbe_testing.ros.tester import run_case


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


# Where test cases are


@pytest.fixture
def package(tmp_path, monkeypatch):
    folder = tmp_path / "my_states"
    (folder / "tests").mkdir(parents=True)
    (folder / "package.xml").write_text(
        "<package format='3'><name>my_states</name><version>0.0.1</version>"
        "<description>d</description><maintainer email='a@b.cd'>a</maintainer>"
        "<license>BSD</license></package>"
    )
    (folder / "tests" / "double.test").write_text("path: a.b\nclass: C\n")
    (folder / "tests" / "run_all.test").write_text("<launch/>")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    return folder


def test_without_names_all_cases_of_a_package_are_found_but_no_launch_file(package):
    assert case_files([], "my_states") == [package / "tests" / "double.test"]


@pytest.mark.parametrize("name", ["double", "double.test", "tests/double", "tests/double.test"])
def test_cases_are_named_relative_to_the_package(package, name):
    assert case_files([name], "my_states") == [package / "tests" / "double.test"]


def test_absolute_paths_need_no_package(package):
    path = str(package / "tests" / "double.test")
    assert [str(file) for file in case_files([path], "")] == [path]


def test_what_cannot_be_found_or_read_is_reported(package):
    with pytest.raises(CaseError, match="there is no test case 'other'"):
        case_files(["other"], "my_states")
    with pytest.raises(CaseError, match="there is no ROS package 'nothing'"):
        case_files([], "nothing")
    with pytest.raises(CaseError, match="there is no test case '~nobody_here/x'"):
        case_files(["~nobody_here/x"], "my_states")
    broken = package / "tests" / "broken.test"
    for text in (b"{", b"\xff", b"input: {day: 2026-13-01}"):
        broken.write_bytes(text)
        assert broken in case_files([], "my_states")
        with pytest.raises(CaseError, match="cannot read it"):
            read_case_file(broken)


# Cases that need no running nodes; those of stock_style run well


def case(module, class_name, **keys):
    return Case("it", f"flexbe_states.{module}", class_name, **keys)


def test_a_state_that_does_something_else_is_reported():
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
