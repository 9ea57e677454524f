"""Suggest the names that were perhaps meant."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence

# How alike (0 to 1) a name must be to be offered.
_ALIKE = 0.5


def unknown_behavior(name: str, known: Sequence[str]) -> str:
    """Return the message for a request for a behavior that does not exist."""
    if not known:
        return (
            f"unknown behavior {name!r}: there are no behaviors on the ROS package path; "
            "is the workspace sourced?"
        )
    by_lower = {candidate.lower(): candidate for candidate in known}
    near = difflib.get_close_matches(name.lower(), list(by_lower), n=3, cutoff=_ALIKE)
    if near:
        return f"unknown behavior {name!r}; near it: {_quoted(by_lower[n] for n in near)}"
    return f"unknown behavior {name!r}; there are: {_quoted(known)}"


def _quoted(names: Iterable[str]) -> str:
    return ", ".join(f"'{name}'" for name in names)
