#!/usr/bin/env python3
"""Print how many tests passed and failed, from the result files below a folder."""

import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path


def count(folder: Path) -> tuple[int, int, int]:
    """Return the number of passed, failed and skipped tests.

    A rostest writes its tests to `rosunit-*.xml`, and to `rostest-*.xml` one entry for the whole,
    which fails only if the tests could not be run: that one counts when it fails.
    """
    passed = failed = skipped = 0
    for path in sorted(folder.rglob("*.xml")):
        whole = path.name.startswith("rostest-")
        for case in ElementTree.parse(path).getroot().iter("testcase"):
            if case.find("failure") is not None or case.find("error") is not None:
                failed += 1
            elif case.find("skipped") is not None:
                skipped += 1
            elif not whole:
                passed += 1
    return passed, failed, skipped


def main() -> int:
    """Print the count and return the exit code: 0 only if there were tests and none failed."""
    passed, failed, skipped = count(Path(sys.argv[1]))
    print(f"{passed} passed, {failed} failed" + (f", {skipped} skipped" if skipped else ""))
    return 0 if passed and not failed else 1


if __name__ == "__main__":
    sys.exit(main())
