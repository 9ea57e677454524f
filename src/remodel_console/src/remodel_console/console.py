"""What the pages share: the session, the live system, and the ways to command both."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from flexbe_synthesizer.core.model import Chart
from remodel_console.core.access import Door
from remodel_console.core.drawing import opened
from remodel_console.core.order import Attach, Order, SetAutonomy, ShowStructure, Start, Switch
from remodel_console.core.record import Record, Summary
from remodel_console.core.run_view import Event, Ordered, Phase
from remodel_console.core.use_case import Choice
from remodel_console.desk import Desk
from remodel_console.edge.catalogue import Catalogue
from remodel_console.edge.settings_file import SettingsFile
from remodel_console.edge.workspace import Workspace
from remodel_console.errors import CommandError
from remodel_console.live import Live
from remodel_console.pictures import Pictures
from remodel_console.session import Session


class Engine(Protocol):
    """The way to the engine."""

    def send(self, order: Order) -> None:
        """Send an order."""

    def userdata(self) -> tuple[tuple[str, str, str, str], ...]:
        """Return (where, key, type, value) of the userdata of what runs."""


class Supervisor(Protocol):
    """The way to the use case supervisor; each command returns its answer, `by` tells who asks.

    All raise CommandError if it is away, does not answer, or refuses.
    """

    def run(self, order: str, tasks: int, by: str, *, again: bool) -> str:
        """Start an order: so many of its tasks, 0 for all; `again`: those that are done too."""

    def pause(self, by: str) -> str:
        """Have the run pause."""

    def resume(self, by: str) -> str:
        """Have the run go on."""

    def stop(self, by: str) -> str:
        """Have the run stopped safely."""

    def skip(self, task: str, by: str) -> str:
        """Have a task left undone."""

    def retry(self, task: str, by: str) -> str:
        """Have a task done again."""

    def answer(self, question: int, choice: Choice, by: str) -> str:
        """Answer a question by its number."""


class Recorder(Protocol):
    """The way to recorded runs; all raise CommandError if nobody can tell them."""

    def runs(self) -> tuple[Summary, ...]:
        """Return the runs, the latest first."""

    def orders(self) -> tuple[str, ...]:
        """Return the names of all orders."""

    def record(self, run: int) -> Record:
        """Return the record of a run, without its pictures."""

    def picture(self, run: int, position: int) -> bytes:
        """Return the picture of an entry, as jpeg or png."""


class Console:
    """Everything that a page needs.

    Attributes:
        pictures: what the cell's cameras see.
        engine: None until ROS is there.
        supervisor: None until ROS is there.
        recorder: None until ROS is there.
    """

    def __init__(
        self,
        door: Door,
        desk: Desk,
        live: Live,
        session: Session,
        workspace: Workspace,
        catalogue: Catalogue,
        settings: SettingsFile,
    ) -> None:
        """Join the parts."""
        self.door = door
        self.desk = desk
        self.live = live
        self.session = session
        self.workspace = workspace
        self.catalogue = catalogue
        self.settings = settings
        self.pictures = Pictures()
        self.engine: Engine | None = None
        self.supervisor: Supervisor | None = None
        self.recorder: Recorder | None = None
        self._names: dict[int, str] = {}  # of behaviors, by the checksums of their sources
        self._unknown = 0  # checksum of what runs, once nothing installed was found to have it
        self._structure_asked = 0

    def take(self, event: Event) -> None:
        """Take in what the engine tells, and ask for the structure of what is watched over."""
        self.live.take(event)
        run = self.live.world.run
        if run.is_supervised and not run.has_structure and self._structure_asked != run.behavior_id:
            self._structure_asked = run.behavior_id
            self.order(ShowStructure())

    def order(self, order: Order) -> None:
        """Send an order to the engine.

        Raises:
            CommandError: if it cannot be sent.
        """
        if self.engine is None:
            raise CommandError("ROS is away; start it: roscore")
        if isinstance(order, Start | Switch):
            self.live.take(Ordered(order.level, order.source_checksum))
        elif isinstance(order, Attach | SetAutonomy):
            self.live.take(Ordered(order.level))
        self.engine.send(order)

    def command(self, deed: Callable[[Supervisor], str]) -> str:
        """Command the use case supervisor, and return its answer.

        Raises:
            CommandError: if ROS is away, or the supervisor refuses.
        """
        if self.supervisor is None:
            raise CommandError("ROS is away; start it: roscore")
        return deed(self.supervisor)

    def attach(self, level: int) -> None:
        """Watch over what runs.

        Raises:
            CommandError: if another behavior is loaded, or nothing runs.
        """
        run = self.live.world.run
        if run.phase is not Phase.RUNNING:
            raise CommandError("no behavior runs")
        name, chart = self.running_name(), self.session.chart
        loaded = f"'{chart.name}'" if chart else "nothing"
        if name and (chart is None or chart.name != name):
            raise CommandError(f"'{name}' runs, and {loaded} is loaded; load '{name}' first")
        self.order(Attach(level))

    def newer_version(self) -> Switch | None:
        """Return the way to the saved version of what this console watches over, if it differs."""
        run = self.live.world.run
        if not run.is_supervised or run.level is None:
            return None
        name = self.running_name()
        found = next((one for one in self.catalogue.behaviors() if one.name == name), None)
        if found is None or found.source_checksum == run.behavior_id:
            return None
        return Switch(name, found.behavior_id, found.source_checksum, run.level)

    def running_name(self) -> str:
        """Return the display name of what runs; empty if its version is not installed here."""
        run = self.live.world.run
        if run.attached_name:
            return run.attached_name
        if run.behavior_id not in (self._unknown, *self._names):
            self._names |= {one.source_checksum: one.name for one in self.catalogue.behaviors()}
            self._unknown = 0 if run.behavior_id in self._names else run.behavior_id
        return self._names.get(run.behavior_id, "")

    def chart_to_watch(self, name: str) -> Chart:
        """Return the saved chart of a behavior, with the behaviors in it drawn open.

        Raises:
            CommandError: if there is no such behavior.
        """
        return opened(self.workspace.find(name), self.workspace.charts())
