"""Run the construction of a user's classes in a process of its own."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from flexbe_testing.core.doctor.finding import Finding, Severity
from flexbe_testing.edge.doctor.workspace import Package

# Nothing listens there: whatever asks for a ROS master is refused at once.
_NO_MASTER = "http://127.0.0.1:9"

# [s] Wall time that the child gets for its own imports, and between two inspections of it.
_START_LIMIT_S = 60.0
_POLL_S = 0.05

Modules = Sequence[tuple[str, str]]


def construct(
    packages: Sequence[Package], modules: Modules, limit_s: float
) -> tuple[list[Finding], int]:
    """Import modules, and construct their states and behaviors.

    Args:
        packages: the packages whose modules may be imported.
        modules: dotted names and files, of files that are Python 3.
        limit_s: how long one module may take [s, wall time]; one that takes longer is a finding.

    Returns:
        findings, and how many classes were constructed.
    """
    findings: list[Finding] = []
    constructed, rest = 0, list(modules)
    while rest:
        with tempfile.TemporaryDirectory() as folder:
            result, ended = _run(packages, rest, limit_s, Path(folder))
        findings += [_finding(row) for row in result["findings"]]
        constructed += result["constructed"]
        if not result["at"]:
            break
        # User code ended the process: report the module, and continue after it in another process.
        index = [name for name, _ in rest].index(result["at"])
        file = rest[index][1]
        text = f"importing or constructing it {ended}; keep such code out of module and constructor"
        findings.append(Finding(file, 1, "construction", Severity.ERROR, text=text))
        rest = rest[index + 1 :]
    return findings, constructed


def _run(
    packages: Sequence[Package], modules: Modules, limit_s: float, folder: Path
) -> tuple[dict, str]:
    request, result = folder / "request.json", folder / "result.json"
    folders = [str(package.modules) for package in packages]
    request.write_text(json.dumps({"folders": folders, "modules": list(modules)}))
    command = [sys.executable, "-m", "flexbe_testing.ros.doctor.construct", request, result]
    environment = {**os.environ, "ROS_MASTER_URI": _NO_MASTER, "ROS_LOG_DIR": str(folder)}
    with (folder / "errors").open("w+") as errors:
        child = subprocess.Popen(
            command,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=errors,
            start_new_session=True,
        )
        try:
            ended = _watch(child, result, limit_s)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)  # with all that user code has started
            child.wait()
        if not result.exists():
            errors.seek(0)
            raise RuntimeError(f"the doctor's own process failed: {errors.read().strip()[-500:]}")
    return json.loads(result.read_text()), ended


def _watch(child: subprocess.Popen[bytes], result: Path, limit_s: float) -> str:
    """Wait until the child ends or does not get on; return which, for a sentence."""
    seen, end = "", time.monotonic() + _START_LIMIT_S
    while time.monotonic() < end:
        with contextlib.suppress(subprocess.TimeoutExpired):
            return f"ended the process with {child.wait(_POLL_S)}"
        now = result.read_text() if result.exists() else ""
        if now != seen:
            seen, end = now, time.monotonic() + limit_s
    return f"took more than {limit_s:g} s"


def _finding(row: dict) -> Finding:
    severity = Severity(row["severity"])
    return Finding(row["file"], row["line"], row["rule"], severity, text=row["text"])
