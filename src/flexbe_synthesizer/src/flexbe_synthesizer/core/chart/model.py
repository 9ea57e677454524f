"""A state chart as values: what chapter 6 of Deliverable 5.1 can say, and our extensions of it.

Charts come from `chart_reader.parse_chart` or are built in code; in code, `source` stays out. Two
charts are equal if they say the same, wherever they stand.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol, TypeAlias
from xml.etree.ElementTree import Element as XmlElement

from flexbe_synthesizer.core.chart.literal import Literal, format_literal, freeze, parse_literal
from flexbe_synthesizer.core.chart.problem import Position
from flexbe_synthesizer.core.chart.quick import quick


class Places(Protocol):
    """The file that a chart was read from."""

    def place(self, element: XmlElement, attribute: str) -> Position:
        """Return where an attribute of an element stands; of "", where the element does."""


Source: TypeAlias = tuple[Places, XmlElement]


@dataclass(frozen=True, kw_only=True, slots=True)
class Element:
    """Anything that has an element of its own in the file."""

    source: Source | None = field(default=None, compare=False, repr=False)

    def position(self, attribute: str = "") -> Position:
        """Return where the attribute stands, else the element; 0:0 for charts built in code."""
        if self.source is None:
            return Position("<chart>", 0, 0)
        places, element = self.source
        return places.place(element, attribute)


class Autonomy(Enum):
    """How much autonomy a transition needs before the engine takes it unasked."""

    OFF = "off"
    LOW = "low"
    HIGH = "high"
    FULL = "full"


Point: TypeAlias = tuple[int, int]
"""Where the upper left corner of something is drawn: right and down from that of what it is in."""


@quick
@dataclass(frozen=True, slots=True)
class Outcome(Element):
    """One way in which the chart ends; `at` is where it is drawn, None: anywhere."""

    name: str
    at: Point | None = None


@quick
@dataclass(frozen=True, slots=True)
class Input(Element):
    """A value that the chart, or a state in it, reads; only the chart's own have a default."""

    name: str
    type: str | None = None
    default: Literal = None

    def __post_init__(self) -> None:
        """Freeze the default."""
        object.__setattr__(self, "default", freeze(self.default))


@quick
@dataclass(frozen=True, slots=True)
class Output(Element):
    """A value that the chart, or a state in it, writes."""

    name: str
    type: str | None = None


@quick
@dataclass(frozen=True, slots=True)
class Param(Element):
    """A constructor argument of a state, or a parameter of a behavior.

    Attributes:
        spelled: how the chart spells the value; empty in charts built in code.
    """

    name: str
    value: Literal
    spelled: str = field(default="", compare=False, repr=False)

    def __post_init__(self) -> None:
        """Freeze the value."""
        object.__setattr__(self, "value", freeze(self.value))

    @property
    def text(self) -> str:
        """Return the text of the value, as it is spelled if it still is that value."""
        is_same = self.spelled != "" and parse_literal(self.spelled) == self.value
        return self.spelled if is_same else format_literal(self.value)


@quick
@dataclass(frozen=True, slots=True)
class Transition(Element):
    """Where an outcome of a state leads: to a state, a behavior or an outcome of the chart."""

    event: str
    target: str
    autonomy: Autonomy | None = None


@quick
@dataclass(frozen=True, slots=True)
class Connection(Element):
    """A data flow; the chart's own name as a state id means its inputs or outputs."""

    output_state_id: str
    output: str
    input_state_id: str
    input: str


@dataclass(frozen=True, slots=True)
class ErrorRoute:
    """Where a failure leads by its error code.

    Attributes:
        codes: a code, the first and last one of a range, or the name of a code or of a class of
            codes: `305`, `100-199`, `INSERTION_JAMMED`, `above_behavior`.
        target: a state, a behavior or an outcome.
    """

    codes: str
    target: str


