"""A state chart as values: what chapter 6 of Deliverable 5.1 can say, and our extensions of it.

A literal is null, a boolean, a number, a string, a list or a dictionary, spelled as in JSON or as
in Python; lists and dictionaries nest at most `DEEPEST` levels. Text that is no literal is a
string. Nothing is ever evaluated.

Charts come from `chart_reader.parse_chart` or are built in code; in code, `source` stays out. Two
charts are equal if they say the same, wherever they stand.
"""

from __future__ import annotations

import ast
import inspect
import json
import math
import re
import reprlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol, TypeAlias, TypeGuard, TypeVar
from xml.etree.ElementTree import Element as XmlElement

from flexbe_synthesizer.core.chart.problem import Position

_Class = TypeVar("_Class")


def quick(cls: type[_Class]) -> type[_Class]:
    """Return a frozen dataclass with slots, made in half the time.

    The constructor that `dataclasses` writes looks up each field in the class before it sets it;
    this one sets the slots themselves. Fields have no default factory.
    """
    old = cls.__init__
    code, has_more = old.__code__, hasattr(cls, "__post_init__")
    taken = code.co_varnames[1 : code.co_argcount + code.co_kwonlyargcount]
    arguments = list(taken)
    if code.co_kwonlyargcount:
        arguments.insert(code.co_argcount - 1, "*")
    lines = [f"set_{name}(self, {name})" for name in taken]
    lines += ["self.__post_init__()"] * has_more
    body = "".join(f"\n    {line}" for line in lines)
    slots = {f"set_{name}": getattr(cls, name).__set__ for name in taken}
    made: dict[str, Callable[..., None]] = {}
    exec(f"def __init__(self, {', '.join(arguments)}):{body}", slots, made)
    new = made["__init__"]
    new.__defaults__, new.__kwdefaults__ = old.__defaults__, old.__kwdefaults__
    new.__qualname__, new.__module__ = old.__qualname__, cls.__module__
    new.__annotations__ = old.__annotations__
    cls.__init__ = new  # type: ignore[method-assign]
    return cls


Literal: TypeAlias = (
    "bool | int | float | str | tuple[Literal, ...] | dict[str | int, Literal] | None"
)

DEEPEST = 50  # levels of a list or dictionary; Python itself refuses to parse 200
_MOST_BITS = 10_000  # of an integer in one; Python writes none of more than 4300 digits
_HALF = re.compile("[\ud800-\udfff]")  # half a character, which no file or message can hold
_WORDS = {"true": True, "True": True, "false": False, "False": False, "null": None, "None": None}
_INTEGER = re.compile(r"[+-]?(0|[1-9][0-9]{0,17})\Z")  # within 64 bits
_NUMBER = re.compile(r"[+-]?([0-9]+\.[0-9]*|\.[0-9]+|[0-9]+(?=[eE]))([eE][+-]?[0-9]+)?\Z")
# The FlexBE App counts brackets, quotes and '#' in parameter text without looking for strings, and
# ends a section of code at the word "def" between blanks. Escaped, they mean the same to Python.
_UNSAFE_IN_APP = re.compile(r"""[()\[\]{}#'"=]|(?<=\s)def(?=\s)""")


def parse_literal(text: str) -> Literal:
    """Return the value that a text spells."""
    spelled = text.strip()
    if spelled in _WORDS:
        return _WORDS[spelled]
    if _INTEGER.match(spelled):
        return int(spelled)
    if _NUMBER.match(spelled):
        number = float(spelled)
        return number if math.isfinite(number) else text
    if spelled[:1] in ("'", '"', "[", "{"):
        return _parse_structure(spelled, text)
    return text


def as_declared(text: str, wanted: str | None) -> Literal:
    """Return the value that a text spells where a type is declared.

    What is declared a string is the text as it stands, `5` and `true` too; only null stays null.
    """
    value = parse_literal(text)
    is_text = wanted == "string" and value is not None and not isinstance(value, str)
    return text if is_text else value


def _parse_structure(spelled: str, text: str) -> Literal:
    """Return the string, list or dictionary spelled as in JSON or Python, else the text itself."""
    for parse in (json.loads, _parse_python):
        try:
            return freeze(parse(spelled))
        except (ValueError, SyntaxError, TypeError, MemoryError, RecursionError):
            continue
    return text


