"""The physical world of a fake cell, as a value.

A wire's end is loose, seated (pushed into a terminal, its clamp open) or fixed (clamp closed). Each
cell has robots with a hand each, and one feeder; several cells may work on one panel.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, TypeAlias

from remodel_msgs.msg import ErrorCode

from remodel_states.core.ability_error import AbilityError

# x, y, z [m] and yaw [rad]; panel frame.
Place = tuple[float, float, float, float]

# A goal message, or anything with its fields: generated messages have no types.
Goal: TypeAlias = Any


@dataclass(frozen=True)
class Panel:
    """What is mounted, and which wires belong on it.

    Attributes:
        name: of the panel.
        wires: wire -> terminals of its ends a and b, as "component/terminal".
        lengths: wire -> [m].
        components: component -> place of its base.
        openings: "component/terminal" -> place of its opening, yaw into the terminal.
        channels: in which wires are fed; none: they are presented in a magazine.
        ducts: wire -> ducts that its route passes; wires without are not listed.
        serial: serial number of the product that is built on it.
    """

    name: str = ""
    wires: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    lengths: Mapping[str, float] = field(default_factory=dict)
    components: Mapping[str, Place] = field(default_factory=dict)
    openings: Mapping[str, Place] = field(default_factory=dict)
    channels: tuple[str, ...] = ()
    ducts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    serial: str = ""


@dataclass(frozen=True)
class Seat:
    """Where an end sits that is not loose: terminal as "component/terminal"."""

    terminal: str
    fixed: bool


@dataclass(frozen=True)
class Hands:
    """One cell's feeder, and the hands of its robots.

    Attributes:
        live: wire that the feeder presented last; empty: none.
        held: robot -> end of the live wire in its fingers, "a" or "b"; empty hands are not listed.
    """

    live: str = ""
    held: Mapping[str, str] = field(default_factory=dict)

    def of(self, robot: str) -> str:
        """Return the end in a robot's fingers; empty: none."""
        return self.held.get(robot, "")

    def others(self, robot: str) -> Iterator[tuple[str, str]]:
        """Yield each other robot that holds an end, with the end."""
        return ((name, end) for name, end in self.held.items() if name != robot)


@dataclass(frozen=True)
class World:
    """Everything that lasts.

    Attributes:
        panel: see Panel.
        fed: wires of which there is a piece, in the order of their feeding.
        untouched: wire that lies as it was presented -> cell whose feeder has it.
        seats: "wire/end" -> where it sits; loose ends are not listed.
        hands: cell -> its hands.
        loaded_by: cell that has loaded the panel.
    """

    panel: Panel = Panel()
    fed: tuple[str, ...] = ()
    untouched: Mapping[str, str] = field(default_factory=dict)
    seats: Mapping[str, Seat] = field(default_factory=dict)
    hands: Mapping[str, Hands] = field(default_factory=dict)
    loaded_by: str = ""

    def load(self, cell: str, panel: Panel, *, keep: bool) -> World:
        """Return the world with an empty panel, or this one if it has the panel already.

        A request of a cell that was stalled may arrive when another cell has loaded the panel and
        placed wires on it: they stay, whatever the request says.

        Args:
            cell: that asks.
            panel: to load, with the serial number of the product.
            keep: whether wires stay on the panel if this cell has loaded it.
        """
        if panel == self.panel and (keep or cell != self.loaded_by):
            return self
        return World(panel, loaded_by=cell)

    def hands_in(self, cell: str) -> Hands:
        """Return a cell's hands."""
        return self.hands.get(cell, Hands())

    def seat(self, wire: str, end: str) -> Seat | None:
        """Return where an end sits; None if it is loose."""
        return self.seats.get(f"{wire}/{end}")

    def occupant(self, terminal: str) -> str | None:
        """Return the "wire/end" that a terminal holds."""
        return next((end for end, seat in self.seats.items() if seat.terminal == terminal), None)

    def is_connected(self, wire: str) -> bool:
        """Return whether an end sits in a terminal."""
        return any(self.seat(wire, end) is not None for end in "ab")

    def is_placed(self, wire: str) -> bool:
        """Return whether both ends are fixed where they belong."""
        ends = zip(("a", "b"), self.panel.wires[wire], strict=True)
        return all(self.seat(wire, end) == Seat(terminal, True) for end, terminal in ends)

    def with_live(self, cell: str, wire: str) -> World:
        """Return the world with a wire presented by a cell's feeder."""
        return self._with_hands(cell, replace(self.hands_in(cell), live=wire))

    def with_held(self, cell: str, robot: str, end: str) -> World:
        """Return the world with an end of the live wire in a robot's fingers; empty: with none."""
        hands = self.hands_in(cell)
        others = dict(hands.others(robot))
        held = {**others, robot: end} if end else others
        return self._with_hands(cell, replace(hands, held=held))

    def _with_hands(self, cell: str, hands: Hands) -> World:
        return replace(self, hands={**self.hands, cell: hands})

    def with_seat(self, wire: str, end: str, seat: Seat | None) -> World:
        """Return the world with an end seated, fixed, or loose."""
        others = {key: value for key, value in self.seats.items() if key != f"{wire}/{end}"}
        return replace(self, seats={**others, f"{wire}/{end}": seat} if seat else others)

    def feed(self, cell: str, wire: str, channel: str) -> World:
        """Return the world with a piece of a wire in a cell's channel, both ends loose.

        A piece that lies there as it was presented is presented again. Nothing else vanishes.

        Raises:
            AbilityError: if there is no such wire or channel, a hand holds a wire, or a piece of
                this wire is elsewhere in the cell.
        """
        known(self.panel.wires, wire, "wire")
        # A panel without channels has its wires presented in a magazine.
        if channel or self.panel.channels:
            known(self.panel.channels, channel, "channel")
        hands = self.hands_in(cell)
        for robot, end in hands.held.items():
            raise AbilityError(
                ErrorCode.OTHER_CABLE_HELD,
                f"{robot} holds end {end} of {hands.live!r}; place it first",
            )
        live = self.with_live(cell, wire)
        if self.untouched.get(wire) == cell:
            return live
        if wire in self.fed:
            raise AbilityError(
                ErrorCode.WIRE_LEFT_BEHIND,
                f"a piece of wire {wire!r} is in the cell already; discard it first",
            )
        return replace(live, fed=(*self.fed, wire), untouched={**self.untouched, wire: cell})

    def touched(self, wire: str) -> World:
        """Return the world after something was done to a wire, successfully or not."""
        if wire not in self.untouched:
            return self
        others = {name: cell for name, cell in self.untouched.items() if name != wire}
        return replace(self, untouched=others)

    def discard(self, wire: str) -> World:
        """Return the world without the piece of a wire: its ends are out, and no hand has it."""
        loose = self.touched(wire).with_seat(wire, "a", None).with_seat(wire, "b", None)
        hands = {
            name: Hands() if hands.live == wire else hands for name, hands in self.hands.items()
        }
        return replace(loose, fed=tuple(name for name in self.fed if name != wire), hands=hands)


