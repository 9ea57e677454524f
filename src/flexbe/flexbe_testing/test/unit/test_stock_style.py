"""Test cases in the style of stock FlexBE's, and tags that may not be constructed."""

import unittest
from pathlib import Path

import genpy
import pytest
from geometry_msgs.msg import Point

from flexbe_testing.core.case import Case, CaseError
from flexbe_testing.edge.case_files import case_files, load_case, read_case_file
from flexbe_testing.ros import tester
from flexbe_testing.ros.tester import run_case

FILES = sorted((Path(__file__).parents[1] / "stock_style").glob("*.test"))
POINT = "!!python/object/new:geometry_msgs.msg._Point.Point"


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_case_in_the_style_of_stock_runs(file):
    (found,) = case_files([str(file)], "")
    case = read_case_file(found)
    verdict = run_case(case)
    assert verdict.complaints == ()
    names = ["pass", *(["outcome"] if case.outcome else []), *(f"output_{k}" for k in case.outputs)]
    assert [check.name for check in verdict.checks] == names


def test_a_message_can_be_written_in_each_form_of_the_tag():
    forms = ("{state: [1, 2, 3]}", "[1, 2, 3]", "{x: 1, y: 2, z: 3}", "{args: [1, 2, 3]}")
    for form in forms:
        assert load_case(f"{POINT} {form}") == Point(1, 2, 3)
    assert load_case("!!python/object/new:rospy.rostime.Duration [1, 5]") == genpy.Duration(1, 5)
    assert load_case("!!python/object/apply:collections.OrderedDict [[[a, 1]]]") == {"a": 1}
    assert load_case("!!python/dict {a: !!python/complex 1+2j}") == {"a": 1 + 2j}


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("a: !!python/object/new:os.system [exit]", "line 1: objects of os.system are not"),
        ("\n- !!python/object/apply:os.system [exit]", "line 2: the tag !!python/object/apply:os"),
        ("!!python/object/apply:subprocess.Popen [ls]", "allowed are ROS messages, times"),
        ("!!python/object/apply:geometry_msgs.msg._Point.Point [1, 2, 3]", "is not allowed"),
        ("!!python/name:os.system", "the tag !!python/name:os.system is not allowed"),
        ("!!python/module:os", "is not allowed"),
        ("!!python/object:pathlib.Path {}", "objects of pathlib.Path are not constructed"),
        ("!!python/object/new:no_msgs.msg._A.A {}", "there is no message no_msgs/A"),
        (f"{POINT} [1, 2]", r"its fields are x, y, z; found \[1, 2\]"),
        (f"{POINT} {{state: [1, 2, a]}}", "geometry_msgs.msg._Point.Point: .*z.*"),
        ("!!python/int text", "int: invalid literal"),
        ("!!binary [1]", "line 1: "),
        ("!unknown 1", "could not determine a constructor for the tag '!unknown'"),
        ("{", "cannot read it"),
    ],
)
def test_what_is_not_harmless_is_refused_with_its_line(text, complaint):
    with pytest.raises(CaseError, match=complaint):
        load_case(text)


def test_no_module_is_imported_for_a_refused_tag(tmp_path, monkeypatch):
    (tmp_path / "trap.py").write_text("raise SystemExit")
    monkeypatch.syspath_prepend(str(tmp_path))
    for tag in ("object:trap.A", "object/new:trap.A", "object/apply:trap.A", "name:trap.A"):
        with pytest.raises(CaseError):
            load_case(f"!!python/{tag} {{}}")


def test_a_case_that_does_not_run_fails_in_all_its_results():
    case = Case("it", "flexbe_states.nothing", "A", outcome="done", outputs={"x": 1})
    verdict = run_case(case)
    assert verdict.check("pass").complaint.startswith("cannot import flexbe_states.nothing")
    for name in ("outcome", "output_x"):
        assert verdict.check(name).complaint.startswith("not reached")


def test_each_result_is_a_test_of_its_own_and_the_case_runs_once(tmp_path, monkeypatch):
    text = (
        "path: flexbe_states.calculation_state\nclass: CalculationState\n"
        "params: {calculation: 'lambda x: x'}\ninput: {input_value: 1}\n"
    )
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "wait.test").write_text(text + "outcome: failed\noutput: {x: 1}\n")
    (tmp_path / "broken.test").write_text("{")
    runs = []
    monkeypatch.setattr(tester, "run_case", lambda case: runs.append(case) or run_case(case))
    monkeypatch.setattr(tester.rospy, "get_param", lambda name, default: default)
    files = [tmp_path / "a" / "wait.test", tmp_path / "b" / "wait.test", tmp_path / "broken.test"]
    tests = unittest.defaultTestLoader.loadTestsFromTestCase(tester._as_unittest(files))
    result = unittest.TestResult()
    tests.run(result)
    failed = {test.id().rpartition(".")[2] for test, _trace in result.failures}
    assert failed == {
        "test_wait_outcome",
        "test_wait_output_x",
        "test_wait_2_outcome",
        "test_wait_2_output_x",
        "test_broken_pass",
    }
    assert (result.testsRun, len(result.errors), len(runs)) == (7, 0, 2)
