#!/usr/bin/env python3
"""Print which tests failed, and how many passed, from the result files below a folder.

Tests that `run_failed_again.py` ran a second time are named; they count as they ended then.
"""

import sys
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from pathlib import Path


@dataclass
class Count:
    """How tests ended.

    Attributes:
        failed: a line for each test that failed: its file and its name.
    """

    passed: int = 0
    skipped: int = 0
    failed: list[str] = field(default_factory=list)


def count(folder: Path) -> Count:
    """Return how the tests of all result files ended.

    A rostest writes its tests to `rosunit-*.xml`, and to `rostest-*.xml` one entry for the whole,
    which fails only if the tests could not be run: that one counts when it fails. The head of
    a file may count failures without an entry; they count, too.
    """
    found = Count()
    for path in sorted(folder.rglob("*.xml")):
        root = ElementTree.parse(path).getroot()
        named = 0
        for case in root.iter("testcase"):
            if case.find("failure") is not None or case.find("error") is not None:
                found.failed.append(f"{path.stem}: {case.get('classname')}.{case.get('name')}")
                named += 1
            elif case.find("skipped") is not None:
                found.skipped += 1
            elif not path.name.startswith("rostest-"):
                found.passed += 1
        counted = sum(
            int(suite.get(kind, 0))
            for suite in root.iter("testsuite")
            for kind in ("failures", "errors")
        )
        found.failed += [f"{path.stem}: a failure without an entry"] * (counted - named)
    return found


def main() -> int:
    """Print the count and return the exit code: 0 only if there were tests and none failed."""
    results = Path(sys.argv[1])
    found = count(results)
    first = count(results.with_name(f"{results.name}_first"))
    for line in first.failed:
        print(f"failed while other tests ran, then run again alone: {line}")
    for line in found.failed:
        print(f"failed: {line}")
    skipped = f", {found.skipped} skipped" if found.skipped else ""
    print(f"{found.passed} passed, {len(found.failed)} failed{skipped}")
    return 0 if found.passed and not found.failed else 1


if __name__ == "__main__":
    sys.exit(main())
