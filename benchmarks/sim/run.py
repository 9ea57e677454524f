#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Measure the simulated physics against theory, and beside MuJoCo: run.py [--mujoco PYTHON] [FILE].

Lines of JSON go to FILE (out/bench/sim.jsonl). What the parts measure: statics.py (sag, buckling),
retention.py (grip, fixtures), speed.py (real-time factor), mujoco_peer.py (MuJoCo's cable plugin).
Exits with 1 when a target is missed. evaluate_abilities.py measures the abilities.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

HERE = Path(__file__).parent
# The rigs are those of the unit tests.
sys.path.insert(0, str(HERE.parents[1] / "src" / "remodel_sim" / "test" / "unit"))

import retention  # noqa: E402
import speed  # noqa: E402
import statics  # noqa: E402
from fingerprint import fingerprint_elsewhere  # noqa: E402
from row import Row, head, report  # noqa: E402


def determinism_rows() -> Iterator[Row]:
    """Yield whether two processes leave the same bits."""
    same = fingerprint_elsewhere() == fingerprint_elsewhere()
    yield Row("same seed and goals in two processes: equal bits", float(same), "", least=1.0)


def speed_rows(mujoco_python: str | None) -> Iterator[Row]:
    """Yield real-time factors, and their ratios to the peer's."""
    own = []
    for row in speed.rows():
        own.append(row.value)
        yield row
    if mujoco_python is None:
        return
    text = subprocess.check_output([mujoco_python, str(HERE / "mujoco_peer.py")], text=True)
    peer = json.loads(text)
    beam = "sag error, w L^3 / EI = 5, N = 24"
    yield Row(f"MuJoCo's cable: {beam}", peer["sag_raw"], "%")
    yield Row(f"MuJoCo's cable: {beam}, clamp half a cell out", peer["sag_shifted"], "%")
    for value, (rate, factor) in zip(own, peer["speed"].items(), strict=True):
        hertz = f"{float(rate):g} Hz"
        yield Row(f"MuJoCo's cable: real-time factor, the same scene, {hertz}", factor, "x")
        yield Row(f"real-time factor over MuJoCo's, {hertz}", value / factor, "", least=1.0)


def main() -> int:
    """Print the table; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", nargs="?", type=Path, default=Path("out/bench/sim.jsonl"))
    parser.add_argument("--mujoco", metavar="PYTHON", help="a Python that has mujoco")
    options = parser.parse_args()
    options.file.parent.mkdir(parents=True, exist_ok=True)
    options.file.write_text("")
    print(head())
    parts = (
        statics.rows(),
        retention.rows(),
        determinism_rows(),
        speed_rows(options.mujoco),
    )
    return 0 if all([report(rows, options.file) for rows in parts]) else 1


if __name__ == "__main__":
    sys.exit(main())
