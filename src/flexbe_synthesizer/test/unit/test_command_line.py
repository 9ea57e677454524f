import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from flexbe_synthesizer.command_line import main

COMMAND = Path(__file__).parents[2] / "nodes" / "synthesize"


@pytest.fixture
def charts(tmp_path, golden):
    """Return a folder with the golden charts, inside a new package `cell`."""
    folder = tmp_path / "cell" / "charts"
    shutil.copytree(golden / "charts", folder)
    (tmp_path / "cell" / "package.xml").write_text(
        "<package><name>cell</name><export><flexbe_behaviors/></export></package>"
    )
    return folder


@pytest.fixture
def run(package_path, capsys):
    """Return a function: arguments -> (exit code, what was printed, what went to stderr)."""

    def run(*arguments):
        code = main([str(argument) for argument in arguments], package_path)
        printed = capsys.readouterr()
        return code, printed.out, printed.err

    return run


def tree(folder):
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_a_chart_is_written_to_the_package_that_it_lies_in(run, charts):
    code, out, err = run(charts / "place_connector.xml")
    package = charts.parent
    assert (code, err) == (0, "")
    assert out.splitlines() == [
        f"wrote: {package}/src/cell/__init__.py",
        f"wrote: {package}/src/cell/place_connector_sm.py",
        f"wrote: {package}/manifest/place_connector.xml",
        f"wrote: {package}/certificate/place_connector.yaml",
    ]
    assert run(charts / "place_connector.xml")[:2] == (
        0,
        "unchanged: every behavior is as its chart says\n",
    )


def test_a_chart_that_another_one_names_is_written_too(run, charts, tmp_path):
    code, out, _ = run(charts / "wire_task.xml", "--output", tmp_path / "out")
    assert code == 0
    names = [Path(line).name for line in out.splitlines()]
    assert names[:2] == ["package.xml", "__init__.py"]
    assert {*names[2:]} == {
        f"{name}{end}"
        for name in ("wire_task", "place_connector")
        for end in ("_sm.py", ".xml", ".yaml")
    }
    code_text = (tmp_path / "out" / "src" / "out" / "wire_task_sm.py").read_text()
    assert "from out.place_connector_sm import PlaceConnectorSM" in code_text


def test_what_is_written_does_not_depend_on_where_the_command_runs(
    run, charts, tmp_path, monkeypatch
):
    run(*sorted(charts.glob("*.xml")), "--output", tmp_path / "a" / "out")
    monkeypatch.chdir(charts)
    run("wire_task.xml", "./plain.xml", "two_arms.xml", "--output", tmp_path / "b" / "out")
    assert tree(tmp_path / "a") == tree(tmp_path / "b")


def test_check_writes_nothing_and_needs_no_package(run, charts, tmp_path):
    before = tree(tmp_path)
    code, out, err = run(*sorted(charts.glob("*.xml")), "--check")
    assert (code, out, err) == (0, "4 charts checked, no errors\n", "")
    assert tree(tmp_path) == before
    lone = tmp_path / "lone.xml"
    shutil.copy(charts / "plain.xml", lone)
    assert run(lone, "--check")[0] == 0
    code, _, err = run(lone)
    assert code == 2
    assert "lies in no ROS package; name the package to write to with --output" in err


def test_errors_are_printed_with_their_places_and_nothing_is_written(run, charts, golden):
    shutil.copy(golden / "wrong" / "ten_mistakes.xml", charts)
    before = tree(charts.parent)
    code, out, err = run(charts / "ten_mistakes.xml", charts / "plain.xml")
    assert (code, out) == (1, "")
    lines = err.splitlines()
    assert lines[-1] == "10 errors; nothing was written"
    assert len([line for line in lines if line.startswith(f"{charts}/ten_mistakes.xml:")]) >= 10
    assert tree(charts.parent) == before


