"""Run test cases and tell how they ended: on the terminal, or as a ROS test."""

from __future__ import annotations

import logging
import sys
import unittest
from collections.abc import Sequence
from pathlib import Path

import rospy
import rostest

from flexbe_testing.core.verdict import Verdict
from flexbe_testing.edge.case_files import case_files, read_case_file
from flexbe_testing.errors import CaseError
from flexbe_testing.ros.run_case import run_case

_MUTED = {"mute_info": logging.INFO, "mute_warn": logging.WARNING, "mute_error": logging.ERROR}


def main(words: Sequence[str]) -> int:
    """Run the test cases that the words name; return 0 if all succeeded.

    Args:
        words: the command line, without the words for ROS.
    """
    _mute()
    options = [word for word in words if word.startswith("--")]
    names = [word for word in words if not word.startswith("--")]
    try:
        files = case_files(names, str(rospy.get_param("~package", "")))
    except CaseError as error:
        _say(str(error))
        return 2
    if not files:
        _say("there are no test cases; name some, or a package whose folder tests/ has some")
        return 2
    if rospy.get_param("~perform_rostest", False):
        rostest.rosrun("flexbe_testing", "flexbe_rostest", _as_unittest(files), ["", *options])
        return 0  # rostest.rosrun itself ends the process with 1 if a test fails
    return 0 if all([_run_and_tell(file).is_good for file in files]) else 1


def _verdict(file: Path) -> Verdict:
    try:
        return run_case(read_case_file(file))
    except CaseError as error:
        return Verdict(file.stem, (str(error),))


def _run_and_tell(file: Path) -> Verdict:
    is_compact = rospy.get_param("~compact_format", False)
    if not is_compact:
        _say(f"{file}:")
    verdict = _verdict(file)
    word = "ok" if verdict.is_good else "FAILED"
    shown = "print_debug_positive" if verdict.is_good else "print_debug_negative"
    _say(f"{verdict.title}: {word}" if is_compact else f"    {word}")
    if rospy.get_param(f"~{shown}", True):
        for complaint in verdict.complaints:
            _say(f"    {complaint}")
    return verdict


def _as_unittest(files: Sequence[Path]) -> type[unittest.TestCase]:
    """Return a test with one method for each case."""

    def method(file: Path) -> object:
        def test(self: unittest.TestCase) -> None:
            verdict = _run_and_tell(file)
            self.assertTrue(verdict.is_good, "\n".join(verdict.complaints))

        return test

    methods = {f"test_{file.stem}": method(file) for file in files}
    return type("FlexbeTest", (unittest.TestCase,), methods)


def _mute() -> None:
    muted = {level for name, level in _MUTED.items() if rospy.get_param(f"~{name}", False)}
    logging.getLogger("rosout").addFilter(lambda record: record.levelno not in muted)


def _say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()
