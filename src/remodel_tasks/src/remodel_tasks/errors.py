"""What can be wrong with use cases, problems and the kernel."""

from __future__ import annotations

from remodel_production.errors import PlannerError


class KernelError(PlannerError):
    """The compiled search kernel is not there."""


class UseCaseError(PlannerError):
    """A use case is malformed, or not there."""