def test_errors_of_a_chart_that_is_named_count_too(run, charts):
    inner = charts / "place_connector.xml"
    inner.write_text(inner.read_text().replace('target="Fix"', 'target="Fxi"'))
    code, _, err = run(charts / "wire_task.xml")
    assert code == 1
    assert f"{inner}:20:34: [unknown-target]" in err
    assert err.endswith("1 error; nothing was written\n")


def test_a_named_chart_that_is_broken_is_reported_where_it_is_named_too(run, charts):
    inner = charts / "place_connector.xml"
    inner.write_text("<statemachine>")
    code, _, err = run(charts / "wire_task.xml")
    assert code == 1
    assert f"{inner}:1:15: [not-xml]" in err
    assert f"{charts}/wire_task.xml:23:24: [unknown-behavior]" in err


def test_a_missing_file_and_wrong_usage_are_code_two(run, charts):
    code, out, err = run(charts / "none.xml")
    assert (code, out) == (2, "")
    assert err == f"synthesize: {charts}/none.xml cannot be read: No such file or directory\n"
    for arguments in (
        (charts / "plain.xml", "--draw", "a.jpg"),
        (charts / "plain.xml", charts / "wire_task.xml", "--draw", "a.svg"),
        (charts / "plain.xml", "--output", charts.parent / "No Package"),
    ):
        assert run(*arguments)[0] == 2
    for arguments in ((), ("--unknown", "a.xml")):
        with pytest.raises(SystemExit) as caught:
            run(*arguments)
        assert caught.value.code == 2


def test_a_package_that_cannot_be_written_is_code_two(run, charts, tmp_path):
    loop = tmp_path / "loop"
    loop.symlink_to(loop)
    for folder in (loop, "a" * 300):
        code, out, err = run(charts / "plain.xml", "--output", folder)
        assert (code, out) == (2, "")
        assert err.startswith("synthesize: ")
    odd = shutil.copy(charts / "plain.xml", charts / os.fsdecode(b"odd\xff.xml"))
    code, _, err = run(odd)
    assert code == 2
    assert "nothing was written: " in err


def test_a_chart_is_drawn_beside_writing_or_checking_it(run, charts, tmp_path):
    drawing = tmp_path / "drawn" / "a.svg"
    before = tree(charts.parent)
    code, out, _ = run(charts / "plain.xml", "--check", "--draw", drawing)
    assert (code, out) == (0, f"wrote: {drawing}\n1 chart checked, no errors\n")
    assert "</svg>" in drawing.read_text()
    assert tree(charts.parent) == before


def test_manual_sections_survive_and_what_cannot_be_kept_is_not_overwritten(run, charts):
    run(charts / "plain.xml")
    code_path = charts.parent / "src" / "cell" / "plain_chart_sm.py"
    mine = code_path.read_text().replace(
        "# [MANUAL_INIT]\n", "# [MANUAL_INIT]\n        self.mine = 1\n"
    )
    code_path.write_text(mine)
    certificate = charts.parent / "certificate" / "plain_chart.yaml"
    assert "manual_code: []" in certificate.read_text()
    assert run(charts / "plain.xml")[1] == f"wrote: {certificate}\n"
    assert 'manual_code: ["INIT"]' in certificate.read_text()
    assert run(charts / "plain.xml")[1] == "unchanged: every behavior is as its chart says\n"
    chart = charts / "plain.xml"
    chart.write_text(chart.read_text().replace("own words", "words"))
    assert run(chart)[0] == 0
    assert "self.mine = 1" in code_path.read_text()
    for text, reason in (
        ("class Mine: pass\n", "written by hand"),
        (mine.replace("# [/MANUAL_FUNC]", ""), "do not appear once each"),
        (mine.replace("        self.mine", "\tself.mine"), "indent them by four blanks"),
    ):
        code_path.write_text(text)
        before = tree(charts.parent)
        code, _, err = run(chart)
        assert code == 2
        assert reason in err
        assert tree(charts.parent) == before


