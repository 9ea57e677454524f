"""The form of answers: the command, whether it was carried out, and the words.

done: load my_first_behavior
loaded 'my_first_behavior' from /charts/my_first_behavior.xml
"""

from __future__ import annotations

from dataclasses import dataclass

DONE, FAILED, REFUSED = "done", "failed", "refused"


@dataclass(frozen=True)
class CommandResult:
    """The result of a command: `state` is DONE, FAILED or REFUSED."""

    state: str
    command: str
    words: str

    def __str__(self) -> str:
        """Return the text that is sent."""
        return f"{self.state}: {self.command}\n{self.words}"


def read_answer(text: str) -> CommandResult:
    """Return the answer that a text is.

    Raises:
        ValueError: if it is none.
    """
    head, _, words = text.partition("\n")
    state, mark, command = head.partition(": ")
    if not mark or state not in (DONE, FAILED, REFUSED):
        raise ValueError(f"no answer to a command: {text!r}")
    return CommandResult(state, command, words)
