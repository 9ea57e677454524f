"""How imported designs become orders of a use case: for which it is meant, and its cell's arms."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

# A value of `first`.
LONGER_LEG = "longer_leg"


class DesignKind(Enum):
    """What an imported design describes."""

    CABINET = "cabinet"
    HARNESS = "harness"


class DesignTasks(Enum):
    """What of a design is a task."""

    WIRES = "wires"
    BRANCHES = "branches"


@dataclass(frozen=True)
class Designs:
    """The cell around the board on which an imported design is laid out.

    The magazine with the wires and the stations of the tools lie below the board, the arms rest
    below those.

    Attributes:
        default_for: the designs that are done by this use case unless another one is asked for.
        tasks: what becomes one.
        arms: names of the left one and the right one; the first is the one that works alone. One
            name: tasks are done one after another, whatever robots their actions name.
        tool: in the arms' hands at first.
        magazine_below_m: [m] of the slots and the stations, below the board.
        station_beside_m: [m] of a station, beside its arm's side of the board.
        home_below_m: [m] of the arms at first, below the board.
        reach_beyond_m: [m] of an arm, past its side of the board.
        reach_of_two: share of the board's width that each of two arms reaches from its side.
        first: end of each wire that is inserted first: "a" or "b", such as the one that a magazine
            presents in front of its terminal, or the one with the "longer_leg" in its first duct;
            None: the planner chooses.
        cell: name or file of the one that does it unless another one is named; empty: not known.
    """

    default_for: DesignKind | None
    tasks: DesignTasks
    arms: tuple[str, ...]
    tool: str
    magazine_below_m: float
    station_beside_m: float
    home_below_m: float
    reach_beyond_m: float
    reach_of_two: float
    first: str | None = None
    cell: str = ""


def designs_from(stated: dict[str, object] | None) -> Designs | None:
    """Return what a use case states under `designs`, in the schema's form; None for nothing."""
    if stated is None:
        return None
    default_for = stated.get("default_for")
    read: dict[str, object] = {
        "default_for": DesignKind(default_for) if default_for else None,
        "tasks": DesignTasks(stated["tasks"]),
        "arms": tuple(stated["arms"]),  # type: ignore[arg-type]  # the schema says it is a list
    }
    return Designs(**{**stated, **read})  # type: ignore[arg-type]  # the schema has its types
