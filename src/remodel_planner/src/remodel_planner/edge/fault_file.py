"""Read the table of faults."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml
from rospkg import RosPack

from remodel_planner.core.recovery.fault import Do, Fault, FaultTable, Level, Severity
from remodel_planner.core.recovery.policy import response_from


def read_faults() -> FaultTable:
    """Return the table of faults of remodel_msgs, whose tests hold it whole."""
    config = Path(RosPack().get_path("remodel_msgs")) / "config"
    codes = {row["name"]: row["code"] for row in _load(config / "error_codes.yaml")}
    return FaultTable([_fault(row, codes) for row in _load(config / "faults.yaml")])


def _fault(row: Mapping[str, Any], codes: Mapping[str, int]) -> Fault:
    return Fault(
        row["fault"],
        row["family"],
        frozenset(codes[name] for name in row["codes"]),
        row.get("after", {}).get("times", 1),
        Severity(row["severity"]),
        row["symptoms"],
        Level(row["first_level"]),
        tuple(response_from(response) for response in row["responses"]),
        row.get("unattended") == Do.STOP.value,
    )


def _load(file: Path) -> Any:  # noqa: ANN401 - YAML
    return yaml.safe_load(file.read_text(encoding="utf-8"))
