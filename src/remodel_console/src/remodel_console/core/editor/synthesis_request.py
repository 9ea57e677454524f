"""What a synthesis server is asked."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ServerRequest:
    """A request to a synthesis server.

    Attributes:
        topic: name of its action.
        system: name of the robot system; may be empty.
        path: of the container to fill, such as `/Place/Insert`.
        initial: where it starts; empty for where the chart itself does.
        goal: path of the chart.
    """

    topic: str
    system: str
    path: str
    initial: str
    goal: str
