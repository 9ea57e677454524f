#!/usr/bin/env python3
"""Run the physical tests, also as other processors and other beginnings have them.

physics.py [--disturbed [--results FILE]] [--jobs N] [ARGUMENT ...]; the workspace must be sourced.
The arguments go to pytest, for example `-k lay_wire` or `-m "physics and not slow"`. With
--disturbed the tests run several times: as processors of other kinds calculate, and with arms and
wires that begin 1e-9 m and 1e-9 rad beside their places, under five seeds. Each test that did not
hold in all runs is printed with the runs in which it failed, then the count, and the processor;
FILE gets the same in JUnit's format. Exits with 1 if there is any.

What a processor can do decides which sine of libm, which loops of numpy and which kernels of
OpenBLAS are used, and with them the last bits of every result.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from numpy.core._multiarray_umath import __cpu_dispatch__, __cpu_features__

ROOT = Path(__file__).parents[1]
TESTS = ("src/remodel_sim/test/unit", "src/remodel_rehearsal/test/unit")
SEEDS = range(1, 6)
# What processors of earlier kinds do not have, as glibc calls it; it ignores what it does not know.
AVX512 = ("AVX512F", "AVX512CD", "AVX512BW", "AVX512DQ", "AVX512VL")
AVX2 = ("AVX2", "FMA", "AVX2_Usable", "FMA_Usable", "FMA4")


@dataclass(frozen=True)
class Run:
    """One run of the tests.

    Attributes:
        processor: which kind is imitated.
        seed: of the disturbance; None: nothing is disturbed.
    """

    processor: str
    seed: int | None = None

    @property
    def name(self) -> str:
        """What is printed of it."""
        return self.processor if self.seed is None else f"{self.processor}, seed {self.seed}"


def processors() -> dict[str, dict[str, str]]:
    """Return the environment for each kind of processor, by its name."""
    loops = [name for name in __cpu_dispatch__ if __cpu_features__[name]]
    wide = [name for name in loops if name.startswith("AVX512")]
    return {
        "native": {},
        "without AVX-512": _environment(AVX512, wide, "Haswell"),
        "without AVX2 and FMA": _environment((*AVX512, *AVX2), loops, "Nehalem"),
    }


def _environment(libm: Sequence[str], numpy: Sequence[str], blas: str) -> dict[str, str]:
    return {
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=" + ",".join(f"-{name}" for name in libm),
        "NPY_DISABLE_CPU_FEATURES": " ".join(numpy),
        "OPENBLAS_CORETYPE": blas,
    }


def planned(kinds: Sequence[str]) -> list[Run]:
    """Return the runs: each processor, and each seed on one of them in turn."""
    disturbed = [Run(kinds[i % len(kinds)], seed) for i, seed in enumerate(SEEDS)]
    return [*map(Run, kinds), *disturbed]


def run(one: Run, environment: Mapping[str, str], arguments: Sequence[str]) -> dict[str, bool]:
    """Run the tests once; return whether each held, by its name."""
    with tempfile.TemporaryDirectory() as folder:
        results = Path(folder) / "results.xml"
        options = [] if one.seed is None else ["--disturb", str(one.seed)]
        command = [*pytest(arguments), *options, f"--junit-xml={results}"]
        done = subprocess.run(
            command, cwd=ROOT, env=os.environ | environment, capture_output=True, text=True
        )
        if done.returncode not in (0, 1):
            raise SystemExit(f"{one.name}: pytest ended with {done.returncode}\n{done.stdout}")
        cases = ElementTree.parse(results).iter("testcase")
        held = {
            f"{case.get('classname', '').rpartition('.')[2]}::{case.get('name')}": not (
                case.findall("failure") or case.findall("error")
            )
            for case in cases
        }
    print(f"{one.name}: {sum(held.values())} of {len(held)} held", flush=True)
    return held


def pytest(arguments: Sequence[str]) -> list[str]:
    """Return pytest's command."""
    return [sys.executable, "-m", "pytest", "-m", "physics", *TESTS, *arguments]


def processor() -> str:
    """Return the name of the machine's processor."""
    lines = Path("/proc/cpuinfo").read_text().splitlines()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    widest = next((n for n in ("AVX512F", "AVX2") if __cpu_features__[n]), "no AVX2")
    return f"{names[0] if names else 'unknown'} ({widest})"


def run_all(arguments: Sequence[str], jobs: int, file: Path | None) -> int:
    """Run the tests in all ways; print those that did not hold in all, return how many."""
    kinds = processors()
    runs = planned(list(kinds))
    with ThreadPoolExecutor(jobs) as pool:
        results = list(pool.map(lambda one: run(one, kinds[one.processor], arguments), runs))
    failed: dict[str, list[str]] = defaultdict(list)
    for one, held in zip(runs, results, strict=True):
        for test, is_held in held.items():
            if not is_held:
                failed[test].append(one.name)
    for test, where in sorted(failed.items()):
        print(f"{test}: failed {len(where)} of {len(runs)}: {'; '.join(where)}")
    tests = set().union(*results)
    if file:
        write_results(file, tests, failed)
    print(f"{len(tests) - len(failed)} of {len(tests)} tests held in all {len(runs)} runs")
    return len(failed)


def write_results(file: Path, tests: Iterable[str], failed: Mapping[str, Sequence[str]]) -> None:
    """Write a test case for each test, failed with the runs in which it did not hold."""
    suite = ElementTree.Element("testsuite", tests=str(len(set(tests))), failures=str(len(failed)))
    for test in sorted(tests):
        where, _, name = test.partition("::")
        case = ElementTree.SubElement(suite, "testcase", classname=where, name=name)
        if test in failed:
            ElementTree.SubElement(case, "failure", message="; ".join(failed[test]))
    file.parent.mkdir(parents=True, exist_ok=True)
    ElementTree.ElementTree(suite).write(file)


def main() -> int:
    """Run the tests."""
    parser = argparse.ArgumentParser(description=__doc__, allow_abbrev=False)
    parser.add_argument("--disturbed", action="store_true")
    parser.add_argument("--results", type=Path)
    parser.add_argument("--jobs", type=int, default=1, help="runs at once")
    options, arguments = parser.parse_known_args()
    if options.disturbed:
        failed = run_all(arguments, options.jobs, options.results)
    else:
        failed = subprocess.run(pytest(arguments), cwd=ROOT).returncode
    print(f"processor: {processor()}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
