"""One request to the synthesis server, without ROS around it."""

import shutil
import time
from pathlib import Path

import pytest

from flexbe_synthesizer.core.chart.problem import MOST_ERRORS
from flexbe_synthesizer.edge.chart_files import ChartMemory
from flexbe_synthesizer.synthesis import (
    ErrorCode,
    Request,
    RequestError,
    Settings,
    deadline,
    fulfil,
)


@pytest.fixture
def settings(tmp_path, golden, package_path):
    shutil.copytree(golden / "charts", tmp_path / "charts")
    shutil.copy(golden / "wrong" / "ten_mistakes.xml", tmp_path / "charts")
    return Settings((tmp_path / "charts",), tmp_path / "behaviors", package_path)


@pytest.fixture
def ask(settings):
    def ask(
        goal,
        initial="",
        outcomes=(),
        report=lambda _status, _progress: None,
        expect_time=lambda: None,
        memory=None,
        **changes,
    ):
        changed = Settings(**{**vars(settings), **changes})
        return fulfil(
            Request(goal, initial, tuple(outcomes)), changed, report, expect_time, memory=memory
        )

    return ask


def refusal(ask, *arguments, **changes):
    with pytest.raises(RequestError) as caught:
        ask(*arguments, **changes)
    return caught.value.code, str(caught.value)


def test_a_chart_is_written_and_its_states_are_returned(ask, settings):
    steps = []
    answer = ask("wire_task.xml", report=lambda status, progress: steps.append((progress, status)))
    assert [s.state_path for s in answer.states][:2] == ["/", "/Set place_attempts"]
    assert answer.states[0].initial_state_name == "Set place_attempts"
    assert {p.name for p in answer.written} >= {"wire_task_sm.py", "place_connector_sm.py"}
    assert [progress for progress, _ in steps] == sorted(progress for progress, _ in steps)
    assert ask(str(settings.chart_folders[0] / "wire_task.xml")).written == ()


def test_a_chart_that_is_written_again_and_again_is_synthesized_each_time(ask, settings):
    chart = settings.chart_folders[0] / "place_wire_w1.xml"
    text = (settings.chart_folders[0] / "plain.xml").read_text()
    for wait in ('"3"', '"4"', '"5"'):
        chart.write_text(text.replace("plain_chart", "Place Wire W1").replace('"2"', wait))
        assert "place_wire_w1.yaml" in {path.name for path in ask(chart.name).written}


def test_what_is_remembered_of_a_request_never_outlives_a_change(ask, settings):
    memory = ChartMemory()
    first = ask("wire_task.xml", memory=memory)
    again = ask("wire_task.xml", memory=memory)
    assert (again.states, again.written) == (first.states, ())
    inner = settings.chart_folders[0] / "place_connector.xml"
    inner.write_text(inner.read_text().replace('ext:attempts="3"', 'ext:attempts="4"'))
    changed = {path.name for path in ask("wire_task.xml", memory=memory).written}
    assert changed == {"place_connector_sm.py", "place_connector.yaml", "wire_task.yaml"}
    inner.write_text(inner.read_text().replace('target="Fix"', 'target="Fax"'))
    assert refusal(ask, "wire_task.xml", memory=memory)[0] is ErrorCode.CHART_INVALID


def test_start_and_nothing_mean_where_the_chart_starts(ask):
    for initial in ("", " ", "start", "Locate"):
        assert ask("plain.xml", initial).states[0].initial_state_name == "Locate"


def test_another_initial_state_changes_the_states_and_not_the_behavior(ask, settings):
    first = ask("place_connector.xml")
    answer = ask("place_connector.xml", "Extract")
    assert answer.states[0].initial_state_name.startswith("Set ")
    (last_preset,) = [s for s in answer.states if s.state_path == "/Set insert_attempts"]
    assert last_preset.transitions == ("Extract",)
    assert first.written != ()
    assert answer.written == ()


def test_an_initial_state_that_reads_what_no_state_wrote_is_refused(ask, settings):
    code, text = refusal(ask, "place_connector.xml", "Fix")
    assert code is ErrorCode.CHART_INVALID
    assert "started at 'Fix'" in text
    assert "[read-before-write]" in text
    assert not settings.output.exists()


