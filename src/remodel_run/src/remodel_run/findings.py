"""What the planner finds about an order; its commands print these values with `--json`."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from remodel_run.whole_task import WholeTask

# What the line of a colour that is not known says, for which the default is taken.
UNKNOWN_COLOUR = "is no known colour"
_PLANNED_AT_ONCE = 3000  # tasks, which are planned in 10 s of CPU time


@dataclass(frozen=True)
class LeftOut:
    """Something of the file that is not in the order, and why."""

    source: str
    reason: str

    def __str__(self) -> str:
        """Return the line for a person."""
        return f"{self.source}: left out, {self.reason}"


@dataclass(frozen=True)
class Account:
    """What an import read, assumed and left out.

    Attributes:
        unit: what the format calls a connection, in the plural.
        connections: number of connections in the file. Each became a wire, was joined with others
            into wires, or was left out.
        joined: number of connections that were joined into wires.
        wires_joined: number of wires that those became.
        assumptions: one line for each thing that the file does not say.
        left_out: the other connections.
        ignored: what is no connection, and is not in the order.
        unused_columns: of a list, and sheets of a workbook, that the order has nothing of.
    """

    unit: str
    connections: int
    assumptions: tuple[str, ...]
    left_out: tuple[LeftOut, ...]
    ignored: tuple[LeftOut, ...] = ()
    joined: int = 0
    wires_joined: int = 0
    unused_columns: tuple[LeftOut, ...] = ()

    @property
    def unknown_colours(self) -> tuple[str, ...]:
        """The assumptions for which a colour that is not known got the default."""
        return tuple(line for line in self.assumptions if UNKNOWN_COLOUR in line)

    @property
    def notes(self) -> tuple[str, ...]:
        """Assumptions and what was left out, a line each."""
        omitted = (*self.left_out, *self.ignored, *self.unused_columns)
        return (*self.assumptions, *map(str, omitted))


@dataclass(frozen=True)
class ByHand:
    """A task that no robot does, and why.

    Attributes:
        wires: as of a `WholeTask`.
        kind: of the reason, which several tasks may have in common; empty: it is theirs alone.
    """

    task: str
    wires: tuple[str, ...]
    reason: str
    kind: str = ""

    @property
    def words(self) -> str:
        """The task, and the cores of a cable."""
        return f"{self.task}: {', '.join(self.wires)}" if len(self.wires) > 1 else self.task

    def __str__(self) -> str:
        """Return the line for a person."""
        return f"{WholeTask(self.task, self.wires)}: by hand, {self.reason}"


@dataclass(frozen=True)
class OtherMethod:
    """Tasks that are done by another method than the preferred one.

    Attributes:
        method: the key and the file that states it, such as `methods.pick.thick in cabinet.yaml`.
        tasks: names of tasks as they are counted.
        reason: why the first of them is not done by the preferred method.
    """

    method: str
    tasks: tuple[str, ...]
    reason: str

    def __str__(self) -> str:
        """Return the line for a person."""
        first, *others = self.tasks
        which = (
            f"{len(self.tasks)} by {self.method}, such as {first}"
            if others
            else (f"{first} by {self.method}")
        )
        return f"{which}: not {self.reason}"


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
