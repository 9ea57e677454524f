"""Run test cases and report how they ended: on the terminal, or as a ROS test."""

from __future__ import annotations

import importlib
import logging
import os
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import unittest
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from typing import Any

import rosnode
import rospy
import rosservice
import rostest
import rostopic

from flexbe_core import Behavior
from flexbe_core.core import State, UserData
from flexbe_core.engine.supervision import UNSUPERVISED
from flexbe_testing.core.case import (
    PASS,
    Case,
    CaseError,
    Check,
    Verdict,
    check_names,
    compare,
    not_run,
    value_of,
)
from flexbe_testing.edge.case_files import BagMessages, case_files, read_case_file, resource

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


# Run one test case, and beside it what it launches


def run_case(case: Case) -> Verdict:
    """Run a test case; whatever goes wrong is a complaint of its result `pass`."""
    try:
        tested = _import(case)
        if case.import_only:
            return Verdict(case.title)
        messages = BagMessages(resource(case.bag) if case.bag else None)
        with surroundings(case) as launched:
            checks = _run(case, tested, messages)
            complaint = ""
            if launched is not None and case.require_launch_success and launched.poll():
                complaint = f"what was launched ended with {launched.returncode}"
        return Verdict(case.title, (Check(PASS, complaint), *checks))
    except CaseError as error:
        return not_run(case, str(error))
    except (Exception, SystemExit) as error:  # noqa: BLE001 - whatever the tested code raises
        return not_run(case, f"{type(error).__name__}: {error}\n{traceback.format_exc()}")


def _import(case: Case) -> type:
    try:
        module = importlib.import_module(case.module)
    except Exception as error:
        raise CaseError(f"cannot import {case.module}: {type(error).__name__}: {error}") from error
    tested = getattr(module, case.class_name, None)
    if not isinstance(tested, type):
        raise CaseError(f"module {case.module} has no class {case.class_name!r}")
    if not issubclass(tested, Behavior | State):
        raise CaseError(f"{case.class_name} is neither a state nor a behavior")
    return tested


def _run(case: Case, tested: type, messages: BagMessages) -> tuple[Check, ...]:
    params, inputs, expected = (
        value_of(dict(written), messages.next_of, bool(case.bag))
        for written in (case.params, case.inputs, case.outputs)
    )
    run = _run_behavior if issubclass(tested, Behavior) else _run_state
    outcome, outputs = run(tested, params, inputs)
    return compare(case.outcome, outcome, expected, outputs)


def _run_state(
    tested: type[State], params: dict[str, Any], inputs: dict[str, Any]
) -> tuple[str | None, dict[str, Any]]:
    """Execute a state by hand until it ends, as the only one of a behavior."""
    state = tested(**params)
    userdata = UserData(input_keys=state.input_keys, output_keys=state.output_keys)
    outputs: dict[str, Any] = {}
    userdata(reference=outputs)
    outputs.update(inputs)
    outcome = None
    state.on_start()
    try:
        while outcome is None and not rospy.is_shutdown():
            outcome = state.execute(userdata)
            if outcome is None:
                state.sleep()
    finally:
        state.on_stop()
    return outcome, outputs


def _run_behavior(
    tested: type[Behavior], params: dict[str, Any], inputs: dict[str, Any]
) -> tuple[str | None, dict[str, Any]]:
    behavior = tested()
    for name, value in params.items():
        if not behavior.set_parameter(name, value):
            raise CaseError(f"behavior {behavior.name!r} has no parameter {name!r}")
    behavior.set_up(id=0, autonomy_level=UNSUPERVISED, debug=False)
    behavior.prepare_for_execution(inputs)
    behavior.confirm()
    outcome = behavior.execute()
    return outcome, behavior.get_userdata().get("", {})


# What runs beside a test: nodes of a launch file


# [s] Wall time that what was launched gets to become ready, and to end.
_READY_LIMIT_S = 30.0
_END_LIMIT_S = 15.0

_CHECK_EVERY_S = 0.05


@contextmanager
def surroundings(case: Case) -> Iterator[subprocess.Popen[bytes] | None]:
    """Launch what a case asks for, and end it with the block.

    Raises:
        CaseError: if it does not become ready in time.
    """
    if not case.launch:
        yield None
        return
    with tempfile.NamedTemporaryFile("w", suffix=".launch") as inline:
        file = inline.name if case.launch.lstrip().startswith("<") else str(resource(case.launch))
        inline.write(case.launch)
        inline.flush()
        process = subprocess.Popen(["roslaunch", file], start_new_session=True)
        try:
            _wait(case, process)
            yield process
        finally:
            _end(process)


def _wait(case: Case, process: subprocess.Popen[bytes]) -> None:
    end = time.monotonic() + _READY_LIMIT_S
    while case.wait_cond and not _is_true(case.wait_cond):
        if process.poll() is not None:
            raise CaseError(f"what was launched ended before {case.wait_cond!r} was true")
        if time.monotonic() > end:
            raise CaseError(f"{case.wait_cond!r} is not true after {_READY_LIMIT_S:g} s")
        time.sleep(_CHECK_EVERY_S)


def _is_true(condition: str) -> bool:
    """Evaluate a condition of a test case, which is trusted as code is (see core/case.py)."""
    names = {"rospy": rospy, "rosnode": rosnode, "rosservice": rosservice, "rostopic": rostopic}
    try:
        return bool(eval(condition, names))
    except SyntaxError as error:
        raise CaseError(f"wait_cond {condition!r} is not Python: {error}") from error
    except Exception as error:  # noqa: BLE001 - what it looks at is perhaps not there yet
        rospy.logdebug("wait_cond %s: %s", condition, error)
        return False


def _end(process: subprocess.Popen[bytes]) -> None:
    for sign in (signal.SIGINT, signal.SIGKILL):
        if process.poll() is None:
            os.killpg(process.pid, sign)
            try:
                process.wait(_END_LIMIT_S)
            except subprocess.TimeoutExpired:
                continue
