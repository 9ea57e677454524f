"""What states do in a run: a function of seed, path and number of the visit.

The engine's states and the reference interpreter ask the same script, and share nothing else.
"""

from __future__ import annotations

from typing import NamedTuple
from zlib import crc32

LONGEST_DELAY = 6  # executions that return None before the outcome


class Plan(NamedTuple):
    """What a state does in one visit: executions without an outcome, outcome, what it writes."""

    delay: int
    outcome: str
    values: dict[str, int]


class Script:
    """What the states of one run do, and a log of what they have read.

    Attributes:
        entered: (path, constructor arguments, inputs) of each visit.
    """

    def __init__(self, seed: str) -> None:
        """Begin a run."""
        self._seed = seed
        self._visits: dict[str, int] = {}
        self.entered: list[tuple[str, dict, dict]] = []

    def plan(self, path: str, outcomes: tuple[str, ...], outputs: tuple[str, ...]) -> Plan:
        """Return what a state does in its next visit."""
        visit = self._visits[path] = self._visits.get(path, 0) + 1
        drawn = crc32(f"{self._seed} {path} {visit}".encode())
        delay = max(0, drawn % 16 - 9)
        values = {key: self._value(key, path, visit) for key in outputs}
        return Plan(min(delay, LONGEST_DELAY), outcomes[(drawn >> 8) % len(outcomes)], values)

    def _value(self, key: str, path: str, visit: int) -> int:
        drawn = crc32(f"{key} {path} {visit} {self._seed}".encode())
        if key == "error_code":
            return drawn % 8
        return 0 if drawn % 9 == 0 else drawn


_running = [Script("")]


def start(script: Script) -> None:
    """Have the states follow a script from now on."""
    _running[0] = script


def on_enter(state, userdata) -> None:
    """Read all inputs, and make a plan; the `on_enter` of scripted states."""
    read = {key: userdata[key] for key in state.input_keys}
    script = _running[0]
    script.entered.append((state.path, getattr(state, "arguments", {}), read))
    outcomes = tuple(name for name in state.outcomes if name != "preempted")
    state.plan = script.plan(state.path, outcomes, tuple(state.output_keys))
    state.left = state.plan.delay


def execute(state, userdata) -> str | None:
    """Carry out the plan; the `execute` of scripted states.

    `writes` of a state's class lists what an outcome writes, if not all.
    """
    if state.left > 0:
        state.left -= 1
        return None
    plan = state.plan
    for key in getattr(state, "writes", {}).get(plan.outcome, plan.values):
        userdata[key] = plan.values[key]
    return plan.outcome
