"""Let only one thread parse Python at a time, where Python needs that.

Until Python 3.11.4, all threads count the depth of their syntax trees in one variable, so that two
which parse at the same time fail with "AST constructor recursion depth mismatch" (CPython issue
106905). Pages, the log and commands of the console parse charts and behaviors on threads of their
own.
"""

from __future__ import annotations

import ast
import sys
import threading
from functools import wraps

_FIXED = (3, 11, 5)


def lock_parsing() -> None:
    """Have `ast.parse`, and what calls it, wait for other threads; call it once, at the start."""
    if sys.version_info >= _FIXED:
        return
    parse, lock = ast.parse, threading.Lock()

    @wraps(parse)
    def parse_alone(*arguments: object, **named: object) -> ast.AST:
        with lock:
            return parse(*arguments, **named)  # type: ignore[call-overload, no-any-return]

    ast.parse = parse_alone  # type: ignore[assignment]
