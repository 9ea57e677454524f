"""What can go wrong with a command."""

from __future__ import annotations

from typing import TypeVar

T = TypeVar("T")


class CommandError(Exception):
    """A command cannot be carried out; the message is the answer to its sender."""


def expect_ros(part: T | None) -> T:
    """Return a part that there is once ROS is running.

    Raises:
        CommandError: if it is None.
    """
    if part is None:
        raise CommandError("ROS is not running; start it: roscore")
    return part


class ChartErrorsError(CommandError):
    """A chart is not saved, since it has errors.

    Attributes:
        count: how many.
    """

    def __init__(self, text: str, count: int) -> None:
        super().__init__(text)
        self.count = count


class FileChangedError(CommandError):
    """A chart is not saved, since its file was changed meanwhile.

    Attributes:
        now: the text of the file.
    """

    def __init__(self, text: str, now: str) -> None:
        super().__init__(text)
        self.now = now


class PictureError(ValueError):
    """A picture of a camera cannot be shown."""
