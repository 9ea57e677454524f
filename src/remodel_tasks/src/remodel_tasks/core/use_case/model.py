"""A use case: how its tasks decompose into actions, and what its users want.

docs/use-cases.md explains the YAML; config/use_case.schema.json is its form.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from remodel_tasks.core.condition import Condition, Value, is_number
from remodel_tasks.core.use_case.bounds import Bounds
from remodel_tasks.core.use_case.designs import Designs
from remodel_tasks.core.use_case.expectation import FrozenExpectations
from remodel_tasks.core.use_case.policy import Policy

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
