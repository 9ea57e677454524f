"""The behavior that runs: which it is, and orders to the engine about it."""

from __future__ import annotations

import contextlib
from dataclasses import replace
from typing import Protocol

from remodel_console.core.run.order import (
    Attach,
    Order,
    SetAutonomy,
    ShowStructure,
    Start,
    Switch,
    TakeOutcome,
)
from remodel_console.core.run.run_view import EngineSeen, Event, Ordered, Phase
from remodel_console.edge.catalogue import Catalogue
from remodel_console.errors import CommandError
from remodel_console.live import Live
from remodel_console.session import Session


class Engine(Protocol):
    """Commands to the engine."""

    def send(self, order: Order) -> None:
        """Send an order."""

    def userdata(self) -> tuple[tuple[str, str, str, str], ...]:
        """Return (where, key, type, value) of the userdata of what runs."""

    def set_breakpoints(self, paths: frozenset[str]) -> None:
        """Set the states before whose end the engine asks."""


class Steering:
    """Steers what runs, for pages and commands alike.

    Attributes:
        engine: None until ROS is there.
    """

    def __init__(self, live: Live, session: Session, catalogue: Catalogue) -> None:
        """Join what runs, what is loaded, and what is installed."""
        self.live = live
        self.session = session
        self.catalogue = catalogue
        self.engine: Engine | None = None
        self._names: dict[int, str] = {}  # of behaviors, by the checksums of their sources
        self._unknown = 0  # checksum of what runs, once nothing installed was found to have it
        self._structure_asked = self._joined = 0  # checksums of what that was requested for
        self._is_heard = False

    def take(self, event: Event) -> None:
        """Take in an event of the engine, and request what is not known of a supervised behavior.

        A run that was supervised before this console knew it is attached to at its own level, so
        that the engine repeats what it asks.
        """
        self.live.take(event)
        if isinstance(event, EngineSeen):
            self._is_heard = event.is_there
        run = self.live.world.run
        if not run.is_supervised or run.level is None:
            self._structure_asked = self._joined = 0
            return
        if not self._is_heard:  # what is latched arrives before the engine can be commanded
            return
        with contextlib.suppress(CommandError):  # it has ended meanwhile
            if run.ordered.level is None and self._joined != run.behavior_id:
                self.order(Attach(run.level))
            self._joined = run.behavior_id
            if not run.has_structure and self._structure_asked != run.behavior_id:
                self.order(ShowStructure())
                self._structure_asked = run.behavior_id

    def order(self, order: Order) -> None:
        """Send an order to the engine.

        Raises:
            CommandError: if it cannot be sent.
        """
        if self.engine is None:
            raise CommandError("ROS is not running; start it: roscore")
        if isinstance(order, Start | Switch):
            self.live.take(Ordered(order.level, order.source_checksum))
        elif isinstance(order, Attach | SetAutonomy):
            self.live.take(Ordered(order.level))
        elif isinstance(order, TakeOutcome):
            label = order.path.rpartition("/")[2]
            asking = [a for a in self.live.world.run.asks if a.path.rpartition("/")[2] == label]
            order = replace(order, is_by_path=len(asking) > 1)
        try:
            self.engine.send(order)
        except CommandError:
            if isinstance(order, Start):
                self.live.take(Ordered(None))  # nothing starts
            raise

    def change_breakpoints(
        self, *, added: frozenset[str] = frozenset(), removed: frozenset[str] = frozenset()
    ) -> None:
        """Have the engine ask before it leaves states, or no longer.

        Raises:
            CommandError: if ROS is not running.
        """
        if self.engine is None:
            raise CommandError("ROS is not running; start it: roscore")
        paths = (self.live.world.breakpoints - removed) | added
        self.engine.set_breakpoints(paths)
        self.live.set_breakpoints(paths)

    def attach(self, level: int) -> None:
        """Supervise the running behavior.

        Raises:
            CommandError: if another behavior is loaded, or nothing runs.
        """
        run = self.live.world.run
        if run.phase is not Phase.RUNNING:
            raise CommandError("no behavior runs")
        name, chart = self.running_name(), self.session.chart
        loaded = f"'{chart.name}'" if chart else "nothing"
        if name and (chart is None or chart.name != name):
            raise CommandError(f"'{name}' is running, and {loaded} is loaded; load '{name}' first")
        self.order(Attach(level))

    def newer_version(self) -> Switch | None:
        """Return the switch to the saved version of the supervised behavior, if it differs."""
        run = self.live.world.run
        if not run.is_supervised or run.level is None:
            return None
        name = self.running_name()
        found = next((one for one in self.catalogue.behaviors() if one.name == name), None)
        if found is None or found.source_checksum == run.behavior_id:
            return None
        return Switch(name, found.behavior_id, found.source_checksum, run.level)

    def version_to_switch_to(self) -> Switch:
        """Return the switch to the saved version of the supervised behavior.

        Raises:
            CommandError: if no version differs, or this console supervises no behavior.
        """
        if not self.live.world.run.is_supervised:
            raise CommandError("this console supervises no running behavior; attach to one first")
        version = self.newer_version()
        if version is None:
            raise CommandError("the saved version is running already; 'save' saves another one")
        return version

    def running_name(self) -> str:
        """Return the display name of what runs; empty if its version is not installed here."""
        run = self.live.world.run
        if run.attached_name:
            return run.attached_name
        if run.behavior_id not in (self._unknown, *self._names):
            self._names |= {one.source_checksum: one.name for one in self.catalogue.behaviors()}
            self._unknown = 0 if run.behavior_id in self._names else run.behavior_id
        return self._names.get(run.behavior_id, "")
