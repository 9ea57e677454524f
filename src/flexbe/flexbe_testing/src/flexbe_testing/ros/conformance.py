"""The command engine_conformance: play scenarios one after another, and judge how they ended."""

from __future__ import annotations

import argparse
import socket
import sys
import time
import xmlrpc.client
from collections.abc import Iterable, Iterator, Sequence
from http.client import HTTPException
from pathlib import Path

import rosgraph
import rospkg
import rospy

from flexbe_testing.core.scenario import (
    Finding,
    NotJudgedError,
    Scenario,
    UnknownScenarioError,
    Verdict,
    ViolationError,
    as_json,
    chosen,
    listing,
    progress,
    scenarios_of,
    table,
)
from flexbe_testing.ros.bench import PACKAGE, Bench, StuckError
from flexbe_testing.ros.scenarios import commands, running, starting
from flexbe_testing.ros.wire import EngineWire, Interrupt, InterruptedByUserError, NoEngineError

# Without this one nothing else can be judged.
FIRST: Scenario = starting.runs_behaviors
# All scenarios, in the order in which they are played.
ALL: tuple[Scenario, ...] = tuple(
    item for module in (starting, commands, running) for item in scenarios_of(module)
)

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
            return _print(listing(scenarios))
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
            _print(progress(finding))
    _print(as_json(found) if options.json else f"\n{table(found)}")
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
    except (OSError, ValueError, HTTPException, xmlrpc.client.Error, rosgraph.MasterException):
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


# Play scenarios one after another, and find out how they ended


def behavior_package() -> Path:
    """Return the folder of the behaviors that an engine under test must know."""
    return Path(rospkg.RosPack().get_path("flexbe_testing")) / "conformance" / PACKAGE


class Judge:
    """Plays scenarios against the engine in this node's namespace.

    Attributes:
        bench: the engine under test.
    """

    def __init__(
        self, limit_s: float = 10.0, quiet_s: float = 0.3, interrupt: Interrupt | None = None
    ) -> None:
        """Connect to the engine.

        Args:
            limit_s: how long the engine may take for each step [s, wall time].
            quiet_s: for how long something that must not happen is waited for [s, wall time].
            interrupt: ends the judging when it is set.

        Raises:
            NoEngineError: if there is no engine, or if it runs a behavior.
            InterruptedByUserError: if it was interrupted.
        """
        self._interrupt = interrupt or Interrupt()
        wire = EngineWire(limit_s, self._interrupt)
        self.bench = Bench(wire, behavior_package(), limit_s, quiet_s)
        self._stuck = ""
        # The latched one; an engine that has just started publishes it after it can be found.
        tape = self.bench.wire.tape
        tape.wait(lambda: bool(tape.statuses), limit_s)
        if tape.is_running:
            raise NoEngineError("the engine runs a behavior; stop it first")

    def judge(self, scenarios: Iterable[Scenario]) -> Iterator[Finding]:
        """Play scenarios, before them the one that all others need, and yield each finding.

        Raises:
            InterruptedByUserError: once the engine is at rest, if it was interrupted.
        """
        first = self.play(FIRST)
        if first.verdict is Verdict.FAIL:
            self._stuck = self._stuck or f"{FIRST.name} failed"
        yield first
        for scenario in scenarios:
            if scenario is not FIRST:
                yield self.play(scenario)
        self._interrupt.check()

    def play(self, scenario: Scenario) -> Finding:
        """Play a scenario, and bring the engine back to rest, also after an interrupt."""
        if self._stuck:
            return Finding(scenario, Verdict.NOT_JUDGED, self._stuck)
        self._interrupt.check()
        begun = time.monotonic()
        try:
            try:
                verdict, reason = self._verdict(scenario)
            finally:
                self.bench.recover()
        except StuckError as error:
            self._stuck = f"the engine is stuck since {scenario.name}: {error}"
            if isinstance(error.__context__, InterruptedByUserError):
                raise error.__context__ from None
        if verdict is Verdict.FAIL:
            self.bench.drain()
        return Finding(scenario, verdict, reason, time.monotonic() - begun)

    def _verdict(self, scenario: Scenario) -> tuple[Verdict, str]:
        self.bench.begin()
        try:
            scenario.play(self.bench)
            self.bench.finish()
        except ViolationError as violation:
            return Verdict.FAIL, str(violation)
        except NotJudgedError as reason:
            return Verdict.NOT_JUDGED, str(reason)
        return Verdict.PASS, ""
