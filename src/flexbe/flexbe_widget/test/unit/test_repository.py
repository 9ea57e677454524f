"""Packages for behaviors and states of a user's own."""

import ast

import pytest
from catkin_pkg.package import parse_package_string

from flexbe_testing.core.app_behavior import read_state
from flexbe_widget.core.command_line import read_breakpoints
from flexbe_widget.core.repository import RepositoryError, repository
from flexbe_widget.edge.files import write_new_files


def test_both_packages_are_valid_and_export_what_they_hold():
    files = repository("my_cell")
    packages = {p: parse_package_string(t) for p, t in files.items() if p.endswith("package.xml")}
    exports = {package.name: [e.tagname for e in package.exports] for package in packages.values()}
    assert exports == {
        "my_cell_flexbe_states": ["flexbe_states"],
        "my_cell_flexbe_behaviors": ["flexbe_behaviors"],
    }
    for path, text in files.items():
        if path.endswith(".py"):
            ast.parse(text)


def test_the_flexbe_app_reads_the_example_state():
    (text,) = [t for p, t in repository("my_cell").items() if p.endswith("_state.py")]
    state = read_state(text, "my_cell_flexbe_states.example_state")
    assert (state.class_name, state.parameters) == ("ExampleState", {"rounds": None})
    assert (state.outcomes, state.output_keys) == (("done",), ("count",))


def test_its_example_state_passes_its_example_case(tmp_path, monkeypatch):
    write_new_files(tmp_path, repository("my_cell"))
    package = tmp_path / "my_cell_behaviors" / "my_cell_flexbe_states"
    monkeypatch.syspath_prepend(str(package / "src"))
    from my_cell_flexbe_states.example_state import ExampleState

    from flexbe_core.testing import run_state

    assert run_state(ExampleState(3)) == ("done", {"count": 3})


def test_nothing_is_overwritten(tmp_path):
    write_new_files(tmp_path, {"a/b": "mine"})
    with pytest.raises(RepositoryError, match="a/b exists already; nothing was written"):
        write_new_files(tmp_path, {"a/c": "new", "a/b": "new"})
    assert not (tmp_path / "a" / "c").exists()


def test_what_cannot_be_written_whole_is_not_written(tmp_path):
    (tmp_path / "c").write_text("a file, where a folder is needed")
    with pytest.raises(RepositoryError, match="cannot write into"):
        write_new_files(tmp_path, {"a/b": "new", "c/d": "new"})
    assert not (tmp_path / "a" / "b").exists()


def test_a_name_that_no_package_can_have_is_refused():
    with pytest.raises(RepositoryError, match="'My Cell' cannot be the name of packages"):
        repository("My Cell")


def test_breakpoints_are_paths():
    assert read_breakpoints(["/A/b", "/A/b", "/C"]) == ["/A/b", "/C"]
    assert read_breakpoints([]) == []
    with pytest.raises(ValueError, match="'A', '/B/'"):
        read_breakpoints(["A", "/B/"])
