#!/usr/bin/env python3
"""Run lint, unit tests and ROS tests, and print which failed and how many passed.

Usage: run_tests.py [--all]    (in the workspace, in a shell that has its setup)

Each part is a make target of its own and keeps its own status. The result is green only if every
part ended well, every test case passed, and every ROS test that the source tree names has a
result. What failed is run once more, alone, as a diagnosis: it prints whether the test fails alone,
too, and the result stays red.

With `--all` the tests marked slow run, too, and the physical tests as other processors calculate; a
record of the run is appended to
docs/figures/test-all.jsonl. Without it, the last record is reported: its age in commits, and the
packages that have changed since.
"""

import argparse
import json
import platform
import re
import shutil
import subprocess
import sys
import textwrap
import time
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path

RESULTS = Path("build/test_results")
ALONE = Path("build/test_results_alone.xml")
RECORDS = Path("docs/figures/test-all.jsonl")
PARTS = {"quick": ("lint", "unit", "rostest"), "all": ("lint", "unit", "rostest", "variants")}
VARIANTS = RESULTS / "variants.xml"
AT_MOST_ALONE = 8
"""Failed tests that are run again, alone; more have a common cause."""
REASON = 400
"""Characters of a failure's reason that are printed, from its beginning and from its end."""


@dataclass
class Count:
    """How test cases ended.

    Attributes:
        failed: a line for each that failed, and for each that has no result.
        reasons: for lines of `failed`, why.
    """

    passed: int = 0
    skipped: int = 0
    failed: list[str] = field(default_factory=list)
    reasons: dict[str, str] = field(default_factory=dict)

    def __add__(self, other: "Count") -> "Count":
        """Return both together."""
        return Count(
            self.passed + other.passed,
            self.skipped + other.skipped,
            self.failed + other.failed,
            self.reasons | other.reasons,
        )


def make(part: str, tier: str) -> int:
    """Run a part; return its exit status."""
    words = ["make", "--no-print-directory", "BUILT=1", f"TIER={tier}", part]
    return subprocess.run(words, check=False).returncode


def read(path: Path) -> ElementTree.Element:
    """Return a result file; one without a test case if its runner was ended while it wrote."""
    try:
        return ElementTree.parse(path).getroot()
    except ElementTree.ParseError:
        return ElementTree.Element("testsuite")


def shortened(reason: str) -> str:
    """Return both ends of a reason: what was wrong may stand before a traceback or after it."""
    is_short = len(reason) <= 2 * REASON
    return reason if is_short else f"{reason[:REASON]}\n[...]\n{reason[-REASON:]}"


def count_cases(path: Path) -> Count:
    """Return how the test cases of a result file ended.

    A rostest writes its cases to `rosunit-*.xml`, and to `rostest-*.xml` one entry for the whole,
    which fails only if the cases could not be run: that one counts when it fails. The head of a
    file may count failures without an entry; they count, too.
    """
    root, found = read(path), Count()
    for case in root.iter("testcase"):
        if ended := [end for end in case if end.tag in ("failure", "error")]:
            line = f"{path.stem}: {case.get('classname')}.{case.get('name')}"
            reason = ended[0].get("message") or (ended[0].text or "").strip()
            found.failed.append(line)
            found.reasons[line] = shortened(reason)
        elif case.find("skipped") is not None:
            found.skipped += 1
        elif not path.name.startswith("rostest-"):
            found.passed += 1
    counted = sum(
        int(suite.get(kind, 0))
        for suite in root.iter("testsuite")
        for kind in ("failures", "errors")
    )
    found.failed += [f"{path.stem}: a failure without an entry"] * (counted - len(found.failed))
    return found


def ros_tests(source: Path) -> list[Path]:
    """Return the ROS tests of the source tree: the .test files in folders `test/rostest`."""
    return sorted(source.rglob("test/rostest/*.test"))


def slow_ros_tests() -> tuple[set[Path], set[Path]]:
    """Return the .test files that CTest runs, and those of them that it knows as slow."""
    listed = subprocess.run(
        ["ctest", "--test-dir", "build", "--show-only=json-v1"],
        check=True,
        capture_output=True,
        text=True,
    )
    known, slow = set(), set()
    for test in json.loads(listed.stdout)["tests"]:
        if file := re.search(r"(\S+\.test)\s*$", test.get("command", [""])[-1]):
            known.add(Path(file[1]).resolve())
            labels = [p["value"] for p in test["properties"] if p["name"] == "LABELS"]
            if labels and "slow" in labels[0]:
                slow.add(Path(file[1]).resolve())
    return known, slow


def without_result(tests: list[Path], known: set[Path], results: Path) -> list[str]:
    """Return a line for each ROS test, and each test named in one, that has no result."""
    missing = []
    for test in tests:
        package = test.parents[2].name
        if test.resolve() not in known:
            missing.append(f"{package}/{test.name}: no CMakeLists.txt adds it, so it did not run")
            continue
        names = [f"rostest-test_rostest_{test.stem}"]
        names += [f"rosunit-{name}" for name in re.findall(r'test-name="(\w+)"', test.read_text())]
        for name in names:
            path = results / package / f"{name}.xml"
            if not path.is_file():
                missing.append(f"{package}/{test.name}: no result {path.name}, so it did not run")
            elif read(path).find(".//testcase") is None:
                missing.append(f"{package}/{test.name}: {path.name} has no test case")
    return missing


