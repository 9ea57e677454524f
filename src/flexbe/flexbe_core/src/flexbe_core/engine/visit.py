"""What the states of a run find in the userdata and leave behind, for operators to see.

    visit_of     thread of the run: keeps references, so that a transition is hardly delayed
    Printer      another thread: prints what has changed since the visit before

A value that is changed in place before it is printed is printed as it is then.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from flexbe_core.engine.user_data import Fingerprint, Value, fingerprint, is_unchanged

if TYPE_CHECKING:
    from flexbe_core.engine.leaf import Leaf, Node
    from flexbe_core.engine.user_data import UserData


@dataclass(frozen=True, slots=True)
class Visit:
    """A state was entered, or left.

    Attributes:
        time_s: ROS time.
        path: of the state.
        has_left: whether it was left.
        keys: what the state reads if it was entered, else what it writes; with the names that each
            container around it has for that, from the innermost one.
        around: path, userdata and values of the containers around it, from the innermost one.
    """

    time_s: float
    path: str
    has_left: bool
    keys: tuple[tuple[str, tuple[str, ...]], ...]
    around: tuple[tuple[str, UserData, dict[str, Value]], ...]


def visit_of(leaf: Leaf, time_s: float, has_left: bool) -> Visit:
    """Return a visit of a state, with references to the values that are there now."""
    state = leaf.definition
    names = [(key, [key]) for key in (state._output_keys if has_left else state._input_keys)]
    around = []
    node: Node = leaf
    while (container := node.parent) is not None:
        remapping = container.definition._remappings.get(node.label, {})
        for _, known_as in names:
            known_as.append(remapping.get(known_as[-1], known_as[-1]))
        around.append((container.path, container.userdata, dict(container.userdata._data)))
        node = container
    keys = tuple((key, tuple(known_as[1:])) for key, known_as in names)
    return Visit(time_s, leaf.path, has_left, keys, tuple(around))


@dataclass(slots=True)
class _Printed:
    """A value as it was printed last."""

    value: Value
    parts: Fingerprint | None
    kind: str
    text: str


@dataclass
class Printer:
    """Prints visits, and of the values what has changed.

    Attributes:
        text: returns the text of a value.
        is_complete: whether the next one has all values, for a new receiver.
    """

    text: Callable[[Value], str] = str
    is_complete: bool = True
    _number: int = 0
    _run: int = 0
    _printed: dict[str, tuple[UserData, dict[str, _Printed]]] = field(default_factory=dict)

    def text_of(self, visit: Visit) -> VisitText:
        """Return a visit as text."""
        is_complete, self.is_complete = self.is_complete, False
        changed: dict[Place, tuple[str, str]] = {}
        complete = []
        for path, userdata, values in visit.around:
            begun, printed = self._printed.get(path, (None, {}))
            if not path and begun is not userdata:
                self._run += 1
            if is_complete or begun is not userdata or not printed.keys() <= values.keys():
                complete.append(path)
                printed = {}
            for key, value in values.items():
                before = printed.get(key)
                now = self._print(value, before)
                if now is not before:
                    printed[key] = now
                    changed[path, key] = now.kind, now.text
            self._printed[path] = (userdata, printed)
        if "" in complete:  # another run: what is not around this state has not begun
            around = {path for path, _, _ in visit.around}
            self._printed = {p: known for p, known in self._printed.items() if p in around}
        self._number += 1
        return VisitText(
            self._number,
            self._run,
            visit.time_s,
            visit.path,
            visit.has_left,
            tuple(complete),
            changed,
            _places(visit),
        )

    def _print(self, value: Value, before: _Printed | None) -> _Printed:
        """Return a value as text; what was printed before, if it has not changed."""
        parts = fingerprint(value)
        if before is not None and before.value is value:
            old = before.parts
            if parts is None or (old is not None and is_unchanged(old, parts)):
                return before
        return _Printed(value, parts, type(value).__name__, self.text(value))


def _places(visit: Visit) -> dict[str, Place]:
    """Return where the values are that a state reads or writes; without those not written yet."""
    found = {}
    for key, names in visit.keys:
        for name, (path, _, values) in zip(names, visit.around, strict=True):
            if name in values:
                found[key] = (path, name)
                break
    return found


# The message about a visit of a state: what is new or has changed in the userdata, as JSON.
#
# It is no message of its own, since flexbe_msgs has those of stock FlexBE and no others.


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
