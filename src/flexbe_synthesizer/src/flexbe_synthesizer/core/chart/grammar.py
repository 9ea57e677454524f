"""The grammar of the chart language: which element may hold what.

`STATEMACHINE` follows chapter 6 of Deliverable 5.1. What chapter 6 lacks stands in the namespace
`EXTENSION`, so that a plain chart stays valid; its elements have the prefix `ext:` here and in
messages. The published schemas, in `schema/`, say the same to XML editors.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

EXTENSION = "urn:remodel:statechart:ext:1"


@dataclass(frozen=True)
class Shape:
    """What an element may hold: attributes, attributes of the extension, and elements."""

    required: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()
    extensions: tuple[str, ...] = ()
    children: Mapping[str, Shape] = field(default_factory=dict)

    def is_all(self, given: Mapping[str, str]) -> bool:
        """Return whether all required attributes have a value, and there are no others."""
        return len(given) == len(self.required) and all(map(given.get, self.required))

    @property
    def attributes(self) -> tuple[str, ...]:
        """Return the names of the attributes without namespace."""
        return self.required + self.optional


LIMITS = ("attempts", "timeout_s", "on_error", "at")
PORT = Shape(("name",), ("type",))
OUTCOME = Shape(("name",), (), ("at",))
TRANSITION = Shape(("event", "target"), (), ("autonomy",))
WHEN = Shape(("state", "event"))
CONDITION = Shape(("outcome",), children={"ext:when": WHEN})
NODE = {"input": PORT, "output": PORT, "param": Shape(("name", "value")), "transition": TRANSITION}


def _data_model(*input_extensions: str) -> Shape:
    outcomes = Shape(children={"outcome": OUTCOME})
    given = Shape(("name",), ("type",), input_extensions)
    return Shape(
        children={"outcome": OUTCOME, "outcomes": outcomes, "input": given, "output": PORT}
    )


# A container may hold containers, so the two tables of what it holds are filled in below.
_SEQUENCE: dict[str, Shape] = {}
_CONCURRENCY: dict[str, Shape] = {}
_PARTS = {
    "state": Shape(("id", "type"), ("topic",), LIMITS, NODE),
    "behavior": Shape(("id", "type"), (), LIMITS, NODE),
    "connection": Shape(("output_state_id", "output", "input_state_id", "input")),
    "ext:container": Shape(("id", "initial"), (), LIMITS, _SEQUENCE),
    "ext:concurrency": Shape(("id",), (), LIMITS, _CONCURRENCY),
    "ext:priority": Shape(("id", "initial"), (), LIMITS, _SEQUENCE),
}
_SEQUENCE |= _PARTS | {"datamodel": _data_model(), "transition": TRANSITION}
_CONCURRENCY |= _SEQUENCE | {"ext:condition": CONDITION}
STATEMACHINE = Shape(
    ("name", "initial"),
    extensions=("author", "tags"),
    children={"datamodel": _data_model("default"), **_PARTS},
)


def homes(name: str) -> tuple[str, ...]:
    """Return the elements that may hold an element of that name."""
    found: list[str] = []
    shapes = {"statemachine": STATEMACHINE}
    waiting = list(shapes)
    for parent in waiting:
        children = shapes[parent].children
        if name in children:
            found.append(parent)
        for tag, child in children.items():
            if tag not in shapes:
                shapes[tag] = child
                waiting.append(tag)
    return tuple(found)