@dataclass(frozen=True, slots=True)
class Node(Element):
    """What states, behaviors and containers have in common.

    Attributes:
        attempts: how often it may be entered in one run; adds the event `exhausted`.
        timeout_s: how long one visit may take [s].
        on_error: where the event `failed` leads for some values of the output `error_code`: the
            first route that has the code; for all others its transition says so.
        at: where it is drawn; None: anywhere.
    """

    id: str
    type: str
    transitions: tuple[Transition, ...] = ()
    inputs: tuple[Input, ...] = ()
    outputs: tuple[Output, ...] = ()
    params: tuple[Param, ...] = ()
    attempts: int | None = None
    timeout_s: float | None = None
    on_error: tuple[ErrorRoute, ...] = ()
    at: Point | None = None

    @property
    def kind(self) -> str:
        """Return the word for it in messages."""
        return type(self).__name__.lower()


@quick
@dataclass(frozen=True, slots=True)
class State(Node):
    """A state; `topic` is the name of the action that it calls, in place of its class's own."""

    topic: str | None = None


@quick
@dataclass(frozen=True, slots=True)
class Behavior(Node):
    """A behavior inside the chart: a display name, a class, or the path of another chart."""


class ContainerKind(Enum):
    """How a container runs what is in it; the value is the tag of its element."""

    SEQUENCE = "container"
    CONCURRENCY = "concurrency"
    PRIORITY = "priority"


@dataclass(frozen=True, slots=True)
class Container(Node):
    """A chart inside the chart: `type` is the value of a `ContainerKind`, `body` its content.

    The body has the container's id as its name. What the container offers to the chart around it
    is the body's datamodel, so its own `inputs`, `outputs` and `params` stay empty.
    """

    body: Chart = field(default_factory=lambda: Chart("", ""))

    @property
    def runs(self) -> ContainerKind:
        """Return how it runs what is in it."""
        return ContainerKind(self.type)


@quick
@dataclass(frozen=True, slots=True)
class When(Element):
    """A state of a concurrency container that has ended with an event."""

    state: str
    event: str


@quick
@dataclass(frozen=True, slots=True)
class Condition(Element):
    """An outcome of a concurrency container, and all that must have happened for it."""

    outcome: str
    all_of: tuple[When, ...] = ()


@dataclass(frozen=True, slots=True)
class Chart(Element):
    """A state chart, or the content of a container.

    Attributes:
        name: display name of the behavior that it becomes; the id of a container.
        initial: id of the first state; empty in a concurrency container, which starts all.
        nodes: states, behaviors and containers, in document order.
        conditions: of a concurrency container only.
        description: what it does, for people; the comment at the head of the file.
        author: who wrote it, as FlexBE's manifests say it; empty: not named.
        tags: words by which FlexBE's tools find the behavior, with blanks or commas between them.
        file: path that it was read from, empty if it was built in code.
    """

    name: str
    initial: str
    outcomes: tuple[Outcome, ...] = ()
    nodes: tuple[AnyNode, ...] = ()
    inputs: tuple[Input, ...] = ()
    outputs: tuple[Output, ...] = ()
    connections: tuple[Connection, ...] = ()
    conditions: tuple[Condition, ...] = ()
    description: str = ""
    file: str = field(default="", compare=False)
    author: str = ""
    tags: str = ""

    def __post_init__(self) -> None:
        """Bring the description into the form that an XML comment can hold."""
        lines = inspect.cleandoc("\n".join(self.description.splitlines())).splitlines()
        tidy = "\n".join(line.rstrip() for line in lines).strip()
        object.__setattr__(self, "description", re.sub(r"-(?=-)", "- ", tidy))


AnyNode: TypeAlias = State | Behavior | Container


def walk_nodes(chart: Chart) -> Iterator[AnyNode]:
    """Yield every state, behavior and container of a chart, those inside containers too."""
    for node in chart.nodes:
        yield node
        if isinstance(node, Container):
            yield from walk_nodes(node.body)
