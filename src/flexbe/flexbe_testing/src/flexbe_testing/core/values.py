"""Values of a test case: as written, from a bag, or functions.

    !/topic          the next message of that topic in the case's bag
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


def value_of(written: Any, message: Callable[[str], Any]) -> Any:  # noqa: ANN401
    """Return what a value of a test case stands for.

    Args:
        written: as it is in the case.
        message: returns the next message of a topic.

    Raises:
        CaseError: if it is a function that is no Python.
    """
    if isinstance(written, dict):
        return {key: value_of(value, message) for key, value in written.items()}
    if isinstance(written, list):
        return [value_of(value, message) for value in written]
    if not isinstance(written, str):
        return written
    if written.startswith(_FROM_BAG):
        return message(written.removeprefix(_FROM_BAG))
    if written.lstrip().startswith(_FUNCTION):
        return _function(written.strip())
    return written


def _function(text: str) -> Any:  # noqa: ANN401
    try:
        return eval(text, {})
    except SyntaxError as error:
        raise CaseError(f"{text!r} is no Python function: {error}") from error