def test_an_initial_state_that_is_not_there_is_refused(ask):
    code, text = refusal(ask, "plain.xml", "Lokate")
    assert code is ErrorCode.INITIAL_UNKNOWN
    assert "Did you mean 'Locate'?" in text


def test_the_outcomes_must_be_those_of_the_chart_in_any_order(ask, settings):
    assert ask("place_connector.xml", outcomes=["failed", "finished"]).states
    code, text = refusal(ask, "plain.xml", "", ["finished", "failed"])
    assert code is ErrorCode.OUTCOMES_DIFFER
    assert "has 'PlacePin finished normally', 'failed'" in text


def test_a_chart_with_errors_is_refused_with_all_of_them(ask, settings):
    code, text = refusal(ask, "ten_mistakes.xml")
    assert code is ErrorCode.CHART_INVALID
    assert len(text.splitlines()) == 10
    assert not settings.output.exists()


def test_missing_files_and_files_outside_are_distinguished(ask):
    assert refusal(ask, "none.xml")[0] is ErrorCode.CHART_NOT_FOUND
    assert refusal(ask, "")[0] is ErrorCode.CHART_NOT_FOUND
    assert refusal(ask, "a" * 5000)[0] is ErrorCode.CHART_NOT_FOUND
    assert refusal(ask, "../none.xml")[0] is ErrorCode.CHART_REFUSED
    assert refusal(ask, "/etc/passwd")[0] is ErrorCode.CHART_REFUSED


def test_a_package_that_cannot_be_written_to_is_reported(ask, tmp_path):
    (tmp_path / "file").write_text("")
    code, text = refusal(ask, "plain.xml", output=tmp_path / "file" / "package")
    assert code is ErrorCode.OUTPUT_FAILED
    assert "nothing was written" in text


def test_without_the_state_that_writes_counts_attempts_cannot_be_listed(
    ask, tmp_path, package_path
):
    packages = shutil.copytree(package_path, tmp_path / "packages")
    (Path(packages) / "flexbe_states/src/flexbe_states/user_data_state.py").unlink()
    code, text = refusal(ask, "place_connector.xml", ros_package_path=str(packages))
    assert code is ErrorCode.CHART_INVALID
    assert "UserDataState" in text
    assert ask("plain.xml", ros_package_path=str(packages)).states


def test_the_observer_of_a_step_can_end_the_request(ask, settings):
    def stop(status, _progress):
        if "writing" in status:
            raise RequestError(ErrorCode.CANCELLED, "enough")

    assert refusal(ask, "plain.xml", report=stop)[0] is ErrorCode.CANCELLED
    assert not settings.output.exists()


def test_a_request_that_takes_too_long_is_ended_at_its_next_step(ask, settings):
    times = iter(range(100))
    expect_time = deadline(2.5, lambda: next(times))
    code, text = refusal(ask, "plain.xml", expect_time=expect_time)
    assert code is ErrorCode.OUT_OF_TIME
    assert "more than 2.5 s" in text
    assert not settings.output.exists()


WRONG = '<state id="S{0}" type="NoSuchState{0}" {1}/>'


@pytest.mark.parametrize("attributes", ["", 'a{0}="1" b{0}="2"'], ids=["checking", "reading"])
def test_a_request_can_be_ended_while_its_chart_is_read_or_checked(ask, settings, attributes):
    states = "".join(WRONG.format(n, attributes.format(n)) for n in range(100))
    head = '<statemachine name="A" initial="S0"><datamodel><outcome name="x"/></datamodel>'
    chart = settings.chart_folders[0] / "wrong.xml"
    chart.write_text(f"{head}{states}</statemachine>")
    steps, calls = [], []

    def expect_time():
        calls.append(len(steps))
        if calls.count(len(steps)) > 150:
            raise RequestError(ErrorCode.CANCELLED, "enough")

    def report(status, _progress):
        steps.append(status)

    assert refusal(ask, "wrong.xml", report=report, expect_time=expect_time)[0] is (
        ErrorCode.CANCELLED
    )
    assert ("checking" in steps[-1]) is (not attributes)


