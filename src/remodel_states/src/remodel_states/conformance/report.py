"""Findings of a server's trials, in words and as JSON."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict

from remodel_states.conformance.trial import Trial


def line(trial: Trial) -> str:
    """Return what a person reads about a trial."""
    if trial.unjudged:
        return f"not judged  {trial.name}: {trial.unjudged}"
    if not trial.faults:
        return f"ok          {trial.name}"
    found = "".join(f"\n            [{fault.rule}] {fault.found}" for fault in trial.faults)
    return f"BROKEN      {trial.name}{found}"


def summary(trials: Sequence[Trial]) -> str:
    """Return the last line: how many trials were kept, broken and not judged."""
    broken = sum(bool(trial.faults) for trial in trials)
    unjudged = sum(bool(trial.unjudged) for trial in trials)
    return f"{len(trials) - broken - unjudged} kept, {broken} broken, {unjudged} not judged"


def as_json(topic: str, action: str, trials: Sequence[Trial]) -> str:
    """Return all trials as JSON."""
    found = [asdict(trial) for trial in trials]
    return json.dumps({"topic": topic, "action": action, "trials": found}, indent=2)
