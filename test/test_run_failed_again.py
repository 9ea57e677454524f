"""What failed in `make test` is run once more, alone (tools/run_failed_again.py)."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

ONCE = """
from pathlib import Path
def test_fails_once():
    been = Path(__file__).with_name("been")
    if not been.exists():
        been.touch()
        raise AssertionError
def test_fails_always():
    assert {passes}
def test_passes():
    pass
"""


def run(folder, *command):
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def run_again(folder):
    return run(folder, sys.executable, ROOT / "tools/run_failed_again.py", "results")


def counted(folder):
    return run(folder, sys.executable, ROOT / "tools/count_tests.py", "results")


@pytest.mark.parametrize("passes", [True, False])
def test_a_unit_test_that_fails_once_is_named_and_one_that_fails_twice_fails(tmp_path, passes):
    (tmp_path / "test_once.py").write_text(ONCE.format(passes=passes))
    run(tmp_path, "pytest", "-p", "no:xdist", "--junit-xml=results/unit.xml")
    assert run_again(tmp_path).returncode == 0
    done = counted(tmp_path)
    assert "then run again alone: unit: test_once.test_fails_once" in done.stdout
    assert done.stdout.endswith("3 passed, 0 failed\n" if passes else "2 passed, 1 failed\n")
    assert done.returncode == (0 if passes else 1)


def test_a_rostest_is_found_by_the_names_of_its_results(tmp_path):
    test = tmp_path / "src/cell/test/rostest/arm.test"
    test.parent.mkdir(parents=True)
    test.write_text('<launch><test test-name="test_arm_moves" pkg="cell" type="t.py"/></launch>')
    (tmp_path / "build").mkdir()
    (tmp_path / "build/Makefile").write_text(
        "run_tests_cell_rostest_test_rostest_arm.test:\n"
        '\techo \'<testsuite tests="1"><testcase classname="C" name="n"/></testsuite>\''
        " > ../results/cell/rosunit-test_arm_moves.xml\n"
    )
    (tmp_path / "results/cell").mkdir(parents=True)
    (tmp_path / "results/unit.xml").write_text("<testsuite/>")
    (tmp_path / "results/cell/rosunit-test_arm_moves.xml").write_text(
        '<testsuite failures="1"><testcase classname="C" name="n"><failure/></testcase></testsuite>'
    )
    assert run_again(tmp_path).stdout == "rostest run again: cell/arm.test\n"
    assert counted(tmp_path).stdout.splitlines() == [
        "failed while other tests ran, then run again alone: rosunit-test_arm_moves: C.n",
        "1 passed, 0 failed",
    ]


def test_a_failure_of_many_tests_or_of_none_stays_a_failure(tmp_path):
    assert run_again(tmp_path).returncode == 1
    case = '<testcase classname="C" name="n{}"><failure/></testcase>'
    (tmp_path / "results").mkdir()
    unit = tmp_path / "results/unit.xml"
    unit.write_text("<testsuite/>")
    assert run_again(tmp_path).returncode == 1
    cases = "".join(case.format(index) for index in range(9))
    unit.write_text(f'<testsuite failures="9">{cases}</testsuite>')
    assert run_again(tmp_path).returncode == 1
    assert counted(tmp_path).stdout.endswith("0 passed, 9 failed\n")
