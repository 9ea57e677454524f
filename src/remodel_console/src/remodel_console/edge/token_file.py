"""The file with the tokens that grant access, which no command line and no log shows."""

from __future__ import annotations

import json
import os
import secrets
from pathlib import Path

_NAMES = ("operator", "observer")
_OF_OTHERS = 0o077  # bits of a file's mode


def read_tokens(path: Path) -> tuple[str, str]:
    """Return the tokens of operators and of observers; the file is written if it is not there.

    The file is a JSON object such as {"operator": "...", "observer": "..."}; without the second,
    or with an empty one, there is no read-only access.

    Raises:
        ValueError: if it is no such file, or other users can read it.
        OSError: if it cannot be read or written.
    """
    if not path.exists():
        _write(path)
    if path.stat().st_mode & _OF_OTHERS:
        raise ValueError(f"other users can read {path}; forbid that: chmod 600 {path}")
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(
            f"{path} is no JSON: {error}; delete it to have it written again"
        ) from error
    is_right = isinstance(found, dict) and set(found) <= set(_NAMES) and found.get("operator")
    if not is_right or not all(isinstance(token, str) for token in found.values()):
        example = '{"operator": "TOKEN", "observer": "TOKEN"}'
        raise ValueError(f"{path} holds no tokens; write {example}, or delete it")
    return found["operator"], found.get("observer", "")


def _write(path: Path) -> None:
    """Write a file with new tokens that only its owner can read."""
    path.parent.mkdir(parents=True, exist_ok=True)
    tokens = {name: secrets.token_urlsafe(24) for name in _NAMES}
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
        file.write(json.dumps(tokens, indent=2) + "\n")
