"""Where test cases are."""

import pytest

from flexbe_testing.core.case import CaseError
from flexbe_testing.edge.case_files import case_files, read_case_file


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
    broken = package / "tests" / "broken.test"
    broken.write_text("{")
    with pytest.raises(CaseError, match="cannot read it"):
        read_case_file(broken)
