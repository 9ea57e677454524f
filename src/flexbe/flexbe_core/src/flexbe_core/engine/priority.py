"""A priority container in a run: while it is active, concurrent siblings wait."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexbe_core.engine.machine import Machine

if TYPE_CHECKING:
    from flexbe_core.engine.container import Container
    from flexbe_core.engine.definitions.definition import Definition
    from flexbe_core.engine.engine import Engine
    from flexbe_core.engine.userdata.user_data import UserData


class Priority(Machine):
    """The runtime node of a priority container: a state machine that claims priority."""

    __slots__ = ("_before", "_claimed")

    def __init__(
        self, engine: Engine, definition: Definition, parent: Container | None, label: str
    ) -> None:
        """Stand for the priority container `definition`."""
        super().__init__(engine, definition, parent, label)
        self._claimed = False
        self._before: str | None = None

    def begin(self, userdata: UserData | None = None) -> None:
        """Begin, and claim priority unless a container inside holds it already."""
        super().begin(userdata)
        priority = self.engine.priority
        if priority is None or not is_inside(priority, self.path):
            self._claimed, self._before = True, priority
            self.engine.priority = self.path

    def tick(self, now: float) -> str | None:
        """Execute the active child, and give priority back with the outcome."""
        outcome = super().tick(now)
        if outcome is not None:
            self._give_back()
        return outcome

    def exit(self) -> None:
        """End the visit, and give priority back."""
        super().exit()
        self._give_back()

    def _give_back(self) -> None:
        if self._claimed:
            self._claimed = False
            self.engine.priority = self._before


def is_inside(path: str, container: str) -> bool:
    """Return whether `path` is `container` or below it."""
    return path == container or path.startswith(container + "/")
