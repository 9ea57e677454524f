"""The physical world of a fake cell, as a value.

A wire's end is loose, seated (pushed into a terminal, its clamp open) or fixed (clamp closed). Each
cell has one hand and one feeder; several cells may work on one panel.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from remodel_msgs.msg import ErrorCode

# x, y, z [m] and yaw [rad]; panel frame.
Place = tuple[float, float, float, float]


class WorldError(Exception):
    """What was asked cannot be."""

    def __init__(self, code: int, text: str) -> None:
        """Tell a remodel_msgs/ErrorCode, and why."""
        super().__init__(text)
        self.code = code


@dataclass(frozen=True)
class Panel:
    """What is mounted, and which wires belong on it.

    Attributes:
        name: of the panel.
        wires: wire -> terminals of its ends a and b, as "component/terminal".
        lengths: wire -> [m].
        components: component -> place of its base.
        mouths: "component/terminal" -> place of the mouth, yaw into the bore.
        channels: in which wires are fed.
    """

    name: str = ""
    wires: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    lengths: Mapping[str, float] = field(default_factory=dict)
    components: Mapping[str, Place] = field(default_factory=dict)
    mouths: Mapping[str, Place] = field(default_factory=dict)
    channels: tuple[str, ...] = ()


@dataclass(frozen=True)
class Seat:
    """Where an end sits that is not loose: terminal as "component/terminal"."""

    terminal: str
    fixed: bool


@dataclass(frozen=True)
class Hand:
    """One cell's feeder and gripper.

    Attributes:
        live: wire that the feeder presented last; empty: none.
        held: end of the live wire in the fingers, "a" or "b"; empty: none.
    """

    live: str = ""
    held: str = ""


@dataclass(frozen=True)
class World:
    """Everything that lasts.

    Attributes:
        panel: see Panel.
        fed: wires in the order of their last feeding.
        seats: "wire/end" -> where it sits; loose ends are not listed.
        hands: cell -> its hand.
    """

    panel: Panel = Panel()
    fed: tuple[str, ...] = ()
    seats: Mapping[str, Seat] = field(default_factory=dict)
    hands: Mapping[str, Hand] = field(default_factory=dict)

    def hand(self, cell: str) -> Hand:
        """Return a cell's hand."""
        return self.hands.get(cell, Hand())

    def seat(self, wire: str, end: str) -> Seat | None:
        """Return where an end sits; None if it is loose."""
        return self.seats.get(f"{wire}/{end}")

    def occupant(self, terminal: str) -> str | None:
        """Return the "wire/end" that a terminal holds."""
        return next((end for end, seat in self.seats.items() if seat.terminal == terminal), None)

    def is_placed(self, wire: str) -> bool:
        """Return whether both ends are fixed where they belong."""
        ends = zip(("a", "b"), self.panel.wires[wire], strict=True)
        return all(self.seat(wire, end) == Seat(terminal, True) for end, terminal in ends)

    def with_hand(self, cell: str, **changes: str) -> World:
        """Return the world with a cell's hand changed."""
        return replace(self, hands={**self.hands, cell: replace(self.hand(cell), **changes)})

    def with_seat(self, wire: str, end: str, seat: Seat | None) -> World:
        """Return the world with an end seated, fixed, or loose."""
        others = {key: value for key, value in self.seats.items() if key != f"{wire}/{end}"}
        return replace(self, seats={**others, f"{wire}/{end}": seat} if seat else others)

    def feed(self, cell: str, wire: str, channel: str) -> World:
        """Return the world with a new piece of a wire in a cell's channel, both ends loose.

        The piece that was there, if any, is gone.

        Raises:
            WorldError: if there is no such wire or channel, or the hand holds a wire.
        """
        known(self.panel.wires, wire, "wire")
        known(self.panel.channels, channel, "channel")
        hand = self.hand(cell)
        if hand.held:
            raise WorldError(
                ErrorCode.OTHER_CABLE_HELD,
                f"the gripper holds end {hand.held} of {hand.live!r}; place it first",
            )
        without = {
            name: Hand() if other.live == wire else other for name, other in self.hands.items()
        }
        loose = self.with_seat(wire, "a", None).with_seat(wire, "b", None)
        fed = (*(other for other in self.fed if other != wire), wire)
        return replace(loose, fed=fed, hands={**without, cell: Hand(live=wire)})


def known(there: Mapping[str, object] | tuple[str, ...], name: str, noun: str) -> None:
    """Raise UNKNOWN_NAME unless there is a thing of this name."""
    if name not in there:
        names = ", ".join(there) or "none; load a panel first"
        raise WorldError(ErrorCode.UNKNOWN_NAME, f"no {noun} {name!r}; there are: {names}")
