"""What was done in the world that cannot be undone, and the account of it.

Tests of supervisors that die and restart check the ledger: it is written in the same transaction
as the world, and only ever grows.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from enum import Enum


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
