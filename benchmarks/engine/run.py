#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Measure the engine: run.py [--py-trees PYTHON] [FILE]. Ratios are to the floor of the same run.

Lines of JSON go to FILE (out/bench/engine.jsonl). What the parts measure: transitions.py (no ROS),
latencies.py (the engine node from outside), endurance.py (memory and load over a long time).
"""

from __future__ import annotations

import argparse
import subprocess
from collections.abc import Iterator
from pathlib import Path

import endurance
import latencies
import transitions
from transitions import Row, report_all

HERE = Path(__file__).parent


def py_trees_rows(python: str) -> Iterator[Row]:
    """Yield the peer's figure."""
    text = subprocess.check_output([python, str(HERE / "py_trees_peer.py")], text=True)
    yield Row("peer: py_trees, one behaviour of 1,000 in a sequence", float(text), "us")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", nargs="?", type=Path, default=Path("out/bench/engine.jsonl"))
    parser.add_argument("--py-trees", metavar="PYTHON", help="a Python that has py_trees")
    options = parser.parse_args()
    options.file.parent.mkdir(parents=True, exist_ok=True)
    options.file.write_text("")
    print(f"{'':<58}{'figure':>10} {'':<7}{'at most':>9} {'':<7}{'of floor':>9}")
    report_all(transitions.rows(), options.file)
    if options.py_trees:
        report_all(py_trees_rows(options.py_trees), options.file)
    with latencies.workplace():
        report_all(latencies.rows(), options.file)
        report_all(endurance.rows(), options.file)


if __name__ == "__main__":
    main()
