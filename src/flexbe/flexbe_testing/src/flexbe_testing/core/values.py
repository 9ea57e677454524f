"""Values of a test case: as written, from a bag, or functions.

    /topic           the next message of that topic in the case's bag; without a bag, this text
    !/topic          the same, and an error without a bag
    //text           the text `/text`
    None             None
    lambda x: x + 1  that function

A test case names any module to import, so it is trusted as code is; that is why functions in it may
be evaluated. Test cases come from files only, never from a message or a parameter.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from flexbe_testing.errors import CaseError

_FROM_BAG = "!"
_FUNCTION = "lambda"


def value_of(written: object, message: Callable[[str], object], has_bag: bool = False) -> Any:  # noqa: ANN401 - whatever the tested state takes
    """Return what a value of a test case stands for.

    Args:
        written: as it is in the case.
        message: returns the next message of a topic.
        has_bag: whether the case names a bag.

    Raises:
        CaseError: if it is a function that is not Python.
    """
    if isinstance(written, dict):
        return {key: value_of(value, message, has_bag) for key, value in written.items()}
    if isinstance(written, list | tuple):
        return type(written)([value_of(value, message, has_bag) for value in written])
    return _text(written, message, has_bag) if isinstance(written, str) else written


def _text(written: str, message: Callable[[str], object], has_bag: bool) -> object:
    if written == "None":
        return None
    if written.startswith("//"):
        return written[1:]
    if written.startswith(_FROM_BAG + "/") or (has_bag and written.startswith("/")):
        return message(written.removeprefix(_FROM_BAG))
    if written.lstrip().startswith(_FUNCTION):
        return _function(written.strip())
    return written


def _function(text: str) -> object:
    try:
        return eval(text, {})
    except SyntaxError as error:
        raise CaseError(f"{text!r} is not a Python function: {error}") from error
