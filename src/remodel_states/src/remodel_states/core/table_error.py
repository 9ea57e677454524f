"""What is wrong with a table of abilities or faults."""

from __future__ import annotations

from collections.abc import Sequence


class TableError(Exception):
    """A table of abilities or faults cannot be read or contradicts another one.

    Attributes:
        problems: every problem: its place in the file, what was found, and what is allowed.
    """

    def __init__(self, file: str, problems: Sequence[str]) -> None:
        """List every problem at once."""
        lines = "\n".join(f"  - {problem}" for problem in problems)
        count = f"{len(problems)} problem{'s' if len(problems) != 1 else ''}"
        super().__init__(f"{file}: {count}:\n{lines}")
        self.problems = tuple(problems)
