"""Read the table of faults."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from rospkg import RosPack

from flexbe_synthesizer.core import error_names
from remodel_planner.core.recovery.fault import Do, Fault, FaultTable
from remodel_planner.core.recovery.policy import response_from


def read_faults() -> FaultTable:
    """Return the table of faults of remodel_msgs, whose tests hold it whole."""
    config = _config()
    codes = {row["name"]: row["code"] for row in _load(config / "error_codes.yaml")}
    return FaultTable([_fault(row, codes) for row in _load(config / "faults.yaml")])


def read_error_names() -> Mapping[str, tuple[int, ...]]:
    """Return the error codes of remodel_msgs by the names that charts use: codes and classes."""
    return error_names.read_error_names(_load(_config() / "error_codes.yaml"))


def _config() -> Path:
    return Path(RosPack().get_path("remodel_msgs")) / "config"


def _fault(row: Mapping[str, Any], codes: Mapping[str, int]) -> Fault:
    return Fault(
        row["fault"],
        frozenset(codes[name] for name in row["codes"]),
        row.get("after", {}).get("times", 1),
        row["symptoms"],
        tuple(response_from(response) for response in row["responses"]),
        row.get("unattended") == Do.STOP.value,
    )


def _load(file: Path) -> Any:  # noqa: ANN401 - YAML
    return yaml.safe_load(file.read_text(encoding="utf-8"))
