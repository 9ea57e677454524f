"""Paths of states in the behaviors of tasks."""

from __future__ import annotations


def step_of(state_path: str) -> str:
    """Return the title of the step of a task that a state is of: the first name in its path."""
    return state_path.strip("/").split("/")[0]
