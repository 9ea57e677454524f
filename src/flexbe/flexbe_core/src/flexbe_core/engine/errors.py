"""What can go wrong in a run.

The first three are stock FlexBE's: users catch them by name, and they share no base but Exception.
"""

from __future__ import annotations


class StateError(Exception):
    """A state is used in a way that its definition does not allow."""


class StateMachineError(Exception):
    """A container is built or used incorrectly."""


class UserDataError(Exception):
    """Userdata is read or written against its declaration."""


class BehaviorFailure(Exception):  # noqa: N818 - a failure of the behavior, not an error in it
    """A state could not continue, and no operator is present to help: the run ends.

    Attributes:
        path: path of the state or container that could not continue.
        cause: what it raised.
    """

    def __init__(self, path: str, cause: Exception) -> None:
        """Say which state failed and why."""
        super().__init__(f"{path or 'the root container'}: {type(cause).__name__}: {cause}")
        self.path = path
        self.cause = cause
