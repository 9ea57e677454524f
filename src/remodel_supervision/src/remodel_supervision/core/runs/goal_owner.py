"""The token of the cell's owner, which the id of each goal carries: "17:Place Wire W1/Insert#1"."""

from __future__ import annotations


def owner_of(goal_id: str) -> int:
    """Return the token of the owner who granted a goal; 0 if its id carries none."""
    token, colon, _ = goal_id.partition(":")
    return int(token) if colon and token.isdecimal() else 0
