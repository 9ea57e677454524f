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


_GONE = ("Errno", "timeout exceeded", "unavailable", "unable to connect", "Connection refused")
_CUT = ("transport error", "unable to receive")


def trouble_words(service: str, reason: str, limit_s: float) -> str:
    """Return why a service could not be called, as an operator reads it.

    Args:
        service: its name.
        reason: what ROS says; empty if there was no answer in time.
        limit_s: in which it had to answer [s].
    """
    who = "the supervisor" if "/use_case/" in service else "its node"
    if not reason:
        return f"{service}: {who} has not answered within {limit_s:.0f} s"
    if any(word in reason for word in _CUT):
        return f"{service}: {who} ended, or lost its connection, before it answered"
    if any(word in reason for word in _GONE):
        return f"{service}: {who} is not running, or does not answer"
    return f"{service} could not be called: {reason}"
