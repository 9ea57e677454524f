"""Why an ability does not do what its goal asks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any


class AbilityError(Exception):
    """An ability refuses its goal, or fails.

    Attributes:
        code: number of an error code (`remodel_states.edge.exported_tables.read_faults`).
        found: fields of the result that were measured all the same.
    """

    def __init__(self, code: int, text: str, found: Mapping[str, Any] | None = None) -> None:
        """State what was asked, what was found, and what to do."""
        super().__init__(text)
        self.code = code
        self.found = dict(found or {})
