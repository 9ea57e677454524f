"""`make test` ends with the names of the tests that failed, and a count (tools/count_tests.py)."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def counted(folder):
    tool = ROOT / "tools/count_tests.py"
    return subprocess.run(
        [sys.executable, str(tool), str(folder)], capture_output=True, text=True, check=False
    )


def test_failures_are_named_and_counted_also_without_an_entry(tmp_path):
    (tmp_path / "rosunit-cell.xml").write_text(
        '<testsuite tests="3" failures="2" errors="0"><testcase classname="Cell" name="fine"/>'
        '<testcase classname="Cell" name="bad"><failure/></testcase>'
        '<testcase classname="Cell" name="left"><skipped/></testcase></testsuite>'
    )
    done = counted(tmp_path)
    assert done.returncode == 1
    assert done.stdout.splitlines() == [
        "failed: rosunit-cell: Cell.bad",
        "failed: rosunit-cell: a failure without an entry",
        "1 passed, 2 failed, 1 skipped",
    ]


def test_the_entry_of_a_whole_rostest_counts_only_when_it_fails(tmp_path):
    whole = '<testsuite tests="1" failures="{0}"><testcase classname="c" name="n">{1}</testcase>'
    file = tmp_path / "rostest-cell.xml"
    file.write_text(whole.format(0, "") + "</testsuite>")
    assert counted(tmp_path).stdout == "0 passed, 0 failed\n"
    file.write_text(whole.format(1, "<failure/>") + "</testsuite>")
    assert counted(tmp_path).stdout == "failed: rostest-cell: c.n\n0 passed, 1 failed\n"


def test_rostests_use_no_subtests():
    """The runner of rosunit does not print why a subtest failed."""
    files = [*ROOT.glob("src/*/test/rostest/*.py"), *ROOT.glob("src/flexbe/*/test/rostest/*.py")]
    assert files
    assert [str(file) for file in files if "subTest" in file.read_text()] == []