def test_a_package_that_exports_no_behaviors_is_warned_about(run, charts):
    package_xml = charts.parent / "package.xml"
    package_xml.write_text("<package><name>cell</name></package>")
    code, _, err = run(charts / "plain.xml")
    assert code == 0
    assert "exports no <flexbe_behaviors/>" in err


def test_a_behavior_that_the_engine_would_not_run_is_warned_about(
    charts, package_path, capsys, tmp_path
):
    first = Path(shutil.copytree(charts.parent, tmp_path / "first"))
    text = (first / "package.xml").read_text()
    (first / "package.xml").write_text(text.replace(">cell<", ">first<"))
    path = f"{first}:{charts.parent}:{package_path}"
    assert main([str(charts / "plain.xml")], path) == 0
    assert capsys.readouterr().err == "", "no other package has written one"
    assert main([str(first / "charts" / "plain.xml")], path) == 0
    assert capsys.readouterr().err == "", "it comes first"
    assert main([str(charts / "plain.xml")], path) == 0
    assert capsys.readouterr().err == (
        "warning: the engine would not run the behavior 'plain_chart' that is written to "
        f"{charts.parent}: {first} has one of that name, and comes first on the ROS package path; "
        "rename the chart, or delete the other behavior\n"
    )


def test_a_broken_package_on_the_path_is_a_warning(charts, package_path, capsys, tmp_path):
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad" / "package.xml").write_text("<package>")
    code = main([str(charts / "plain.xml"), "--check"], f"{tmp_path / 'bad'}:{package_path}")
    assert code == 0
    assert "package.xml is not well-formed" in capsys.readouterr().err


def test_the_command_itself_passes_the_exit_code_on(charts, package_path):
    environment = {**os.environ, "ROS_PACKAGE_PATH": package_path}

    def exit_code(*arguments):
        command = [sys.executable, str(COMMAND), *map(str, arguments)]
        done = subprocess.run(command, env=environment, capture_output=True, timeout=60)
        return done.returncode

    assert exit_code(charts / "plain.xml", "--check") == 0
    assert exit_code(charts / "none.xml") == 2


@pytest.mark.parametrize("name", ["synthesize", "chart_from_behavior"])
def test_a_reader_that_goes_away_ends_the_command_quietly(name):
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, str(COMMAND.with_name(name)), "--help"]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, timeout=60)
    os.close(writer)
    assert (done.returncode, done.stderr) == (-signal.SIGPIPE, b"")


def test_what_is_found_can_be_had_as_json(run, charts, golden):
    code, out, err = run(*sorted(charts.glob("*.xml")), "--check", "--json")
    found = json.loads(out)
    assert (code, found["errors"], found["problems"], err) == (0, 0, [], "")
    assert {chart["name"] for chart in found["charts"]} >= {"Two Arms", "Place Connector"}
    shutil.copy(golden / "wrong" / "ten_mistakes.xml", charts)
    code, out, _ = run(charts / "ten_mistakes.xml", "--json")
    found = json.loads(out)
    assert (code, found["errors"], found["written"]) == (1, 10, [])
    assert {"line", "column", "code", "message", "file", "severity"} == found["problems"][0].keys()


def test_the_path_of_a_run_is_coloured(run, charts, tmp_path):
    record, drawing = tmp_path / "run.json", tmp_path / "a.svg"
    steps = [["/Look_attempts", "counted"], ["/Look/run", "seen"], ["/Place/Insert", "inserted"]]
    record.write_text(json.dumps([*steps, ["/Place", "placed"]]))
    arguments = (charts / "two_arms.xml", "--check", "--draw", drawing)
    assert run(*arguments, "--run", record)[0] == 0
    assert "#1565c0" in drawing.read_text()
    record.write_text("[1]")
    code, _, err = run(*arguments, "--run", record)
    assert code == 2
    assert "is no record of a run" in err
    assert "found 1 in it" in err
    assert run(charts / "two_arms.xml", "--run", record)[0] == 2


