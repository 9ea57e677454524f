#!/usr/bin/env python3
"""Run the tests that failed once more, alone, when all others have ended.

Tests of running nodes share two cores with other tests; one that fails only then is named by
`count_tests.py` as unstable instead of ending a run of many minutes. The results of the first run
move to FOLDER_first. More than a handful of failed tests is no instability: nothing is run again.

Usage: run_failed_again.py FOLDER (of result files; in a shell that has the workspace's setup)
"""

import re
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

AT_MOST = 8
"""Failed tests of one kind that are run again; more have a common cause."""


def failed(path: Path) -> list[ElementTree.Element]:
    """Return the entries of the tests that failed in a result file."""
    return [
        case
        for case in ElementTree.parse(path).getroot().iter("testcase")
        if case.find("failure") is not None or case.find("error") is not None
    ]


def rostest_files(results: Path, source: Path) -> dict[Path, list[Path]]:
    """Return the .test files below `source` of which a result below `results` failed.

    Each comes with all its result files. A rostest writes `rostest-<path with _>.xml` for the
    whole and `rosunit-<test-name>.xml` for each of its tests, into a folder of its package.
    """
    found = {}
    for test in sorted(source.rglob("test/rostest/*.test")):
        package = test.parents[2].name
        names = [f"rostest-test_rostest_{test.stem}.xml"]
        names += [
            f"rosunit-{name}.xml" for name in re.findall(r'test-name="(\w+)"', test.read_text())
        ]
        files = [path for name in names if (path := results / package / name).exists()]
        if any(failed(path) for path in files):
            found[test] = files
    return found


def without_failed(path: Path) -> int:
    """Remove the entries of failed tests from a result file; return how many."""
    tree = ElementTree.parse(path)
    removed = 0
    for suite in tree.getroot().iter("testsuite"):
        for case in list(suite):
            for kind, total in (("failure", "failures"), ("error", "errors")):
                if case.find(kind) is not None:
                    suite.remove(case)
                    suite.set(total, str(int(suite.get(total, 1)) - 1))
                    removed += 1
                    break
    tree.write(path)
    return removed


def run_unit_tests_again(unit: Path, first: Path) -> None:
    """Run the failed tests of unit.xml again, one after another, into unit_again.xml."""
    shutil.copy2(unit, first)
    print(f"unit tests run again: {without_failed(unit)}", flush=True)
    again = f"--junit-xml={unit.with_name('unit_again.xml')}"
    subprocess.run(["pytest", "--numprocesses=0", "--last-failed", again], check=False)


def run_rostest_again(test: Path, files: list[Path], first: Path) -> None:
    """Run a .test file again, whose result files are `files`."""
    package = test.parents[2].name
    (first / package).mkdir(parents=True, exist_ok=True)
    for path in files:
        shutil.move(path, first / package / path.name)
    print(f"rostest run again: {package}/{test.name}", flush=True)
    target = f"run_tests_{package}_rostest_test_rostest_{test.name}"
    with open("build/rostest_again.log", "a") as log:
        subprocess.run(["make", "-C", "build", target], stdout=log, stderr=log, check=False)


def main() -> int:
    """Run what failed again. Return 1 if too much failed, or something that is no test."""
    results = Path(sys.argv[1])
    unit = results / "unit.xml"
    if not unit.exists():
        return 1
    first = results.with_name(f"{results.name}_first")
    shutil.rmtree(first, ignore_errors=True)
    first.mkdir(parents=True)
    units, rostests = len(failed(unit)), rostest_files(results, Path("src"))
    if units + len(rostests) == 0 or max(units, len(rostests)) > AT_MOST:
        return 1
    if units:
        run_unit_tests_again(unit, first)
    for test, files in rostests.items():
        run_rostest_again(test, files, first)
    return 0


if __name__ == "__main__":
    sys.exit(main())