def test_very_many_errors_are_reported_up_to_a_limit_and_in_time(ask, settings):
    names = " ".join(f'a{n}="1"' for n in range(100_000))
    chart = settings.chart_folders[0] / "wrong.xml"
    head = '<statemachine name="A" initial="S"><datamodel><outcome name="x"/></datamodel>'
    chart.write_text(f'{head}<state id="S" type="WaitState" {names}/></statemachine>')
    before = time.process_time()
    code, text = refusal(ask, "wrong.xml")
    assert time.process_time() - before < 10.0  # [s] of CPU; it took hours
    assert code is ErrorCode.CHART_INVALID
    assert "99980 more attributes that are unknown" in text
    chart.write_text(f"{head}{'<unknown/>' * 50_000}</statemachine>")
    before = time.process_time()
    code, text = refusal(ask, "wrong.xml")
    assert time.process_time() - before < 10.0
    assert len(text.splitlines()) == MOST_ERRORS
    assert text.endswith("No more is checked after 1000 errors; correct these first.")


def test_links_out_of_the_folders_and_bombs_are_refused(ask, settings, tmp_path):
    charts = settings.chart_folders[0]
    (tmp_path / "secret.xml").write_text("<secret/>")
    (charts / "link.xml").symlink_to(tmp_path / "secret.xml")
    assert refusal(ask, "link.xml")[0] is ErrorCode.CHART_REFUSED
    bomb = "<!DOCTYPE a [<!ENTITY b 'bbbb'><!ENTITY c '&b;&b;&b;'>]>"
    (charts / "bomb.xml").write_text(f"{bomb}<statemachine>&c;</statemachine>")
    code, text = refusal(ask, "bomb.xml")
    assert (code, "[doctype]" in text) == (ErrorCode.CHART_INVALID, True)
    assert not settings.output.exists()


def package(folder, name):
    """Make a package for behaviors; return its folder."""
    (folder / name / "charts").mkdir(parents=True)
    (folder / name / "package.xml").write_text(
        f"<package><name>{name}</name><export><flexbe_behaviors/></export></package>"
    )
    return folder / name


def test_a_chart_of_a_package_is_written_there_so_that_the_engine_runs_what_was_written(
    ask, settings, tmp_path
):
    """It was written to the server's own package, and the engine ran the old version."""
    mine = package(tmp_path / "src", "my_behaviors")
    chart = shutil.copy(settings.chart_folders[0] / "plain.xml", mine / "charts")
    path = f"{mine}:{settings.ros_package_path}"
    changes = {"chart_folders": (mine / "charts",), "ros_package_path": path}
    for _ in range(2):
        written = ask("plain.xml", **changes).written
        assert written
        assert all(mine in file.parents for file in written)
        text = Path(chart).read_text()
        Path(chart).write_text(text.replace("<datamodel>", "<datamodel><input name='more'/>", 1))
    assert not settings.output.exists()


def test_a_package_that_will_come_first_on_the_path_is_made(ask, settings, tmp_path):
    first = package(tmp_path / "src", "first")
    shutil.copy(settings.chart_folders[0] / "plain.xml", first / "charts")
    later = {
        "chart_folders": (first / "charts",),
        "ros_package_path": f"{first}:{settings.ros_package_path}",
    }
    assert ask("plain.xml", **later).written
    made = {"ros_package_path": f"{settings.output}:{first}:{settings.ros_package_path}"}
    assert ask("plain.xml", **made).written
    (settings.output / "package.xml").unlink()
    code, _text = refusal(ask, "plain.xml", ros_package_path=later["ros_package_path"])
    assert code is ErrorCode.OUTPUT_FAILED


def test_a_behavior_that_the_engine_would_not_run_is_refused(ask, settings, tmp_path):
    first, second = (package(tmp_path / "src", name) for name in ("first", "second"))
    for folder in (second, first):
        shutil.copy(settings.chart_folders[0] / "plain.xml", folder / "charts")
    path = f"{first}:{second}:{settings.ros_package_path}"
    of_first = {"chart_folders": (first / "charts",), "ros_package_path": path}
    assert ask("plain.xml", **of_first).written
    of_second = {**of_first, "chart_folders": (second / "charts",)}
    code, text = refusal(ask, "plain.xml", **of_second)
    assert code is ErrorCode.OUTPUT_FAILED
    assert f"{first} has one of that name, and comes first on the ROS package path" in text
    assert not (second / "src").exists()