def test_a_chart_is_exported_as_scxml(run, charts, tmp_path):
    code, out, _ = run(charts / "plain.xml", "--check", "--scxml", tmp_path / "a.scxml")
    assert (code, out.splitlines()[0]) == (0, f"wrote: {tmp_path / 'a.scxml'}")
    assert "<scxml " in (tmp_path / "a.scxml").read_text()


@pytest.mark.parametrize("lost", ["", "manifest/place_connector.xml"])
def test_a_behavior_is_not_written_over_another_one(run, charts, lost):
    package, chart = charts.parent, charts / "place_connector.xml"
    assert run(chart)[0] == 0
    if lost:
        (package / lost).unlink()
    text = chart.read_text().replace('name="Place Connector"', 'name="Place-Connector"')
    chart.write_text(text.replace('_state_id="Place Connector"', '_state_id="Place-Connector"'))
    before = tree(package)
    code, _out, err = run(chart)
    assert code == 2
    assert "belongs to the behavior 'Place Connector', and 'Place-Connector' would be" in err
    assert tree(package) == before


@pytest.fixture
def namesake(charts):
    """Return the file of a second chart with the name `Place Connector`; the first is written."""
    other = charts.parent / "drafts" / "mine.xml"
    other.parent.mkdir()
    text = (charts / "place_connector.xml").read_text()
    other.write_text(text.replace('ext:attempts="3"', 'ext:attempts="4"'))
    return other


@pytest.mark.parametrize("is_elsewhere", [False, True])
def test_a_behavior_is_not_written_over_that_of_another_chart_file(
    run, charts, namesake, tmp_path, is_elsewhere
):
    chart = charts / "place_connector.xml"
    package = tmp_path / "out" if is_elsewhere else charts.parent
    output = ("--output", package) if is_elsewhere else ()
    assert run(chart, *output)[0] == 0
    before = tree(package)
    code, out, err = run(namesake, *output)
    assert (code, out) == (2, "")
    assert err == (
        f"synthesize: {namesake} and {chart} both have the name 'Place Connector', and its "
        f"behavior in {package} is from the latter; rename one of the charts, or delete the one "
        "that is not needed\n"
    )
    assert tree(package) == before
    assert run(chart, *output)[1] == "unchanged: every behavior is as its chart says\n"


@pytest.mark.parametrize("change", ["moved", "renamed", "lost", "no chart"])
def test_a_chart_may_take_the_place_of_one_that_is_no_more(run, charts, namesake, change):
    chart = charts / "place_connector.xml"
    assert run(chart)[0] == 0
    if change == "moved":
        chart.rename(namesake)
    elif change == "renamed":
        chart.write_text(chart.read_text().replace('name="Place Connector"', 'name="Pull"'))
    elif change == "no chart":
        chart.write_text("<notes/>")
    else:
        chart.unlink()
    assert run(namesake)[0] == 0
    assert run(namesake)[1] == "unchanged: every behavior is as its chart says\n"


def test_a_package_that_is_copied_with_its_charts_is_independent(run, charts, tmp_path):
    assert run(charts / "place_connector.xml")[0] == 0
    copy = Path(shutil.copytree(charts.parent, tmp_path / "copy"))
    assert run(copy / "charts" / "place_connector.xml")[:2] == (
        0,
        "unchanged: every behavior is as its chart says\n",
    )


def test_what_is_no_manifest_is_not_written_over(run, charts):
    manifest = charts.parent / "manifest" / "place_connector.xml"
    manifest.parent.mkdir()
    manifest.write_text("<notes/>")
    code, _out, err = run(charts / "place_connector.xml")
    assert (code, manifest.read_text()) == (2, "<notes/>")
    assert "is no manifest of a behavior" in err


def test_the_longest_name_can_be_written(run, charts):
    chart = charts / "plain.xml"
    name = "T" * 200
    chart.write_text(chart.read_text().replace("plain_chart", name))
    code, _out, err = run(chart)
    assert (code, err) == (0, "")
    assert (charts.parent / "src" / "cell" / f"{name.lower()}_sm.py").is_file()
