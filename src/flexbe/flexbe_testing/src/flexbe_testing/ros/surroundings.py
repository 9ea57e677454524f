"""What runs beside a test: nodes of a launch file."""

from __future__ import annotations

import os
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager

import rosnode
import rospy
import rosservice
import rostopic

from flexbe_testing.core.case import Case
from flexbe_testing.edge.case_files import resource
from flexbe_testing.errors import CaseError

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
    """Evaluate a condition of a test case, which is trusted as code is (see core/values.py)."""
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
