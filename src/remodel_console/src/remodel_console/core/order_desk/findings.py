"""What the planner's commands print with `--json`, as values."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeVar

import msgspec

from remodel_console.errors import CommandError

T = TypeVar("T")
_PLANNED_AT_ONCE = 3000  # tasks, which are planned in 10 s of CPU time


@dataclass(frozen=True)
class LeftOut:
    """Something of a file that is not in the order, and why."""

    source: str
    reason: str


@dataclass(frozen=True)
class Account:
    """What an import read, assumed and left out; see remodel_production's `Account`."""

    unit: str
    connections: int
    assumptions: tuple[str, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    ignored: tuple[LeftOut, ...] = ()
    joined: int = 0
    wires_joined: int = 0
    unused_columns: tuple[LeftOut, ...] = ()


@dataclass(frozen=True)
class ByHand:
    """A task that no robot does, and why, with the file and key that decides."""

    task: str
    reason: str
    wires: tuple[str, ...] = ()

    @property
    def words(self) -> str:
        """Return the task, and the cores of a cable."""
        return f"{self.task}: {', '.join(self.wires)}" if len(self.wires) > 1 else self.task


@dataclass(frozen=True)
class OtherMethod:
    """Tasks that are done by another method than the preferred one, and why not by that."""

    method: str
    tasks: tuple[str, ...]
    reason: str


@dataclass(frozen=True)
class Triage:
    """Who does which task.

    Attributes:
        robot: names of its tasks; a cable is one.
        cables: the cores of those that are cables, by name.
        outside: wires that leave the plate.
    """

    use_case: str
    robot: tuple[str, ...]
    cables: dict[str, tuple[str, ...]] = field(default_factory=dict)
    other_methods: tuple[OtherMethod, ...] = ()
    by_hand: tuple[ByHand, ...] = ()
    outside: tuple[ByHand, ...] = ()

    @property
    def hand_reasons(self) -> dict[str, str]:
        """Return why no robot places a wire, by the name of each such wire."""
        tasks = (*self.by_hand, *self.outside)
        return {wire: each.reason for each in tasks for wire in each.wires or (each.task,)}

    @property
    def is_long(self) -> bool:
        """Return whether a plan takes minutes: a person says whether it is wanted."""
        return len(self.robot) > _PLANNED_AT_ONCE


@dataclass(frozen=True)
class CellFit:
    """What the cell takes of an order.

    Attributes:
        name: of the cell.
        summary: how many wires its robots place, and whether the board fits, in words.
        misfits: why the board does not fit; empty if it does.
    """

    name: str
    summary: str
    misfits: tuple[str, ...] = ()


@dataclass(frozen=True)
class Lengths:
    """Lines about wires whose lengths do not fit their routes on the board, or their rings."""

    too_short: tuple[str, ...] = ()
    too_long: tuple[str, ...] = ()
    rings: tuple[str, ...] = ()
    cut_longer: tuple[str, ...] = ()


@dataclass(frozen=True)
class Imported:
    """A design file that was read.

    Attributes:
        counts: of components, wires, cables, segments and clips.
        use_cases: names of all that there are.
        triage: None if nothing can be planned, as `nothing_to_plan` says.
        cell: None if no cell is known.
    """

    order: str
    title: str
    counts: dict[str, int]
    wires_in_cabinet: int
    account: Account
    lengths: Lengths
    use_cases: tuple[str, ...] = ()
    triage: Triage | None = None
    nothing_to_plan: str = ""
    cell: CellFit | None = None


@dataclass(frozen=True)
class PlannedAction:
    """What an arm does: with which wire, if any, and where; times in [s]."""

    action: str
    arm: str
    wire: str
    target: str
    start_s: float
    duration_s: float


@dataclass(frozen=True)
class Violated:
    """A preference that a plan violates, by its name, the wires that show it, and how."""

    reason: str
    wires: tuple[str, ...]
    words: str


@dataclass(frozen=True)
class Plan:
    """A plan.

    Attributes:
        penalties: by the name of their weight.
        features: of wires, by which preferences can choose them.
        segments: of the board that wires are routed through.
        cables: wires by the cables that they are cores of.
        split_cables: a line for each cable whose cores the plan could not keep together.
        search: how it ended.
        violations: of preferences, the first thousand.
    """

    cost: int
    makespan_s: float
    penalties: dict[str, int]
    arms: tuple[str, ...]
    features: tuple[str, ...]
    segments: tuple[str, ...]
    actions: tuple[PlannedAction, ...]
    search: str
    cables: dict[str, tuple[str, ...]] = field(default_factory=dict)
    split_cables: tuple[str, ...] = ()
    violations: tuple[Violated, ...] = ()
    triage: Triage | None = None

    @cached_property
    def violated(self) -> dict[str, tuple[str, ...]]:
        """Return what the plan violates of preferences, in words, by wire."""
        found: dict[str, tuple[str, ...]] = {}
        for each in self.violations:
            words = f"{each.reason}: {each.words}" if each.reason else each.words
            for wire in each.wires:
                found[wire] = (*found.get(wire, ()), words)
        return found


@dataclass(frozen=True)
class Conflicting:
    """A requirement that contradicts others or the design: entry `index` of its source."""

    source: str
    index: int
    entry: dict[str, Any]


@dataclass(frozen=True)
class NoPlan:
    """Why there is no plan.

    Attributes:
        error: the command's own words.
        conflicts: smallest sets of requirements that no plan keeps.
    """

    error: str
    conflicts: tuple[tuple[Conflicting, ...], ...] = ()


def read_findings(text: str, kind: type[T]) -> T:
    """Return what a command has printed.

    Raises:
        CommandError: if it is something else, such as of another version.
    """
    try:
        return msgspec.convert(json.loads(text), kind)
    except (ValueError, msgspec.ValidationError) as error:
        raise CommandError(
            f"the planner's answer cannot be read ({error}): are the console and remodel_planner "
            "of one version?"
        ) from error