def _parse_python(text: str) -> object:
    """Return what `ast.literal_eval` does, and read JSON's words too: `{'on': true}`."""
    tree = ast.parse(text, mode="eval")
    for parent in ast.walk(tree):
        for name, value in ast.iter_fields(parent):
            if isinstance(value, list):
                value[:] = [_as_constant(item) for item in value]
            else:
                setattr(parent, name, _as_constant(value))
    return ast.literal_eval(tree)


def _as_constant(node: object) -> object:
    """Return the constant for JSON's words, any other node as it is."""
    if isinstance(node, ast.Name) and node.id in _WORDS:
        return ast.Constant(_WORDS[node.id])
    return node


def freeze(value: object, depth: int = 0) -> Literal:
    """Return the value as a literal, its lists as tuples; it lies in so many lists already.

    Raises:
        TypeError: if it holds anything but the literals of the language, or is nested too deeply.
    """
    if _is_plain(value):
        return value
    if depth < DEEPEST and isinstance(value, list | tuple):
        return tuple(freeze(item, depth + 1) for item in value)
    if depth < DEEPEST and isinstance(value, dict) and all(map(_is_key, value)):
        return {key: freeze(item, depth + 1) for key, item in value.items()}
    is_long = isinstance(value, int)  # which Python refuses to write
    found = "an integer of thousands of digits" if is_long else reprlib.repr(value)
    raise TypeError(
        f"{found} is no literal of a chart: null, a boolean, a finite number, a "
        "string, a list, or a dictionary with strings or integers as keys, of at most "
        f"{DEEPEST} levels"
    )


def _is_plain(value: object) -> TypeGuard[bool | int | float | str | None]:
    """Return whether a value is a literal without others in it, and can be written."""
    if isinstance(value, str):
        return value.isascii() or not _HALF.search(value)
    if isinstance(value, int):
        return value.bit_length() <= _MOST_BITS
    return value is None or (isinstance(value, float) and math.isfinite(value))


def _is_key(value: object) -> bool:
    """Return whether a value can be a key of a dictionary: a string or an integer."""
    return type(value) in (str, int) and _is_plain(value)


def format_literal(value: Literal, wanted: str | None = None) -> str:
    """Return the text that `as_declared` reads as this value."""
    if isinstance(value, str):
        is_plain = value.isprintable() and value != "" and as_declared(value, wanted) == value
        return value if is_plain or value == "" else json.dumps(value)
    if all(isinstance(key, str) for key in _keys_within(value)):
        return json.dumps(value)
    return python_literal(value)  # JSON has no integers as keys


def _keys_within(value: Literal) -> list[object]:
    """Return the keys of all dictionaries in a value."""
    if isinstance(value, tuple):
        return [key for item in value for key in _keys_within(item)]
    if isinstance(value, dict):
        return [*value, *(key for item in value.values() for key in _keys_within(item))]
    return []


def python_literal(value: Literal) -> str:
    """Return the Python expression for a value, on one line and harmless to the FlexBE App."""
    if isinstance(value, str):
        return quote(value)
    if isinstance(value, tuple):
        return "[" + ", ".join(map(python_literal, value)) + "]"
    if isinstance(value, dict):
        items = (f"{python_literal(key)}: {python_literal(item)}" for key, item in value.items())
        return "{" + ", ".join(items) + "}"
    return repr(value)


def quote(text: str) -> str:
    """Return a single-quoted Python string, harmless to the FlexBE App."""
    if text.isidentifier() and text.isascii():  # most are; the rest takes its time
        return f"'{text}'"
    backslashed = text.replace("\\", "\\\\")
    safe = _UNSAFE_IN_APP.sub(lambda found: f"\\x{ord(found[0][0]):02x}{found[0][1:]}", backslashed)
    return "'" + "".join(c if c.isprintable() else _escape(c) for c in safe) + "'"


def _escape(character: str) -> str:
    return ascii(character)[1:-1]


def type_of(value: Literal) -> str | None:
    """Return the language's name for a value's type; null has none and suits every type."""
    if value is None:
        return None
    names = {bool: "bool", int: "int", float: "float", str: "string", tuple: "list", dict: "dict"}
    return names[type(value)]


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
