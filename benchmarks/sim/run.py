#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Measure the simulated physics against theory, and beside others: run.py [--peers PYTHON] [FILE].

Lines of JSON go to FILE (out/bench/sim.jsonl). What the parts measure: statics.py (sag, buckling),
retention.py (grip, fixtures), speed.py (real-time factor), laid_board.py (the same while an end is
inserted over laid wires), long_wires.py (wires of 1 to 3 m), mujoco_peer.py (MuJoCo's cable
plugin), newton_peer.py (Newton's VBD cable).
Exits with 1 when a target is missed. evaluate_abilities.py measures the abilities.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from subprocess import DEVNULL

HERE = Path(__file__).parent
# The rigs are those of the unit tests.
for folder in ("remodel_sim/test/unit", "remodel_work/test"):
    sys.path.insert(0, str(HERE.parents[1] / "src" / folder))

import laid_board  # noqa: E402
import long_wires  # noqa: E402
import retention  # noqa: E402
import speed  # noqa: E402
import statics  # noqa: E402
from fingerprint import fingerprint_elsewhere  # noqa: E402
from row import Row, head, report  # noqa: E402


def determinism_rows() -> Iterator[Row]:
    """Yield whether two processes leave the same bits."""
    same = fingerprint_elsewhere() == fingerprint_elsewhere()
    yield Row("same seed and goals in two processes: equal bits", float(same), "", least=1.0)


def speed_rows(mujoco: dict | None) -> Iterator[Row]:
    """Yield real-time factors, and their ratios to MuJoCo's; its figures if there are any."""
    own = []
    for row in speed.rows():
        own.append(row.value)
        yield row
    if mujoco is None:
        return
    beam = "sag error, w L^3 / EI = 5, N = 24"
    yield Row(f"MuJoCo's cable: {beam}", mujoco["sag_raw"], "%")
    yield Row(f"MuJoCo's cable: {beam}, clamp half a cell out", mujoco["sag_shifted"], "%")
    for value, (rate, factor) in zip(own, mujoco["speed"].items(), strict=True):
        hertz = f"{float(rate):g} Hz"
        yield Row(f"MuJoCo's cable: real-time factor, the same scene, {hertz}", factor, "x")
        yield Row(f"real-time factor over MuJoCo's, {hertz}", value / factor, "", least=1.0)


def figures_of(python: str | None, name: str) -> dict | None:
    """Return what another simulator's program prints; None, and a line, where it is not installed.

    Raises:
        subprocess.CalledProcessError: the program failed.
    """
    found = python and not subprocess.call([python, "-c", f"import {name}"], stderr=DEVNULL)
    if not found:
        print(f"{name} is not installed in {python}: its rows are left out")
        return None
    wires = json.dumps([asdict(wire) for wire in long_wires.peer_wires()])
    text = subprocess.check_output([python, str(HERE / f"{name}_peer.py"), wires], text=True)
    return json.loads(text.splitlines()[-1])  # Newton's compiler prints too


def main() -> int:
    """Print the table; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", nargs="?", type=Path, default=Path("out/bench/sim.jsonl"))
    parser.add_argument("--peers", metavar="PYTHON", help="a Python that has mujoco and newton")
    options = parser.parse_args()
    options.file.parent.mkdir(parents=True, exist_ok=True)
    options.file.write_text("")
    mujoco, newton = (figures_of(options.peers, name) for name in ("mujoco", "newton"))
    print(head())
    parts = (
        statics.rows(),
        retention.rows(),
        determinism_rows(),
        speed_rows(mujoco),
        laid_board.rows(),
        long_wires.rows(),
        long_wires.peer_rows("MuJoCo's cable", mujoco),
        long_wires.peer_rows("Newton's VBD cable", newton),
    )
    return 0 if all([report(rows, options.file) for rows in parts]) else 1


if __name__ == "__main__":
    sys.exit(main())
