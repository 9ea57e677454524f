"""The message about a visit of a state: what is new or has changed in the userdata, as JSON.

It is no message of its own, since flexbe_msgs has those of stock FlexBE and no others.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

# Path of a container, empty for the behavior itself, and name of one of its values.
Place = tuple[str, str]


@dataclass(frozen=True)
class VisitText:
    """A visit, printed.

    Attributes:
        number: counts them; after a gap, a receiver does not know all values.
        run: counts the runs of this engine.
        time_s: ROS time.
        path: of the state.
        has_left: whether it was left; else it was entered.
        complete: containers of which all values are here, as after their beginning.
        changed: class and text of the values that are new or have changed.
        keys: what the state has found, or left behind: own name -> place of the value.
    """

    number: int
    run: int
    time_s: float
    path: str
    has_left: bool
    complete: tuple[str, ...]
    changed: Mapping[Place, tuple[str, str]]
    keys: Mapping[str, Place]

    def as_json(self) -> str:
        """Return what `from_json` reads."""
        return json.dumps(
            {
                "number": self.number,
                "run": self.run,
                "time": round(self.time_s, 6),
                "path": self.path,
                "left": self.has_left,
                "complete": self.complete,
                "changed": [(*place, *value) for place, value in self.changed.items()],
                "keys": [(key, *place) for key, place in self.keys.items()],
            },
            separators=(",", ":"),
        )

    @classmethod
    def from_json(cls, text: str) -> VisitText:
        """Return a printed visit.

        Raises:
            ValueError, TypeError, KeyError: if the text is none.
        """
        found: dict[str, Any] = json.loads(text)
        return cls(
            int(found["number"]),
            int(found["run"]),
            float(found["time"]),
            str(found["path"]),
            bool(found["left"]),
            tuple(map(str, found["complete"])),
            {(where, key): (kind, value) for where, key, kind, value in found["changed"]},
            {key: (where, outer) for key, where, outer in found["keys"]},
        )


@dataclass
class Known:
    """All values of a run, from the messages that were received.

    Attributes:
        values: class and text by their places.
        is_lost: whether messages are missing, so that the values are not known.
    """

    values: dict[Place, tuple[str, str]] = field(default_factory=dict)
    is_lost: bool = True
    _number: int = 0

    def take(self, visit: VisitText) -> bool:
        """Take in a visit; return whether the values are known."""
        if "" in visit.complete:
            self.values.clear()
            self.is_lost = False
        elif visit.number != self._number + 1:
            self.is_lost = True
        self._number = visit.number
        if not self.is_lost:
            for place in [place for place in self.values if place[0] in visit.complete]:
                del self.values[place]
            self.values.update(visit.changed)
        return not self.is_lost