def judge(status: dict[str, int], tier: str) -> Count:
    """Return the count of all result files, with a failure for whatever did not run."""
    unit_file = RESULTS / "unit.xml"
    unit = count_cases(unit_file) if unit_file.is_file() else Count()
    if not unit.passed:
        unit.failed.append("unit: no test passed")
    ros = Count()
    for path in sorted(RESULTS.glob("*/*.xml")):
        ros += count_cases(path)
    known, slow = slow_ros_tests()
    in_tier = [
        test for test in ros_tests(Path("src")) if tier == "all" or test.resolve() not in slow
    ]
    ros.failed += without_result(in_tier, known, RESULTS)
    parts = {"lint": Count(), "unit": unit, "rostest": ros}
    if tier == "all":
        parts["variants"] = count_cases(VARIANTS) if VARIANTS.is_file() else Count()
        if not parts["variants"].passed:
            parts["variants"].failed.append("variants: no test passed")
    for part, code in status.items():
        if code and not parts[part].failed:
            parts[part].failed.append(f"{part}: ended with status {code}")
    return sum(parts.values(), Count())


def run_alone(status: dict[str, int]) -> None:
    """Run the failed tests again, one after another, and print how they end then."""
    print("Run again, alone, as a diagnosis; the result stays red:", flush=True)
    if status["unit"]:
        words = ["pytest", "--numprocesses=0", "--last-failed", "--last-failed-no-failures=none"]
        words += ["--tb=no", f"--junit-xml={ALONE}"]
        subprocess.run(words, check=False, stdout=subprocess.DEVNULL)
        if ALONE.is_file():
            for case in read(ALONE).iter("testcase"):
                bad = case.find("failure") is not None or case.find("error") is not None
                how = "fails alone, too" if bad else "passes alone"
                print(f"{how}: {case.get('classname')}.{case.get('name')}")
    if status["rostest"]:
        subprocess.run(["ctest", "--test-dir", "build", "--rerun-failed"], check=False)


def git(*words: str) -> str:
    """Return what git prints, or nothing where there is no repository."""
    done = subprocess.run(["git", *words], check=False, capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else ""


def processor() -> str:
    """Return the processor's name and the widest of its vector units, which libm chooses by."""
    text = Path("/proc/cpuinfo").read_text()
    name = re.search(r"^model name\s*: (.*)$", text, re.MULTILINE)
    flags = re.search(r"^flags\s*: (.*)$", text, re.MULTILINE)
    units = [unit for unit in ("avx512f", "avx2", "fma") if flags and unit in flags[1].split()]
    return " ".join([name[1] if name else platform.machine(), *units])


def record(found: Count, seconds: float) -> None:
    """Append a record of a whole run."""
    changed = "" if not git("status", "--porcelain", "--", "src", "test") else ", changed"
    row = {
        "commit": (git("rev-parse", "--short=8", "HEAD") or "none") + changed,
        "date": date.today().isoformat(),
        "processor": processor(),
        "minutes": round(seconds / 60),
        "passed": found.passed,
        "failed": "; ".join(found.failed) or "none",
    }
    with RECORDS.open("a", encoding="utf-8") as file:
        file.write(json.dumps(row) + "\n")


def age_of_record() -> str:
    """Return a sentence on the last record: its age in commits, and what has changed since."""
    lines = RECORDS.read_text(encoding="utf-8").splitlines() if RECORDS.is_file() else []
    if not lines:
        return "make test-all: no record of a run"
    last = json.loads(lines[-1])
    commit = last["commit"].split(",")[0]
    commits = git("rev-list", "--count", f"{commit}..HEAD")
    if not commits:
        return f"make test-all: last run at {last['commit']}, which this checkout does not have"
    files = git("diff", "--name-only", commit, "--", "src").splitlines()
    packages = {
        parts[2] if parts[1] == "flexbe" else parts[1]
        for parts in (file.split("/") for file in files)
        if len(parts) > 3
    }
    changed = ", ".join(sorted(packages)) or "no package"
    age = f"{commits} commit{'' if commits == '1' else 's'} ago"
    return (
        f"make test-all: last run {age} ({last['commit']}, {last['date']}, {last['processor']}): "
        f"{last['passed']} passed, failed: {last['failed']}; "
        f"changed since: {changed}"
    )


def main() -> int:
    """Run all parts; return 0 only if there were tests and nothing failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--all", action="store_true", help="run the tests marked slow, too")
    tier = "all" if parser.parse_args().all else "quick"
    shutil.rmtree(RESULTS, ignore_errors=True)
    ALONE.unlink(missing_ok=True)
    begun = time.monotonic()
    status = {}
    for part in PARTS[tier]:
        started = time.monotonic()
        status[part] = make(part, tier)
        print(f"{part}: {time.monotonic() - started:.0f} s", flush=True)
    found = judge(status, tier)
    seconds = time.monotonic() - begun
    if found.failed and len(found.failed) <= AT_MOST_ALONE:
        run_alone(status)
    for line in found.failed:
        print(f"failed: {line}")
        if reason := found.reasons.get(line):
            print(textwrap.indent(reason, "  "))
    if tier == "all":
        record(found, seconds)
    else:
        print(age_of_record())
    print(f"{seconds / 60:.1f} minutes")
    skipped = f", {found.skipped} skipped" if found.skipped else ""
    print(f"{found.passed} passed, {len(found.failed)} failed{skipped}")
    return 1 if found.failed else 0


if __name__ == "__main__":
    sys.exit(main())
