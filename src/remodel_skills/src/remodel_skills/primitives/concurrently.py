"""Run several steps at once, tick by tick."""

from __future__ import annotations

from typing import Any

from remodel_skills.robot_context import Steps


def concurrently(*all_steps: Steps[Any]) -> Steps[tuple[Any, ...]]:
    """Do one step of each per tick, until the last is done; return what each returns.

    When one of them raises, the others are stopped where they are.
    """
    results: dict[int, Any] = {}
    pending = dict(enumerate(all_steps))
    try:
        while pending:
            for i, steps in tuple(pending.items()):
                try:
                    next(steps)
                except StopIteration as done:
                    results[i] = done.value
                    del pending[i]
            if pending:
                yield
    finally:
        for steps in pending.values():
            steps.close()
    return tuple(results[i] for i in range(len(all_steps)))
