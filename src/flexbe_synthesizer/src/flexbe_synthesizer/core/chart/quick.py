"""Make frozen dataclasses fast: a large chart has tens of thousands of values."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

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
