"""Request a behavior from the engine."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from pathlib import Path

from flexbe_msgs.msg import BehaviorSelection

from flexbe_core import BehaviorLibrary
from flexbe_core.engine.events import checksum
from flexbe_core.engine.supervision import UNSUPERVISED
from flexbe_widget.edge.files import resolved
from flexbe_widget.errors import RequestError

Pairs = Sequence[tuple[str, str]]


class UnknownBehaviorError(RequestError):
    """There is no behavior with the requested name."""


def start_request(
    library: BehaviorLibrary,
    name: str,
    parameters: Pairs = (),
    inputs: Pairs = (),
    autonomy_level: int = UNSUPERVISED,
) -> BehaviorSelection:
    """Return the message that requests a behavior from the engine.

    Args:
        library: where to find it.
        name: its display name.
        parameters: (key, value) pairs.
        inputs: (key, value) pairs; values are Python literals. Values of both that begin with
            file:// are read from files.
        autonomy_level: 255 to run without supervision.

    Raises:
        UnknownBehaviorError: if there is no such behavior.
        RequestError: if its source, or a file that a value names, cannot be read.
    """
    behavior_id, _ = library.find_behavior(name)
    if behavior_id is None:
        raise UnknownBehaviorError(unknown_behavior(name, library.names()))
    path = library.get_sourcecode_filepath(behavior_id)
    if path is None:
        raise RequestError(f"behavior {name!r} has a manifest, but no source file")
    try:
        text = Path(path).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RequestError(f"cannot read {path}: {error}") from error
    return BehaviorSelection(
        behavior_id=behavior_id,
        behavior_checksum=checksum(text),
        autonomy_level=autonomy_level,
        arg_keys=[key for key, _ in parameters],
        arg_values=[resolved(value) for _, value in parameters],
        input_keys=[key for key, _ in inputs],
        input_values=[resolved(value) for _, value in inputs],
    )


# Suggest the names that were perhaps meant


# How alike (0 to 1) a name must be to be offered.
_ALIKE = 0.5


def unknown_behavior(name: str, known: Sequence[str]) -> str:
    """Return the message for a request for a behavior that does not exist."""
    if not known:
        return (
            f"unknown behavior {name!r}: there are no behaviors on the ROS package path; "
            "is the workspace sourced?"
        )
    by_lower = {candidate.lower(): candidate for candidate in known}
    near = difflib.get_close_matches(name.lower(), list(by_lower), n=3, cutoff=_ALIKE)
    if near:
        return f"unknown behavior {name!r}; near it: {_quoted(by_lower[n] for n in near)}"
    return f"unknown behavior {name!r}; there are: {_quoted(known)}"


def _quoted(names: Iterable[str]) -> str:
    return ", ".join(f"'{name}'" for name in names)
