"""Apply an operator's changes to a source text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flexbe_onboard.errors import StartError


@dataclass(frozen=True)
class Modification:
    """A replacement of characters [begin, end) of the unmodified text."""

    begin: int
    end: int
    content: str


def modified(text: str, modifications: Sequence[Modification]) -> str:
    """Return the text with all modifications.

    Raises:
        StartError: if they are not in ascending order, overlap or reach beyond the text.
    """
    parts, position = [], 0
    for index, change in enumerate(modifications):
        if not position <= change.begin <= change.end <= len(text):
            raise StartError(
                f"modification {index} replaces characters {change.begin} to {change.end}; it must "
                f"begin at {position} or later, behind the one before, and end by {len(text)}"
            )
        parts += [text[position : change.begin], change.content]
        position = change.end
    return "".join([*parts, text[position:]])
