"""The Python source that a chart may ask for: predicates by name, and none of its own.

Some states of FlexBE take a function. A chart never carries code, so it names one of these.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from flexbe_synthesizer.core.chart.literal import quote
from flexbe_synthesizer.core.machine.machine import Expression

PARAMETER = "predicate"  # the parameter of FlexBE's states that takes one
PREDICATES: Mapping[str, Expression] = {
    "is_true": Expression("lambda value: bool(value)"),
    "is_false": Expression("lambda value: not value"),
    "is_none": Expression("lambda value: value is None"),
    "is_given": Expression("lambda value: value is not None"),
    "is_empty": Expression("lambda value: len(value) < 1"),
    "is_filled": Expression("lambda value: len(value) > 0"),
    "is_positive": Expression("lambda value: value > 0"),
    "is_negative": Expression("lambda value: value < 0"),
}


def choose_by_code(ranges: Iterable[tuple[int, int, str]], otherwise: str) -> Expression:
    """Return a function from an error code to the name that goes with it.

    Args:
        ranges: first code, last code and name of each range.
        otherwise: name of all other codes, and of no code at all.
    """
    chosen = quote(otherwise)
    for first, last, name in reversed(tuple(ranges)):
        chosen = f"{quote(name)} if code in range({first}, {last + 1}) else {chosen}"
    return Expression(f"lambda code: {chosen}")
