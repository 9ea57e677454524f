"""The Python source that a chart may ask for: predicates by name, and none of its own.

Some states of FlexBE take a function. A chart never carries code, so it names one of these.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

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


def choose_by_code(routes: Iterable[tuple[str, Sequence[int]]], otherwise: str) -> Expression:
    """Return a function from an error code to the name that goes with it.

    Args:
        routes: name and codes of each route, at least one code, ascending.
        otherwise: name of all other codes, and of no code at all.
    """
    chosen = quote(otherwise)
    for name, codes in reversed(tuple(routes)):
        is_row = codes[-1] - codes[0] == len(codes) - 1
        listed = f"range({codes[0]}, {codes[-1] + 1})" if is_row else f"{tuple(codes)}"
        chosen = f"{quote(name)} if code in {listed} else {chosen}"
    return Expression(f"lambda code: {chosen}")


def is_choice_by_code(text: str, events: Iterable[str], otherwise: str) -> bool:
    """Return whether Python source is a function of `choose_by_code` with these names."""
    codes = r"(?:range\(\d+, \d+\)|\((?:\d+, )+\d+\))"
    routes = "".join(rf"{re.escape(quote(event))} if code in {codes} else " for event in events)
    return re.fullmatch(rf"lambda code: {routes}{re.escape(quote(otherwise))}", text) is not None
