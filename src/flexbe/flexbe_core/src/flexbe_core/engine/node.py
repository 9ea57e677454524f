"""A runtime node: one state or container of the behavior while it runs.

Nodes form a tree like the definitions, made when they are first reached. Each kind has the same
operations; a container passes them on to its active children:

    begin(data) begin a visit
    tick(now)   execute once; return the outcome with which it ends, or None
    exit()      end the visit now
    skip()      pause it: it is not executed for a while
    hold(now)   try again later, after an error
    wake()      be due now, with everything active below
    next_due()  when it is due, as ROS time
    leaf()      the active state below it that a mirror shows
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexbe_core.engine.containers import Container
    from flexbe_core.engine.definitions import Definition
    from flexbe_core.engine.engine import Engine
    from flexbe_core.engine.leaf import Leaf
    from flexbe_core.engine.user_data import UserData

# [s] Due times: at once, and only when woken.
NOW = float("-inf")
NEVER = float("inf")


class Node(ABC):
    """What all nodes have in common.

    Attributes:
        definition: the state or container that it runs.
        targets: outcome -> label or outcome of the parent; empty for the root, which may return
            any outcome.
        shown: whether a mirror shows it: in a concurrency container only the first child.
        due: [s] when it is due.
    """

    __slots__ = (
        "__weakref__",
        "definition",
        "due",
        "engine",
        "label",
        "parent",
        "path",
        "shown",
        "targets",
    )

    def __init__(
        self, engine: Engine, definition: Definition, parent: Container | None, label: str
    ) -> None:
        """Stand for `definition`, which `parent` calls `label`; the root has no parent."""
        self.engine = engine
        self.definition = definition
        self.parent = parent
        self.label = label
        self.due = NOW
        if parent is None:
            self.path = engine.root_path
            self.shown = True
            self.targets: Mapping[str, str] = {}
        else:
            self.path = f"{parent.path}/{label}"
            self.shown = parent.shown
            self.targets = parent.definition._transitions[label]

    @property
    @abstractmethod
    def active(self) -> bool:
        """Return whether a visit has begun and not ended."""

    @abstractmethod
    def begin(self, userdata: UserData | None = None) -> None:
        """Begin a visit with this userdata."""

    @abstractmethod
    def tick(self, now: float) -> str | None:
        """Execute once."""

    @abstractmethod
    def exit(self) -> None:
        """End the visit."""

    @abstractmethod
    def skip(self) -> None:
        """Pause the active states: they are not executed for a while."""

    @abstractmethod
    def hold(self, now: float) -> None:
        """Try again later."""

    @abstractmethod
    def wake(self) -> None:
        """Make everything that is active due now."""

    @abstractmethod
    def next_due(self) -> float:
        """Return when it is due."""

    @abstractmethod
    def leaf(self) -> Leaf | None:
        """Return the active state that a mirror shows."""

    def ancestors(self) -> tuple[str, ...]:
        """Return the paths of the containers around it, from the inside out."""
        return (self.parent.path, *self.parent.ancestors()) if self.parent else ()
