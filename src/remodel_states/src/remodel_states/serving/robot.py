"""What the ability servers of one robot share."""

from __future__ import annotations

import threading

from remodel_msgs.msg import ErrorCode

from remodel_states.core.ability_error import AbilityError
from remodel_states.serving.ownership import admitted


class Robot:
    """A robot does one goal at a time, over all its abilities, for the newest supervisor."""

    def __init__(self, name: str = "the robot") -> None:
        """Name it, for messages."""
        self._name = name
        self._lock = threading.Lock()
        self._is_busy = False
        self._owners: dict[str, int] = {}

    def begin(self, owner: int) -> None:
        """Begin a goal.

        Args:
            owner: token of the supervisor that sent it (`owner_of`); 0 is not checked.

        Raises:
            AbilityError: BUSY while it does another goal, STALE_OWNER after a newer supervisor.
        """
        with self._lock:
            if self._is_busy:
                text = f"{self._name} is doing another goal; wait for it or cancel it"
                raise AbilityError(ErrorCode.BUSY, text)
            self._owners = admitted(self._owners, self._name, owner)
            self._is_busy = True

    def end(self) -> None:
        """End the goal."""
        with self._lock:
            self._is_busy = False
