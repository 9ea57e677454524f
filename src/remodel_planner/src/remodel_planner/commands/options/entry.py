"""Run a command as a process, and turn an error of the planner into its exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import wraps
from typing import NoReturn

from remodel_production.errors import PlannerError

Main = Callable[[list[str] | None], int]

# What a shell reports of a process that SIGPIPE has ended.
_CLOSED_PIPE = 128 + 13
_REFUSED = 1


def run(main: Callable[[], int]) -> NoReturn:
    """Run a command, and exit with its code; quietly if the reader of its output has closed it."""
    try:
        try:
            code = main()
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        # Python flushes once more at exit, into nothing.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = _CLOSED_PIPE
    sys.exit(code)


def refuses(name: str) -> Callable[[Main], Main]:
    """Let a command print an error of the planner as a line, and return 1 then, as all commands.

    Args:
        name: of the command, which the line begins with.
    """

    def decorate(main: Main) -> Main:
        @wraps(main)
        def guarded(arguments: list[str] | None = None) -> int:
            try:
                return main(arguments)
            except PlannerError as error:
                print(f"{name}: {error}", file=sys.stderr)
                return _REFUSED

        return guarded

    return decorate
