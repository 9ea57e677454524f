"""Run test cases and report how they ended: on the terminal, or as a ROS test."""

from __future__ import annotations

import logging
import sys
import unittest
from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path

import rospy
import rostest

from flexbe_testing.core.case import PASS, Case, CaseError, Check, Verdict, check_names
from flexbe_testing.edge.case_files import case_files, read_case_file
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
        _print(str(error))
        return 2
    if not files:
        _print("there are no test cases; name some, or a package whose folder tests/ has some")
        return 2
    if rospy.get_param("~perform_rostest", False):
        rostest.rosrun("flexbe_testing", "flexbe_rostest", _as_unittest(files), ["", *options])
        return 0  # rostest.rosrun itself ends the process with 1 if a test fails
    return 0 if all([_run_and_print(file, _read(file)).is_good for file in files]) else 1


def _read(file: Path) -> Case | Verdict:
    """Return the case in a file, or why there is none."""
    try:
        return read_case_file(file)
    except CaseError as error:
        return Verdict(file.stem, (Check(PASS, str(error)),))


def _run_and_print(file: Path, case: Case | Verdict) -> Verdict:
    is_compact = rospy.get_param("~compact_format", False)
    if not is_compact:
        _print(f"{file}:")
    verdict = case if isinstance(case, Verdict) else run_case(case)
    word = "ok" if verdict.is_good else "FAILED"
    shown = "print_debug_positive" if verdict.is_good else "print_debug_negative"
    _print(f"{verdict.title}: {word}" if is_compact else f"    {word}")
    failed = [check for check in verdict.checks if check.complaint]
    if rospy.get_param(f"~{shown}", True):
        for check in failed if is_compact else verdict.checks:
            _print(f"    {check.name}: {check.complaint or 'ok'}")
    return verdict


def _as_unittest(files: Sequence[Path]) -> type[unittest.TestCase]:
    """Return a test with a method for each result: `test_CASE_pass`, `test_CASE_output_KEY`."""
    methods: dict[str, Callable[[unittest.TestCase], None]] = {}
    for file in files:
        case, number = _read(file), 1
        title = case.title
        while f"test_{title}_{PASS}" in methods:  # of another folder
            number += 1
            title = f"{case.title}_{number}"
        names = (PASS,) if isinstance(case, Verdict) else check_names(case)
        verdict = cache(partial(_run_and_print, file, case))  # each case runs once
        methods |= {f"test_{title}_{name}": _method(verdict, name) for name in names}
    return type("FlexbeTest", (unittest.TestCase,), methods)


def _method(verdict: Callable[[], Verdict], name: str) -> Callable[[unittest.TestCase], None]:
    def test(self: unittest.TestCase) -> None:
        complaint = verdict().check(name).complaint
        self.assertFalse(complaint, complaint)

    return test


def _mute() -> None:
    muted = {level for name, level in _MUTED.items() if rospy.get_param(f"~{name}", False)}
    logging.getLogger("rosout").addFilter(lambda record: record.levelno not in muted)


def _print(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()
