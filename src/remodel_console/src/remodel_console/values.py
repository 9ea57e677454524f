"""The userdata of the run that goes on; written by one thread, read by all."""

from __future__ import annotations

import threading
from collections import deque

from flexbe_core.engine.visit import Known, VisitText
from remodel_console.core.run.state_values import Row, StateValues, values_around

_MOST_FOUND = 1000  # states whose values are kept until they are recorded


class RunValues:
    """The values of the run that goes on, or of the last one.

    Attributes:
        found: what states found, since it was emptied last.
    """

    def __init__(self) -> None:
        """Begin without a run."""
        self.found: deque[StateValues] = deque(maxlen=_MOST_FOUND)
        self._lock = threading.Lock()
        self._known = Known()
        self._run = 0
        self._rows: dict[str, tuple[Row, ...]] = {}

    def take(self, visit: VisitText) -> bool:
        """Take in that a state was entered or left; return whether all values are known."""
        with self._lock:
            is_known = self._known.take(visit)
            if is_known:
                self._take(visit)
            return is_known

    def rows(self, *paths: str) -> tuple[Row, ...]:
        """Return the values of a state's last visit, or those in a container; of the first path."""
        with self._lock:
            found = (self._rows.get(path) or self._inside(path) for path in paths)
            return next(filter(None, found), ())

    def _inside(self, container: str) -> tuple[Row, ...]:
        values = self._known.values.items()
        return tuple(Row(key, text) for (where, key), (_, text) in values if where == container)

    def _take(self, visit: VisitText) -> None:
        if visit.run != self._run:
            self._run, self._rows = visit.run, {}
        values = self._known.values
        texts = {key: values[place][1] for key, place in visit.keys.items() if place in values}
        if visit.has_left:
            rows = {row.key: row for row in self._rows.get(visit.path, ())}
            rows |= {k: Row(k, rows[k].found if k in rows else "", t) for k, t in texts.items()}
            self._rows[visit.path] = tuple(rows.values())
            return
        self._rows[visit.path] = tuple(Row(key, text) for key, text in texts.items())
        around = values_around(visit.path, values)
        self.found.append(StateValues(visit.time_s, visit.path, around))
