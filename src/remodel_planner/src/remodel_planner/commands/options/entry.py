"""Run a command as a process."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import NoReturn

# What a shell reports of a process that SIGPIPE has ended.
_CLOSED_PIPE = 128 + 13


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
