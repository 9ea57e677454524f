"""What can go wrong while an order runs."""

from __future__ import annotations

from remodel_production.errors import PlannerError


class CellError(PlannerError):
    """The cell, the engine or the synthesizer does not answer, or refuses."""


class RefusedError(CellError):
    """The cell refused a request.

    Attributes:
        code: remodel_msgs/ErrorCode.
    """

    def __init__(self, code: int, text: str) -> None:
        """Keep the code and the reason."""
        super().__init__(text)
        self.code = code


class HaltedError(PlannerError):
    """The gate is closed: what was about to begin does not begin."""


class LeavingError(PlannerError):
    """This process is shutting down; the run goes on when it is started again."""


class HookError(PlannerError):
    """An escalation hook is malformed, or could not deliver."""
