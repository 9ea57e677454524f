"""The grammar of the chart language: which element may hold what.

`STATEMACHINE` follows chapter 6 of Deliverable 5.1. What chapter 6 lacks stands in the namespace
`EXTENSION`, so that a plain chart stays valid.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

EXTENSION = "urn:remodel:statechart:ext:1"


@dataclass(frozen=True)
class Shape:
    """What an element may hold: attributes, attributes of the extension, and elements."""

    required: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()
    extensions: tuple[str, ...] = ()
    children: Mapping[str, Shape] = field(default_factory=dict)

    @property
    def attributes(self) -> tuple[str, ...]:
        """Return the names of the attributes that chapter 6 gives the element."""
        return self.required + self.optional


PORT = Shape(("name",), ("type",))
OUTCOME = Shape(("name",))
NODE_CHILDREN = {
    "input": PORT,
    "output": PORT,
    "param": Shape(("name", "value")),
    "transition": Shape(("event", "target"), (), ("autonomy",)),
}
STATEMACHINE = Shape(
    ("name", "initial"),
    children={
        "datamodel": Shape(
            children={
                "outcome": OUTCOME,
                "outcomes": Shape(children={"outcome": OUTCOME}),
                "input": Shape(("name",), ("type",), ("default",)),
                "output": PORT,
            }
        ),
        "state": Shape(("id", "type"), ("topic",), ("attempts", "timeout_s"), NODE_CHILDREN),
        "behavior": Shape(("id", "type"), (), ("attempts", "timeout_s"), NODE_CHILDREN),
        "connection": Shape(("output_state_id", "output", "input_state_id", "input")),
    },
)


def homes(name: str) -> tuple[str, ...]:
    """Return the elements that may hold an element of that name."""
    return tuple(dict.fromkeys(_find_homes(name, "statemachine", STATEMACHINE)))


def _find_homes(name: str, parent: str, shape: Shape) -> Iterator[str]:
    if name in shape.children:
        yield parent
    for tag, child in shape.children.items():
        yield from _find_homes(name, tag, child)
