"""The command line of be_launcher, and what its exit codes say."""

import pytest

from flexbe_widget.core.command_line import CommandLine, read_command_line
from flexbe_widget.core.run_watch import MEANINGS, Ending, ExitCode, RunEnd, exit_code
from flexbe_widget.ros.request_server import unknown_behavior


def test_without_words_it_serves_requests():
    assert read_command_line([]) == CommandLine("", 255, (), (), wait_s=10.0)


def test_options_and_parameters_come_in_any_order():
    words = ["speed:=1.5", "-b", "Two Words", "/A/n:=2", "-a", "1", "-i", "x=[1]", "text:=a b"]
    words += ["-w", "3"]
    assert read_command_line(words) == CommandLine(
        "Two Words",
        1,
        (("/speed", "1.5"), ("/A/n", "2"), ("/text", "a b")),
        (("x", "[1]"),),
        wait_s=3.0,
    )


def test_what_roslaunch_adds_is_left_alone():
    words = ["-b", "X", "__name:=launcher", "__log:=/tmp/log", "__ns:=arm"]
    assert read_command_line(words).parameters == ()


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (["hello"], "'hello' is neither an option nor of the form key:=value"),
        ([":=5"], "':=5' is neither an option"),
        (["-i", "x"], "'x' is neither an option nor of the form key=value"),
        (["-a", "300"], "'300' is not a level from 0 to 255"),
        (["-a", "high"], "'high' is not a level"),
        (["-w", "-1"], "'-1' is not a number of seconds"),
        (["-w", "nan"], "'nan' is not a number of seconds"),
        (["--no-such-option"], "unrecognized arguments"),
    ],
)
def test_senseless_words_are_explained(words, text, capsys):
    with pytest.raises(SystemExit) as ended:
        read_command_line(words)
    assert ended.value.code == ExitCode.USAGE
    assert text in capsys.readouterr().err


def test_help_lists_options_examples_and_exit_codes(capsys):
    with pytest.raises(SystemExit) as ended:
        read_command_line(["--help"])
    assert ended.value.code == 0
    text = capsys.readouterr().out
    assert "--behavior NAME" in text
    assert "rosrun flexbe_widget be_launcher -b 'Example Behavior'" in text
    for code in ExitCode:
        assert f"{code.value:<4}{MEANINGS[code]}" in text


@pytest.mark.parametrize(
    ("ending", "code"),
    [
        (Ending(RunEnd.FINISHED, "finished"), ExitCode.FINISHED),
        (Ending(RunEnd.FINISHED, "failed"), ExitCode.FAILED_OUTCOME),
        (Ending(RunEnd.PREEMPTED, "preempted"), ExitCode.PREEMPTED),
        (Ending(RunEnd.FAILED), ExitCode.FAILED),
        (Ending(RunEnd.REFUSED), ExitCode.REFUSED),
        (Ending(RunEnd.LATE), ExitCode.REFUSED),
        (Ending(RunEnd.RESTARTED), ExitCode.ENGINE_LOST),
        (Ending(RunEnd.LOST), ExitCode.ENGINE_LOST),
    ],
)
def test_each_end_has_its_exit_code(ending, code):
    assert exit_code(ending) is code


def test_only_outcomes_that_are_given_are_a_success():
    line = read_command_line(["-b", "X", "--success", "finished", "-s", "failed"])
    codes = {
        outcome: exit_code(Ending(RunEnd.FINISHED, outcome), line.success)
        for outcome in ("finished", "failed", "command_error")
    }
    assert codes == {
        "finished": ExitCode.FINISHED,
        "failed": ExitCode.FINISHED,
        "command_error": ExitCode.FAILED_OUTCOME,
    }
    assert exit_code(Ending(RunEnd.PREEMPTED, "preempted"), line.success) is ExitCode.PREEMPTED


def test_every_end_has_an_exit_code():
    for end in RunEnd:
        assert exit_code(Ending(end)) in ExitCode


def test_near_names_are_offered_whatever_the_case():
    text = unknown_behavior("example behaviour", ["Example Behavior", "Place Connector"])
    assert text == "unknown behavior 'example behaviour'; near it: 'Example Behavior'"


def test_without_a_near_name_all_are_listed():
    text = unknown_behavior("zzz", ["A B", "C"])
    assert text == "unknown behavior 'zzz'; there are: 'A B', 'C'"


def test_without_any_behavior_the_workspace_is_suspected():
    assert "is the workspace sourced?" in unknown_behavior("x", [])
