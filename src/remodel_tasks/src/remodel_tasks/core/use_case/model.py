"""A use case: how its tasks decompose into actions, and what its users want.

docs/use-cases.md explains the YAML; config/use_case.schema.json is its form.

How long abilities take, and how often they succeed, is the one place where experience enters the
planner: whatever offers `expect` can stand for a use case's frozen values. Only within `Bounds` may
experience choose a parameter. `Designs` says for which designs a use case is meant, and what of the
cell around the board it takes for given.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from itertools import product
from typing import Protocol

from remodel_tasks.core.condition import Condition, Features, Value, is_number
from remodel_tasks.core.use_case.fault import Policy

# name -> value, sorted by name; hashable.
Setting = tuple[tuple[str, float], ...]

# [settings] The trials of an order cannot compare more.
_MOST_SETTINGS = 30


@dataclass(frozen=True)
class Bounds:
    """What is safe for a parameter; its unit is the parameter's.

    Attributes:
        frozen: value that is used without learning.
        count: how many values are tried; the frozen one is among them.
    """

    frozen: float
    low: float
    high: float
    count: int = 5

    def __post_init__(self) -> None:
        """Refuse bounds that hold no choice.

        Raises:
            ValueError: if they are not in order, or there are fewer than two values.
        """
        if not -math.inf < self.low <= self.frozen <= self.high < math.inf or self.count < 2:
            raise ValueError(
                f"bounds must be low <= frozen <= high with a count of at least 2, found "
                f"{self.low:g}, {self.frozen:g}, {self.high:g}, {self.count}"
            )

    @property
    def values(self) -> tuple[float, ...]:
        """The values that are tried, evenly spaced but for the frozen one."""
        step = (self.high - self.low) / (self.count - 1)
        even = [self.low + step * i for i in range(self.count)]
        nearest = min(range(self.count), key=lambda i: abs(even[i] - self.frozen))
        even[nearest] = self.frozen
        return tuple(sorted(set(even)))


def frozen_setting(bounds: Mapping[str, Bounds]) -> Setting:
    """Return the setting that is used without learning."""
    return tuple((name, bounds[name].frozen) for name in sorted(bounds))


def nearer_settings(bounds: Mapping[str, Bounds]) -> dict[Setting, Setting]:
    """Return, of each setting but the frozen one, its neighbour towards the frozen one.

    The parameter that is the most steps away goes one step back.
    """
    return {
        setting: _nearer(setting, bounds)
        for setting in settings(bounds)
        if setting != frozen_setting(bounds)
    }


def _nearer(setting: Setting, bounds: Mapping[str, Bounds]) -> Setting:
    steps = {name: _steps(bounds[name], value) for name, value in setting}
    furthest = max(steps, key=lambda name: abs(steps[name]))
    values = bounds[furthest].values
    back = values.index(dict(setting)[furthest]) - (1 if steps[furthest] > 0 else -1)
    return tuple((name, values[back] if name == furthest else value) for name, value in setting)


def _steps(bounds: Bounds, value: float) -> int:
    """Return how many values a value is above the frozen one."""
    return bounds.values.index(value) - bounds.values.index(bounds.frozen)


def settings(bounds: Mapping[str, Bounds]) -> tuple[Setting, ...]:
    """Return all settings of some parameters together.

    Raises:
        ValueError: if there are too many to learn which is best.
    """
    names = sorted(bounds)
    found = tuple(
        tuple(zip(names, values, strict=True))
        for values in product(*(bounds[name].values for name in names))
    )
    if len(found) > _MOST_SETTINGS:
        raise ValueError(
            f"{len(found)} settings of {', '.join(names)}; at most {_MOST_SETTINGS} can be "
            "compared: learn fewer parameters, or fewer values of each"
        )
    return found


@dataclass(frozen=True)
class Expectation:
    """What one call of an ability is expected to take [s], and the probability of its success."""

    duration_s: float
    success: float

    def tried(self, attempts: int, between_s: float = 0.0) -> Expectation:
        """Return what is expected of up to that many calls, until the first that succeeds.

        Args:
            attempts: at least 1.
            between_s: what recovering from a failure takes.
        """
        failure = (1 - self.success) ** attempts
        calls = (1 - failure) / self.success if self.success > 0 else attempts
        return Expectation(self.duration_s * calls + between_s * (calls - 1), 1 - failure)

    def then(self, other: Expectation) -> Expectation:
        """Return what is expected of this and another call after it."""
        return Expectation(self.duration_s + other.duration_s, self.success * other.success)


NOTHING = Expectation(0.0, 1.0)


class Expectations(Protocol):
    """Knows what to expect of abilities."""

    def expect(self, ability: str, features: Features) -> Expectation:
        """Return what is expected of a call of the ability for a task with these features."""


@dataclass(frozen=True)
class Frozen:
    """An expectation that a use case states, for the tasks that meet its condition.

    Attributes:
        per_m_s: [s] more for each metre of the task's length.
    """

    when: Condition
    duration_s: float
    per_m_s: float
    success: float


@dataclass(frozen=True)
class FrozenExpectations:
    """What a use case states, before there is experience: the first that applies counts."""

    stated: dict[str, tuple[Frozen, ...]]

    def expect(self, ability: str, features: Features) -> Expectation:
        """Return what is expected of a call of the ability for a task with these features."""
        frozen = next(item for item in self.stated[ability] if item.when.holds(features))
        length_m = float(features.get("length_m", 0.0))
        return Expectation(frozen.duration_s + frozen.per_m_s * length_m, frozen.success)


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


# What actions refer to for the force with which they may push.
FORCE = "force_n"
# The same for the arm that does them.
ARM = "arm"
# What conditions refer to for which end of its task is inserted, "first" or "second".
INSERTED = "end"


class Macro(Enum):
    """The macro operations of which every task is made.

    LOCATE observes a component, once for all tasks.
    """

    PICK = "pick"
    LOCATE = "locate"
    INSERT = "insert"
    ROUTE = "route"
    FIX = "fix"
    HAND_OVER = "hand_over"


@dataclass(frozen=True)
class Characteristic:
    """What a task or a component may say about itself, and what holds if it does not.

    Attributes:
        allowed: the values that it may have; `least` and `most` bound it if it is a number.
    """

    name: str
    default: Value
    allowed: tuple[Value, ...]
    least: float
    most: float

    def objection(self, value: Value) -> str:
        """Return what a value must be, if it is not; else nothing."""
        if self.allowed:
            return "" if value in self.allowed else f"one of {', '.join(map(str, self.allowed))}"
        if not is_number(self.default):
            kind = type(self.default)
            return "" if isinstance(value, kind) else f"a {kind.__name__}, as {self.default!r} is"
        if not is_number(value) or not self.least <= float(value) <= self.most:
            return f"a number from {self.least:g} to {self.most:g}"
        return ""

    def excess(self, value: Value) -> str:
        """Return which bound a number exceeds, such as "above 4", which many may; else nothing."""
        if self.allowed or not is_number(self.default) or not is_number(value):
            return ""
        if float(value) > self.most:
            return f"above {self.most:g}"
        return f"below {self.least:g}" if float(value) < self.least else ""


def declared(
    said: Mapping[str, Value], characteristics: Mapping[str, Characteristic]
) -> dict[str, Value]:
    """Return those values of a design that are declared as characteristics, without empty texts."""
    return {name: value for name, value in said.items() if name in characteristics and value != ""}


class Scope(Enum):
    """What a fact is about."""

    TASK = "task"
    COMPONENT = "component"


@dataclass(frozen=True)
class Fact:
    """A condition that is unknown until the action `look` reveals it, such as where ends lie."""

    name: str
    of: Scope
    look: str


@dataclass(frozen=True)
class Action:
    """What an arm does by one state, or by one behavior that exists.

    Attributes:
        title: the state's id in charts; `{end}` is the letter of the end concerned.
        type: of the state or behavior.
        done: its outcomes on success.
        abilities: that it calls, one after another.
        tool: that the arm must have; empty: any.
        force_n: [N] with which it pushes at most; 0: it does not push.
        needs: facts that must be known, and the input that takes each one; empty: none does.
        reveals: facts known afterwards, and the output that carries each one; empty: none does.
        forgets: facts that no longer hold afterwards.
        grasps: whether the hand may hold something afterwards.
        inputs: of the state, as references to the task's values.
        params: of the state: literals, or references.
        attempts: how often it is tried.
        recover: the action that undoes what a failure leaves; empty: there is nothing to undo.
        on_failure: the earlier action that is done again when it fails; empty: itself.
    """

    name: str
    title: str
    type: str
    is_behavior: bool
    done: tuple[str, ...]
    abilities: tuple[str, ...]
    tool: str
    force_n: float
    needs: tuple[tuple[str, str], ...]
    reveals: tuple[tuple[str, str], ...]
    forgets: tuple[str, ...]
    grasps: bool
    inputs: tuple[tuple[str, str], ...]
    params: tuple[tuple[str, object], ...]
    attempts: int
    recover: str
    on_failure: str

    @property
    def yields(self) -> bool:
        """Whether it takes the force limit as a parameter, and so can push less hard."""
        return f"${FORCE}" in dict(self.params).values()

    def leaves_open(self, parameter: str) -> bool:
        """Return whether a run may choose a parameter: one that is not stated, or the force."""
        return dict(self.params).get(parameter) in (None, f"${FORCE}")

    @property
    def is_of_any_arm(self) -> bool:
        """Whether the plan chooses the arm that does it; else its parameters name the robot."""
        return f"${ARM}" in dict(self.params).values()


@dataclass(frozen=True)
class Subtask:
    """A part of a method: an action or a task, once or for each clip of the route."""

    name: str
    for_each_clip: bool = False


@dataclass(frozen=True)
class Method:
    """One decomposition of a task, for those that meet its condition.

    Attributes:
        if_cheaper: whether it may be taken in place of the method before it, if it costs less.
    """

    name: str
    when: Condition
    if_cheaper: bool
    subtasks: tuple[Subtask, ...]


@dataclass(frozen=True)
class ControlRule:
    """An action that must not be used for tasks that meet a condition."""

    name: str
    never: str
    when: Condition


@dataclass(frozen=True)
class CellTimes:
    """Times that are the cell's, not an ability's.

    Attributes:
        failure_s: what a task that fails costs in all: an operator comes, or a new wire is taken.
        carry_height_m: of the tool centre over the panel while something is carried.
    """

    speed_m_s: float
    change_tool_s: float
    extract_s: float
    failure_s: float
    carry_height_m: float


@dataclass(frozen=True)
class UseCase:
    """Everything that is particular to one kind of work.

    Attributes:
        title: of the behavior that does a task; `{task}` is the task's name.
        task_characteristics: what tasks may say; what they ask of an arm follows from it.
        heavy: which tasks are to come before the others.
        learned: ability -> parameter -> within which values runs may choose it.
        methods: by the name of the task that they do, in the order in which they are preferred.
        give_up: the actions that empty the hands, one after another, when a task is given up.
        discard: the action that takes a task's part off the panel into the scrap bin; empty: none.
        preferences: weights, preferences and requirements, as in a preferences document.
        recovery: what is done about tasks that fail.
        designs: how imported designs become its orders; None: they do not.
    """

    name: str
    title: str
    description: str
    task_characteristics: dict[str, Characteristic]
    component_characteristics: dict[str, Characteristic]
    heavy: Condition
    facts: dict[str, Fact]
    expectations: FrozenExpectations
    learned: Mapping[str, Mapping[str, Bounds]]
    actions: dict[str, Action]
    methods: dict[str, tuple[Method, ...]]
    rules: tuple[ControlRule, ...]
    cell: CellTimes
    give_up: tuple[str, ...]
    discard: str
    preferences: dict[str, object]
    recovery: Policy
    designs: Designs | None

    @property
    def file_name(self) -> str:
        """The name of the file that states it."""
        return f"{self.name}.yaml"
