"""The bar below the lines of `remodel run`: how far the run is, and what it is doing."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from types import TracebackType

from remodel_msgs.msg import LevelState, UseCaseState
from tqdm import tqdm

from remodel_supervision.core.runs.state import RunState
from remodel_supervision.core.runs.sums import sums_of

# [1] Share of a task that is shown at most before it is done: it may take longer than expected.
_MOST = 0.95

_WIDTH = 60
"""Columns of what is being done; the rest is cut, so that the bar stays in one line."""


class RunBar:
    """One line of a terminal that is rewritten; nothing where the output is no terminal."""

    def __init__(self, wires: int) -> None:
        """Show an empty bar.

        Args:
            wires: of the run, each a part of the bar; a cable has several.
        """
        self._bar = tqdm(
            total=wires,
            file=sys.stdout,
            leave=False,
            disable=None,
            bar_format="{percentage:3.0f} % |{bar:16}| {elapsed}  {desc}",
        )

    def __enter__(self) -> RunBar:
        """Return the bar."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Remove the bar."""
        self._bar.close()

    def write(self, line: str) -> None:
        """Print a line above the bar."""
        self._bar.write(line)

    def show(
        self, run: RunState, state: UseCaseState | None, expected_s: Mapping[str, float]
    ) -> None:
        """Show how far the run is.

        Args:
            run: by its log.
            state: what the supervisor has published last of this run; None if nothing yet.
            expected_s: how long each task was expected to take [s, ROS time].
        """
        now, sums = "" if state is None else doing(state), sums_of(run)
        ended = sums.done_in_all + sums.skipped
        self._bar.set_description_str(f"{ended} of {sums.tasks} tasks  {now}", refresh=False)
        wires = sum(task.stage.is_lasting for task in run.tasks.values())
        self._bar.n = wires + (0.0 if state is None else share(state, expected_s))
        self._bar.refresh()


def share(state: UseCaseState, expected_s: Mapping[str, float]) -> float:
    """Return how much of the task under way is done, 0 to 1, by the time that it was to take."""
    expected = expected_s.get(state.task, 0.0)
    since = next((level.since for level in state.levels if level.level == LevelState.TASK), None)
    if not expected or since is None or since.is_zero():
        return 0.0
    return min(_MOST, max(0.0, (state.stamp - since).to_sec() / expected))


def doing(state: UseCaseState) -> str:
    """Return what a run is doing, in some words."""
    action = next((each for each in state.levels if each.level == LevelState.ACTION), None)
    if state.phase == UseCaseState.RUNNING and state.task:
        ability = f": {action.name}, {action.doing}" if action and action.name else ""
        return f"{state.task}{ability}"[:_WIDTH]
    about = f" {state.task}" if state.task else ""
    return f"{state.phase.replace('_', ' ')}{about}"
