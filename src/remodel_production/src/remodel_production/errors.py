"""What can be wrong with designs, orders, and the database."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator


class PlannerError(Exception):
    """Base of the errors that a user can mend; the text says where, what was found, what to do."""


class DesignError(PlannerError):
    """A design file cannot be read as an electrical project."""


class CatalogueError(PlannerError):
    """The catalogue of wires and mounting rules is malformed."""


class OrderError(PlannerError):
    """The database has no such order, or has it already."""


class LostError(PlannerError):
    """A process that a run needs is gone or silent; what it did last is unknown."""


class OwnerError(PlannerError):
    """Another supervisor owns the run or the cell now: this one must not act or record any more."""


class RecordLostError(PlannerError):
    """The production database has lost what a run needs: a row, a table, or the whole file."""


class BackupError(PlannerError):
    """The production database cannot be backed up, or restored."""


class InstanceError(PlannerError):
    """A planning problem or a plan is malformed, or the problem has no plan."""


class InfeasibleError(InstanceError):
    """A problem has no plan: what it requires contradicts itself, or the design."""


@contextlib.contextmanager
def blamed(where: object) -> Iterator[None]:
    """Put the name of a file or document before what is said to be wrong inside."""
    try:
        yield
    except PlannerError as error:
        raise type(error)(f"{where}: {error}") from error
