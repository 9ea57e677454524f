"""Play scenarios one after another, and find out how they ended."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from pathlib import Path

import rospkg

from flexbe_testing.core.conformance.scenario import (
    Finding,
    NotJudgedError,
    Scenario,
    Verdict,
    ViolationError,
)
from flexbe_testing.ros.conformance.bench import PACKAGE, Bench, StuckError
from flexbe_testing.ros.conformance.catalogue import FIRST
from flexbe_testing.ros.conformance.interrupt import Interrupt, InterruptedByUserError
from flexbe_testing.ros.conformance.wire import EngineWire, NoEngineError


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
