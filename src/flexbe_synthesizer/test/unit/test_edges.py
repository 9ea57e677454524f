"""Disk: what is found, what is refused, and that nothing is written by halves."""

import os
import shutil

import pytest

from flexbe_synthesizer.edge import chart_files
from flexbe_synthesizer.edge.chart_files import confined_to, find_chart, read_charts
from flexbe_synthesizer.edge.files import write_all
from flexbe_synthesizer.edge.output_package import enclosing_package, output_package
from flexbe_synthesizer.edge.package_path import find_packages, read_library
from flexbe_synthesizer.errors import ChartFileError, ChartRefusedError, OutputError

CHART = (
    '<statemachine name="{name}" initial="A"><datamodel><outcome name="done"/></datamodel>'
    '<behavior id="A" type="{inner}"><transition event="done" target="done"/></behavior>'
    "</statemachine>"
)


def write_chart(path, name="Task", inner="Other"):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(CHART.format(name=name, inner=inner))
    return path


# --- charts


def test_charts_that_a_chart_names_are_read_too_each_once(tmp_path):
    top = write_chart(tmp_path / "a.xml", "A", "inner/b.xml")
    write_chart(tmp_path / "inner" / "b.xml", "B", "../a.xml")
    files = read_charts([str(top), str(tmp_path / "inner" / ".." / "a.xml")])
    assert [c.name for c in files.charts] == ["A", "B"]
    assert files.problems == ()


def test_a_named_chart_that_is_not_there_is_a_problem_where_it_is_named(tmp_path):
    top = write_chart(tmp_path / "a.xml", "A", "b.xml")
    (problem,) = read_charts([str(top)]).problems
    assert problem.position == (str(top), 1, 98)
    assert "No such file" in problem.message


def test_a_chart_asked_for_that_cannot_be_read_says_why(tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "pipe.xml")
    write_chart(tmp_path / "large.xml")
    monkeypatch.setattr(chart_files, "LARGEST_FILE", 10)
    for name, reason in (
        ("none.xml", "No such file"),
        ("pipe.xml", "no regular file"),
        ("", "no regular file"),
        ("large.xml", "larger than"),
    ):
        with pytest.raises(ChartFileError, match=reason):
            read_charts([str(tmp_path / name)])


def test_a_chart_is_found_relative_to_its_folders_or_by_its_whole_path(tmp_path):
    first, second = tmp_path / "first", tmp_path / "second"
    first.mkdir()
    path = str(write_chart(second / "deep" / "a.xml"))
    assert find_chart("deep/a.xml", [first, second]) == path
    assert find_chart(path, [first, second]) == path
    with pytest.raises(ChartFileError, match=r"searched: .*first.*second"):
        find_chart("b.xml", [first, second])


@pytest.mark.parametrize("name", ["../out.xml", "/etc/passwd", "link.xml", "dir/out.xml", "a\0b"])
def test_no_path_leads_out_of_the_chart_folders(tmp_path, name):
    home = tmp_path / "charts"
    home.mkdir()
    outside = write_chart(tmp_path / "out.xml")
    (home / "link.xml").symlink_to(outside)
    (home / "dir").symlink_to(tmp_path)
    with pytest.raises(ChartRefusedError):
        find_chart(name, [home])


def test_what_is_outside_is_refused_alike_whether_it_is_there_or_not(tmp_path):
    home = tmp_path / "charts"
    home.mkdir()
    write_chart(tmp_path / "there.xml")
    messages = []
    for name in ("there", "nowhere"):
        with pytest.raises(ChartRefusedError) as caught:
            find_chart(str(tmp_path / f"{name}.xml"), [home])
        messages.append(str(caught.value).replace(name, ""))
    assert messages[0] == messages[1]


def test_a_chart_cannot_name_another_one_outside_the_folders(tmp_path):
    home = tmp_path / "charts"
    write_chart(tmp_path / "out.xml", "Out")
    top = write_chart(home / "a.xml", "A", "../out.xml")
    (problem,) = read_charts([str(top)], confined_to([home])).problems
    assert "outside the chart folders" in problem.message


# --- packages


