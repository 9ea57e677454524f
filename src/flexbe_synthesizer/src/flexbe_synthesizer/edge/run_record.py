"""Read what an engine reported of a run."""

from __future__ import annotations

import json
from pathlib import Path

from flexbe_synthesizer.edge.files import read_regular_text
from flexbe_synthesizer.errors import DrawingError


def read_run(path: Path) -> tuple[tuple[str, str], ...]:
    """Return (path of the state, outcome) of each step of a run.

    Raises:
        DrawingError: if the file is no such record.
    """
    try:
        steps = json.loads(read_regular_text(path))
        if not isinstance(steps, list):
            raise ValueError("it is no list")
        return tuple(map(_step, steps))
    except (OSError, ValueError, RecursionError) as error:
        raise DrawingError(
            f'{path} is no record of a run, [["/Locate", "located"], ...]: {error}'
        ) from error


def _step(step: object) -> tuple[str, str]:
    if isinstance(step, list) and len(step) == 2 and all(isinstance(part, str) for part in step):
        return step[0], step[1]
    raise ValueError(f"found {step!r} in it, not a path and an outcome")
