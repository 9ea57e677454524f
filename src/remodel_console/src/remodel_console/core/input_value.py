"""The value that an operator types for a state, as the literal that is sent."""

from __future__ import annotations

import ast


def as_literal(text: str) -> str:
    """Return the text of a Python literal: the one typed, or what was typed as a text."""
    return (
        text.strip() if _value(text) is not None or text.strip() == "None" else repr(text.strip())
    )


def value_words(text: str) -> str:
    """Return what the typed text is sent as."""
    if not text.strip():
        return "A number, a list such as [1.5, 'A7'], or a text."
    literal = as_literal(text)
    return f"Sends the {_KINDS.get(type(ast.literal_eval(literal)), 'value')} {literal}"


_KINDS = {
    str: "text",
    int: "number",
    float: "number",
    bool: "truth value",
    list: "list",
    tuple: "tuple",
    dict: "mapping",
    set: "set",
    type(None): "value",
}


def _value(text: str) -> object:
    """Return the value of a literal; None if the text is none."""
    try:
        return ast.literal_eval(text.strip())
    except (ValueError, SyntaxError, MemoryError, RecursionError, TypeError):
        return None
