"""The world that cells share, who moves in it, and the ledger of what cannot be undone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from remodel_states.serving import admitted
from remodel_states.testing.faults import Faults, when_fed, when_mended
from remodel_states.testing.world import Deed, Entry, Panel, World
from schedules.simulation import Simulation


@dataclass(frozen=True)
class Motion:
    """Something that moves, or observes.

    Attributes:
        station: whose server does it.
        cell: in which it happens.
        owner: token that was shown.
        what: for a person.
        wire: that it is about; empty if none.
        begun_s: [s] when it began.
    """

    station: str
    cell: str
    owner: int
    what: str
    wire: str
    begun_s: float = 0.0


@dataclass
class Site:
    """A panel with the cells around it; it outlives all processes.

    Attributes:
        on_motion: called when something begins to move.
        on_result: called when an ability has ended, with its error code.
        on_entry: called after each deed.
        locks: cell -> what holds its robot.
        moving: what moves now.
    """

    simulation: Simulation
    panel: Panel
    on_motion: Callable[[Motion], None] = lambda _: None
    on_result: Callable[[Motion, int], None] = lambda *_: None
    on_entry: Callable[[Entry], None] = lambda _: None
    world: World = field(default_factory=World)
    faults: Faults = ()
    owners: dict[str, int] = field(default_factory=dict)
    locks: dict[str, object] = field(default_factory=dict)
    moving: list[Motion] = field(default_factory=list)
    ledger: list[Entry] = field(default_factory=list)

    def admit(self, cell: str, owner: int) -> None:
        """Check a token, and remember it; AbilityError if it is stale."""
        self.owners = admitted(self.owners, cell, owner)

    def begin(self, motion: Motion) -> None:
        self.moving.append(motion)
        self.on_motion(motion)

    def end(self, motion: Motion) -> None:
        self.moving = [each for each in self.moving if each is not motion]

    def load(self, cell: str, serial: str, *, keep: bool) -> None:
        panel = replace(self.panel, serial=serial)
        before, self.world = self.world, self.world.load(cell, panel, keep=keep)
        if self.world is before:
            return
        self.faults = ()
        self.write(Entry(Deed.LOAD, cell, serial))

    def feed(self, cell: str, wire: str) -> None:
        is_new = wire not in self.world.fed
        self.world = self.world.feed(cell, wire, channel="")
        if is_new:
            self.faults = when_fed(self.faults, wire)
            self.write(Entry(Deed.FEED, cell, wire))

    def write(self, entry: Entry) -> None:
        entry = replace(entry, at_s=self.simulation.now_s)
        self.simulation.note(
            "ledger", "{}", f"{entry.deed.value} {entry.wire} {entry.end} {entry.goal}"
        )
        self.ledger.append(entry)
        self.on_entry(entry)

    def mend(self) -> None:
        """Have a person mend what has shown."""
        self.faults = when_mended(self.faults)
