"""Read what is uncertain about a cell: config/uncertainty.yaml, and a user's own file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import msgspec
import rospkg
import yaml

from remodel_rehearsal.core.variation import QUANTITIES, Uncertain
from remodel_rehearsal.errors import RehearsalError


def read_uncertainty(own: Path | None = None) -> Mapping[str, Uncertain]:
    """Return the quantities by name, those of a file of the user's own in place of the shipped.

    Raises:
        RehearsalError: if the file cannot be read, or has something else in it.
    """
    shipped = Path(rospkg.RosPack().get_path("remodel_rehearsal")) / "config" / "uncertainty.yaml"
    rows = _rows(shipped)
    for name, changes in (_rows(own) if own is not None else {}).items():
        if name not in QUANTITIES:
            there_are = ", ".join(QUANTITIES)
            raise RehearsalError(f"{own}: no quantity {name}; there are: {there_are}")
        if not isinstance(changes, Mapping):
            raise RehearsalError(f"{own}: {name} is {changes!r}; needed: {{spread: NUMBER, ...}}")
        rows[name] = {**rows[name], **changes}
    found = {}
    for name, row in rows.items():
        try:
            found[name] = msgspec.convert(row, Uncertain)
        except (msgspec.ValidationError, ValueError) as error:
            raise RehearsalError(f"{own or shipped}: {name}: {error}") from error
    return found


def _rows(file: Path) -> dict[str, object]:
    try:
        rows = yaml.safe_load(file.read_text(encoding="utf-8")) or {}
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise RehearsalError(f"{file}: {error}") from error
    if not isinstance(rows, dict):
        raise RehearsalError(f"{file} is no table of quantities: {{NAME: {{spread: NUMBER}}}}")
    return rows