def test_a_broken_package_costs_a_warning_and_nothing_else(tmp_path, package_path):
    shutil.copytree(package_path, tmp_path / "good")
    bad = tmp_path / "bad"
    for name, text in (("broken", "<package>"), ("nameless", "<package/>")):
        (bad / name).mkdir(parents=True)
        (bad / name / "package.xml").write_text(text)
    (bad / "ignored").mkdir()
    (bad / "ignored" / "CATKIN_IGNORE").write_text("")
    (bad / "ignored" / "package.xml").write_text("<package>")
    states = tmp_path / "good" / "cell_states" / "src" / "cell_states"
    (states / "broken_state.py").write_text("class A(EventState)")
    (states / "binary_state.py").write_bytes(b"(EventState)\xff\0")
    manifests = tmp_path / "good" / "cell_behaviors" / "manifest"
    (manifests / "broken.xml").write_text("<behavior")
    (manifests / "#editor.xml").write_text("<behavior")
    (manifests / "lost.xml").write_text(
        '<behavior name="Lost"><executable package_path="cell_behaviors.lost" class="L"/>'
        "</behavior>"
    )
    packages, path_warnings = find_packages(f"{bad}:{tmp_path / 'good'}:{tmp_path / 'none'}")
    library, warnings = read_library(packages)
    assert len(path_warnings) == 2
    assert sorted(w.split(" cannot")[0].rpartition("/")[2] for w in warnings) == [
        "binary_state.py",
        "broken_state.py",
    ]
    assert library.find_states("LocateComponentState")
    assert [b.name for b in library.behaviors] == ["Clean Up"]
    assert [b.name for b in library.unreadable_behaviors] == ["Lost"]


def test_of_two_packages_of_one_name_the_first_on_the_path_counts(tmp_path, package_path):
    shutil.copytree(package_path, tmp_path / "overlay")
    packages, _ = find_packages(f"{tmp_path / 'overlay'}:{package_path}")
    assert {str(p.folder.parent) for p in packages} == {str(tmp_path / "overlay")}


def test_a_folder_without_a_package_becomes_one(tmp_path):
    package = output_package(tmp_path / "my_behaviors")
    assert package.name == "my_behaviors"
    written = write_all(package.missing)
    assert [str(p.relative_to(tmp_path)) for p in written] == [
        "my_behaviors/package.xml",
        "my_behaviors/src/my_behaviors/__init__.py",
    ]
    again = output_package(tmp_path / "my_behaviors")
    assert (again.missing, again.is_exported) == ({}, True)
    assert str(again.code_path("My Task")).endswith("src/my_behaviors/my_task_sm.py")
    assert str(again.manifest_path("My Task")).endswith("my_behaviors/manifest/my_task.xml")


def test_a_folder_that_cannot_be_a_package_is_refused(tmp_path):
    with pytest.raises(OutputError, match="'My-Package' is no package name"):
        output_package(tmp_path / "My-Package")
    (tmp_path / "package.xml").write_text("<package>")
    with pytest.raises(OutputError, match="not well-formed"):
        output_package(tmp_path)


def test_a_chart_goes_to_the_nearest_package_around_it(tmp_path):
    write_all(output_package(tmp_path / "cell").missing)
    assert enclosing_package(tmp_path / "cell" / "charts" / "deep" / "a.xml").name == "cell"
    with pytest.raises(OutputError, match="--output"):
        enclosing_package(tmp_path / "elsewhere" / "a.xml")


# --- writing


def test_only_what_changed_is_written(tmp_path):
    old, new = tmp_path / "old", tmp_path / "new" / "deep"
    old.write_text("same")
    before = old.stat().st_mtime_ns
    assert write_all({old: "same", new: "text"}) == (new,)
    assert old.stat().st_mtime_ns == before
    assert new.read_text() == "text"


def test_the_rights_of_a_file_stay(tmp_path):
    path = tmp_path / "a"
    path.write_text("old")
    path.chmod(0o755)
    write_all({path: "new", tmp_path / "b": "new"})
    assert path.stat().st_mode & 0o777 == 0o755
    assert (tmp_path / "b").stat().st_mode & 0o777 == 0o644


def test_if_one_file_cannot_be_staged_none_is_changed(tmp_path):
    first = tmp_path / "first"
    first.write_text("old")
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="nothing was written"):
        write_all({first: "new", tmp_path / "file" / "second": "new"})
    assert first.read_text() == "old"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "first"]


def test_a_disk_that_is_full_leaves_nothing_behind(tmp_path, full_disk):
    (tmp_path / "first").write_text("old")
    with full_disk(), pytest.raises(OutputError, match="nothing was written"):
        write_all({tmp_path / "first": "new", tmp_path / "__init__.py": "new"})
    assert [(p.name, p.read_text()) for p in tmp_path.iterdir()] == [("first", "old")]


def test_a_file_in_the_way_that_is_no_regular_one_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OutputError, match="no regular file"):
        write_all({tmp_path / "pipe": "new"})


def test_if_one_file_cannot_be_renamed_those_before_it_are_taken_back(tmp_path, monkeypatch):
    old, new, last = (tmp_path / name for name in ("old", "new", "last"))
    old.write_text("old")
    rename = type(old).replace

    def fail_at_last(self, target):
        if target == last:
            raise OSError("no space left")
        return rename(self, target)

    monkeypatch.setattr(type(old), "replace", fail_at_last)
    with pytest.raises(OutputError, match="no space left"):
        write_all({old: "new", new: "new", last: "new"})
    assert old.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["old"]
