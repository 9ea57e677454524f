"""Read the run log of a behavior."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from flexbe_widget.errors import LogError


def read_log(name: str) -> list[dict[str, Any]]:
    """Return the lines of a run log; the last may be incomplete if its engine was killed.

    Raises:
        LogError: if it cannot be read, or is not a run log.
    """
    try:
        texts = Path(name).expanduser().read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise LogError(f"cannot read {name}: {error}") from error
    lines = []
    for number, text in enumerate(texts, 1):
        try:
            (line,) = yaml.safe_load(text)
        except (yaml.YAMLError, ValueError, TypeError) as error:
            if number == len(texts):
                break
            raise LogError(f"{name}:{number}: not a line of a run log: {text:.80}") from error
        if isinstance(line, dict):
            lines.append(line)
    return lines
