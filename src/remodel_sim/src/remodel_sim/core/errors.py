"""Errors of the simulated cell."""

from remodel_work.errors import CellError


class FaultError(CellError):
    """A fault that cannot be caused as it is asked for."""


class FilmError(CellError):
    """A run cannot be filmed."""