def known(there: Mapping[str, object] | tuple[str, ...], name: str, noun: str) -> None:
    """Raise UNKNOWN_NAME unless there is a thing of this name."""
    if name not in there:
        names = ", ".join(there) or "none; load a panel first"
        raise AbilityError(ErrorCode.UNKNOWN_NAME, f"no {noun} {name!r}; there are: {names}")


# What was done in the world that cannot be undone, and the account of it.
#
# Tests of supervisors that die and restart check the ledger: it is written in the same transaction
# as the world, and only ever grows.


class Deed(Enum):
    """What is written down."""

    LOAD = "load"  # a panel, every wire taken away
    FEED = "feed"  # a new piece of a wire
    FIX = "fix"  # an end in a terminal
    LOOSEN = "loosen"  # a fixed end, out of its terminal
    DISCARD = "discard"  # a piece of a wire, into the scrap bin


@dataclass(frozen=True)
class Entry:
    """One deed.

    Attributes:
        deed: what was done.
        cell: that did it.
        wire: that it was done to; of a load, the panel.
        end: "a" or "b"; empty of a load, a feed and a discard.
        terminal: "component/terminal", or the channel of a feed.
        goal: id of the goal that asked for it; empty of a load and a feed.
        at_s: [s] wall time, since 1970.
    """

    deed: Deed
    cell: str
    wire: str
    end: str = ""
    terminal: str = ""
    goal: str = ""
    at_s: float = 0.0


@dataclass(frozen=True)
class Account:
    """What a ledger says about the wires of an order.

    Attributes:
        fixed_again: "wire/end" of ends that were fixed more than once.
        fed_again: wires that were fed more than once.
        scrapped: wires of which a piece with a fixed end was discarded, or replaced by another.
        omitted: "wire/end" of wanted ends that were never fixed, or loosened after it.
    """

    fixed_again: tuple[str, ...]
    fed_again: tuple[str, ...]
    scrapped: tuple[str, ...]
    omitted: tuple[str, ...]


def account(ledger: Iterable[Entry], wanted: Collection[str]) -> Account:
    """Return the account of what was done to these wires, since the panel was loaded."""
    fixed: Counter[str] = Counter()
    fed: Counter[str] = Counter()
    holding: set[str] = set()
    scrapped = []
    for entry in ledger:
        end = f"{entry.wire}/{entry.end}"
        if entry.deed is Deed.LOAD:
            fixed, fed, holding, scrapped = Counter(), Counter(), set(), []
        elif entry.deed in (Deed.FEED, Deed.DISCARD):
            ends = {f"{entry.wire}/a", f"{entry.wire}/b"}
            fed[entry.wire] += entry.deed is Deed.FEED
            if holding & ends:
                scrapped.append(entry.wire)
            holding -= ends
        elif entry.deed is Deed.FIX:
            fixed[end] += 1
            holding.add(end)
        else:
            holding.discard(end)
    ends = [f"{wire}/{end}" for wire in wanted for end in "ab"]
    return Account(
        tuple(end for end in ends if fixed[end] > 1),
        tuple(wire for wire in wanted if fed[wire] > 1),
        tuple(wire for wire in scrapped if wire in wanted),
        tuple(end for end in ends if end not in holding),
    )
