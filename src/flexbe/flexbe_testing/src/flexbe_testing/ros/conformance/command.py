"""The command engine_conformance."""

from __future__ import annotations

import argparse
import socket
import sys
from collections.abc import Sequence

import rosgraph
import rospy

from flexbe_testing.core.conformance import report
from flexbe_testing.core.conformance.scenario import (
    Finding,
    Scenario,
    UnknownScenarioError,
    Verdict,
    chosen,
)
from flexbe_testing.ros.conformance.catalogue import ALL
from flexbe_testing.ros.conformance.interrupt import Interrupt, InterruptedByUserError
from flexbe_testing.ros.conformance.judge import Judge, behavior_package
from flexbe_testing.ros.conformance.wire import NoEngineError

KEPT, BROKEN, USAGE, NO_ENGINE, INTERRUPTED = 0, 1, 2, 4, 130

# [s] No step of a scenario is waited for longer.
_LONGEST_S = 3600.0

# [s] Wall time that a ROS master gets to answer.
_MASTER_LIMIT_S = 5.0

_EPILOG = """\
The engine must know the package flexbe_conformance_behaviors. Start it in a shell in which you ran
  eval "$(rosrun flexbe_testing engine_conformance --environment)"
and then, from any shell of the same ROS master,
  rosrun flexbe_testing engine_conformance                    # the engine in namespace /
  rosrun flexbe_testing engine_conformance __ns:=/left_arm    # the engine in namespace /left_arm
  rosrun flexbe_testing engine_conformance --only repeat --only attach

Behaviors are started and stopped many times; they only log, wait and publish nothing else.

Scenarios of what is not there (a mirror, an action server, a service) are "not judged", and so are
some scenarios of unsupervised behaviors while a mirror runs. Sections are those of the contract of
FlexBE's interfaces, summarized in docs/engine-conformance.md.

exit codes: 0 nothing that was judged is broken, 1 something is broken, 2 usage error, 4 no ROS
master or idle engine in time, 130 interrupted
"""


def main(words: Sequence[str]) -> int:
    """Judge an engine; return the exit code.

    Args:
        words: the command line, without the words for ROS.
    """
    options = _arguments(words)
    try:
        scenarios = chosen(ALL, options.only)
        if options.list:
            return _print(report.listing(scenarios))
        if options.environment:
            return _print(_environment())
        if (missing := _missing_master()) is not None:
            return _complain(missing, NO_ENGINE)
        rospy.init_node("engine_conformance", anonymous=True, disable_signals=True)
        interrupt = Interrupt()
        with interrupt.on_sigint():
            return _judge(scenarios, options, interrupt)
    except UnknownScenarioError as error:
        return _complain(str(error), USAGE)
    except NoEngineError as error:
        return _complain(str(error), NO_ENGINE)
    except (KeyboardInterrupt, InterruptedByUserError):
        return INTERRUPTED


def _judge(scenarios: Sequence[Scenario], options: argparse.Namespace, interrupt: Interrupt) -> int:
    found: list[Finding] = []
    for finding in Judge(options.limit, options.quiet, interrupt).judge(scenarios):
        found.append(finding)
        if not options.json:
            _print(report.progress(finding))
    _print(report.as_json(found) if options.json else f"\n{report.table(found)}")
    return BROKEN if any(finding.verdict is Verdict.FAIL for finding in found) else KEPT


def _environment() -> str:
    """Return what a shell runs so that its engine knows the behaviors."""
    package = behavior_package()
    return (
        f'export ROS_PACKAGE_PATH="{package}:$ROS_PACKAGE_PATH"\n'
        f'export PYTHONPATH="{package / "src"}:$PYTHONPATH"'
    )


def _missing_master() -> str | None:
    """Return why there is no ROS master; None if there is one."""
    uri = rosgraph.get_master_uri()
    before = socket.getdefaulttimeout()
    socket.setdefaulttimeout(_MASTER_LIMIT_S)
    try:
        rosgraph.Master("engine_conformance").getPid()
    except OSError:
        advice = "start one with roscore or roslaunch, or set ROS_MASTER_URI"
        return f"no ROS master at {uri}; {advice}"
    finally:
        socket.setdefaulttimeout(before)
    return None


def _arguments(words: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="engine_conformance",
        description="Check that a FlexBE engine keeps to FlexBE's interfaces, by ROS only.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("--list", action="store_true", help="print the scenarios and what each requires")
    add("--only", action="append", default=[], metavar="NAME", help="play only this; repeatable")
    add("--json", action="store_true", help="print the findings as JSON at the end")
    add("--environment", action="store_true", help="print the exports for the engine's shell")
    add("--limit", type=_seconds, default=10.0, metavar="S", help="for each step (default 10)")
    add(
        "--quiet",
        type=_seconds,
        default=0.3,
        metavar="S",
        help="how long to wait for what must not happen (default 0.3: three executions at 10 Hz)",
    )
    return parser.parse_args(words)


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = 0.0
    if not 0.0 < value <= _LONGEST_S:
        raise argparse.ArgumentTypeError(f"{text!r} is not between 0 and {_LONGEST_S:g} s")
    return value


def _print(text: str) -> int:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()
    return KEPT


def _complain(text: str, code: int) -> int:
    sys.stderr.write(f"engine_conformance: {text}\n")
    return code
