"""What can be wrong with a rehearsal."""

from __future__ import annotations

from remodel_production.errors import PlannerError


class RehearsalError(PlannerError):
    """A rehearsal cannot be done as it is asked for."""
