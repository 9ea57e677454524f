"""The viewpoint of an observation."""

from __future__ import annotations

# What the field `view` of a goal holds: uint8.
_MOST = 255


def checked_view(view: object) -> int:
    """Return a viewpoint's number.

    Raises:
        ValueError: if it does not fit into a goal.
    """
    if isinstance(view, bool) or not isinstance(view, int) or not 0 <= view <= _MOST:
        raise ValueError(f"view must be a whole number from 0 to {_MOST}, found {view!r}")
    return view
