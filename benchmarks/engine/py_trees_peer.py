#!/usr/bin/env python3
# ruff: noqa: T201 - a benchmark prints
"""Time py_trees, with the Python of an environment that has it; prints [us] per behaviour."""

import time

import py_trees

LEAVES = 1_000
REPETITIONS = 9


def main() -> None:
    """Print the least of some repetitions."""
    root = py_trees.composites.Sequence("root", memory=True)
    root.add_children([py_trees.behaviours.Success(f"s{index}") for index in range(LEAVES)])
    times = []
    for _ in range(REPETITIONS):
        begin = time.perf_counter()
        root.tick_once()
        times.append(time.perf_counter() - begin)
    print(min(times) / LEAVES * 1e6)


if __name__ == "__main__":
    main()
