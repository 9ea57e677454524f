"""The command line of breakpoint."""

from __future__ import annotations

from collections.abc import Sequence


def read_breakpoints(words: Sequence[str]) -> list[str]:
    """Return the paths of the states that are to be breakpoints.

    Raises:
        ValueError: if a word is not a path of a state.
    """
    wrong = [word for word in words if not word.startswith("/") or word.endswith("/")]
    if wrong:
        raise ValueError(
            f"{', '.join(map(repr, wrong))}: a breakpoint is the path of a state, such as "
            "/Container/State; the behavior's name is not part of it"
        )
    return list(dict.fromkeys(words))
