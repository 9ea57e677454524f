"""What proxies do while they wait for a node that is not there yet."""

from __future__ import annotations

from collections.abc import Callable

import rospy


class Waits:
    """What the process has made of the waits of its proxies; an engine reports them to operators.

    Attributes:
        report: gets in words what is waited for.
        is_stopped: returns whether nothing is to be waited for any more.
    """

    def __init__(self) -> None:
        """Begin with waits that are logged, and end by themselves."""
        self.report: Callable[[str], None] = _log
        self.is_stopped: Callable[[], bool] = lambda: False


def _log(text: str) -> None:
    rospy.logwarn("%s", text)


# Connections belong to the process, and so do the waits for them.
WAITS = Waits()
