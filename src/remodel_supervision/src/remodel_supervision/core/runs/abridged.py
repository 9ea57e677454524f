"""Long reasons, short enough for a line of state or a terminal."""

from __future__ import annotations

_ITEM = "  - "

# How many problems are shown; those of one cause often come in rows.
SHOWN = 3


def abridged(text: str, shown: int = SHOWN) -> str:
    """Return a text whose list of problems (lines that begin with `  - `) is cut after some."""
    lines = text.splitlines()
    items = [index for index, line in enumerate(lines) if line.startswith(_ITEM)]
    cut = items[shown:]
    if len(cut) < 2:
        return text
    kept = [line for index, line in enumerate(lines) if index not in cut[1:]]
    kept[cut[0]] = f"{_ITEM}and {len(cut)} more"
    return "\n".join(kept)
