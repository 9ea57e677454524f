"""`make test` is green only if everything ran and passed (tools/run_tests.py).

Held against the real pytest, CTest and git, in a workspace of one unit test and one ROS test.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

MAKEFILE = """\
.PHONY: lint unit rostest variants
lint:
\t@{lint}
unit:
\t@PYTEST_DISABLE_PLUGIN_AUTOLOAD=1 pytest -q --junit-xml=build/test_results/unit.xml unit
rostest:
\t@ctest --test-dir build {exclude}
variants:
\t@[ ! -f variants.kept ] || cp variants.kept build/test_results/variants.xml
"""
UNIT = """\
from pathlib import Path
def test_once():
    been = Path(__file__).with_name("been")
    assert been.exists() or {passes} or been.touch()
"""
NAMED = '<launch><test test-name="test_arm_moves" pkg="cell" type="arm_test.py"/></launch>'
WHOLE = '<testsuite tests="1" failures="{0}"><testcase classname="cell" name="whole">{1}</testcase>'
WHOLE += "</testsuite>"
CASE = '<testsuite tests="1"><testcase classname="Arm" name="moves">{0}</testcase></testsuite>'
RESULTS = "build/test_results/cell"


class Workspace:
    """A workspace whose parts end as a test wants it."""

    def __init__(self, folder):
        self.folder = folder
        (folder / "tools").mkdir()
        (folder / "unit").mkdir()
        (folder / "docs/figures").mkdir(parents=True)
        (folder / "build").mkdir()
        (folder / "pytest.ini").write_text("[pytest]\n")
        self.test = folder / "src/cell/test/rostest/arm.test"
        self.test.parent.mkdir(parents=True)
        self.test.write_text(NAMED)
        self.lint("true")
        self.unit(passes=True)
        self.rostest(whole=WHOLE.format(0, ""), case=CASE.format(""))
        self.variants(CASE.format(""))

    def lint(self, command, exclude=""):
        (self.folder / "Makefile").write_text(MAKEFILE.format(lint=command, exclude=exclude))

    def unit(self, passes):
        (self.folder / "unit/test_unit.py").write_text(UNIT.format(passes=passes))

    def rostest(self, whole=None, case=None, status=0, properties="LABELS quick"):
        """Let CTest run a rostest that writes these result files and ends with a status."""
        folder = self.folder / RESULTS
        script = [f"mkdir -p {folder}"]
        for name, text in (("rostest-test_rostest_arm", whole), ("rosunit-test_arm_moves", case)):
            if text is not None:
                (self.folder / f"{name}.kept").write_text(text)
                script.append(f"cp {self.folder}/{name}.kept {folder}/{name}.xml")
        script += [f"exit {status}", f": {self.test} "]
        (self.folder / "build/CTestTestfile.cmake").write_text(
            f'add_test(arm "/bin/sh" "-c" "{" && ".join(script[:-2])}; {"; ".join(script[-2:])}")\n'
            f"set_tests_properties(arm PROPERTIES {properties})\n"
        )

    def variants(self, case):
        """Let a physical test end so as other processors calculate."""
        (self.folder / "variants.kept").write_text(case)

    def run(self, *options):
        return subprocess.run(
            [sys.executable, ROOT / "tools/run_tests.py", *options],
            cwd=self.folder,
            capture_output=True,
            text=True,
            check=False,
        )

    def git(self, *words):
        identity = ("-c", "user.name=a", "-c", "user.email=a@b")
        subprocess.run(["git", *identity, *words], cwd=self.folder, check=True, capture_output=True)


@pytest.fixture
def workspace(tmp_path):
    return Workspace(tmp_path)


def test_all_that_ran_and_passed_is_green(workspace):
    done = workspace.run()
    assert done.stdout.endswith("2 passed, 0 failed\n"), done.stdout
    assert done.returncode == 0


def test_a_test_that_passes_alone_stays_red(workspace):
    workspace.unit(passes=False)
    done = workspace.run()
    assert "passes alone: unit.test_unit.test_once\n" in done.stdout
    assert done.stdout.endswith("1 passed, 2 failed\n"), done.stdout
    assert "failed: unit: unit.test_unit.test_once\n" in done.stdout
    assert done.returncode == 1


def test_a_unit_test_that_fails_hides_no_rostest_that_did_not_run(workspace):
    """A unit test that failed once, and a rostest that only ends with 1, were green."""
    workspace.unit(passes=False)
    workspace.rostest(status=1)
    done = workspace.run()
    assert "failed: cell/arm.test: no result rostest-test_rostest_arm.xml" in done.stdout
    assert "failed: cell/arm.test: no result rosunit-test_arm_moves.xml" in done.stdout
    assert done.returncode == 1


@pytest.mark.parametrize(
    ("ends", "line"),
    [
        ({"whole": WHOLE, "case": CASE, "status": 1}, "rostest: ended with status 2"),
        (
            {"whole": WHOLE},
            "cell/arm.test: no result rosunit-test_arm_moves.xml, so it did not run",
        ),
        (
            {"whole": WHOLE, "case": "<testsuite/>"},
            "cell/arm.test: rosunit-test_arm_moves.xml has no test case",
        ),
        (
            {"whole": "<testsuite>", "case": CASE},
            "cell/arm.test: rostest-test_rostest_arm.xml has no test case",
        ),
    ],
)
def test_a_rostest_that_did_not_run_whole_is_red(workspace, ends, line):
    texts = {k: v.format(0, "") if isinstance(v, str) else v for k, v in ends.items()}
    workspace.rostest(**texts)
    done = workspace.run()
    assert f"failed: {line}\n" in done.stdout, done.stdout
    assert done.returncode == 1


def test_failures_are_named_and_counted_also_without_an_entry(workspace):
    bad = '<testsuite failures="2"><testcase classname="Arm" name="moves">'
    bad += "<failure>Traceback\nAssertionError: 3 != 4</failure></testcase>"
    workspace.rostest(whole=WHOLE.format(1, "<failure/>"), case=f"{bad}</testsuite>")
    done = workspace.run()
    why = "  Traceback\n  AssertionError: 3 != 4\n"
    assert f"failed: rosunit-test_arm_moves: Arm.moves\n{why}" in done.stdout
    assert "failed: rosunit-test_arm_moves: a failure without an entry\n" in done.stdout
    assert "failed: rostest-test_rostest_arm: cell.whole\n" in done.stdout
    assert done.stdout.endswith("1 passed, 3 failed\n")


def test_both_ends_of_a_long_reason_are_printed(workspace):
    reason = "3 != 4\n" + "frame\n" * 500 + "raise error"
    bad = '<testsuite failures="1"><testcase classname="Arm" name="moves">'
    bad += f"<failure>{reason}</failure></testcase></testsuite>"
    workspace.rostest(whole=WHOLE.format(0, ""), case=bad)
    done = workspace.run()
    assert "failed: rosunit-test_arm_moves: Arm.moves\n  3 != 4\n" in done.stdout
    assert "  raise error\n" in done.stdout and done.stdout.count("frame") < 200


def test_a_test_file_that_no_cmakelists_adds_is_red(workspace):
    workspace.test.with_name("leg.test").write_text(NAMED)
    done = workspace.run()
    line = "cell/leg.test: no CMakeLists.txt adds it, so it did not run"
    assert f"failed: {line}\n" in done.stdout
    assert done.returncode == 1


def test_lint_or_a_unit_part_without_tests_is_red(workspace):
    workspace.lint("false")
    (workspace.folder / "unit/test_unit.py").unlink()
    done = workspace.run()
    assert "failed: lint: ended with status 2\n" in done.stdout
    assert "failed: unit: no test passed\n" in done.stdout
    assert done.returncode == 1


def test_a_slow_rostest_must_run_in_the_whole_run_only(workspace):
    workspace.lint("true", exclude="-LE slow")
    workspace.rostest(properties="LABELS slow")
    assert workspace.run().stdout.endswith("1 passed, 0 failed\n")
    assert "no result rostest-test_rostest_arm.xml" in workspace.run("--all").stdout


def test_a_physical_test_that_another_processor_fails_is_red_in_the_whole_run_only(workspace):
    workspace.variants(CASE.format('<failure message="without AVX-512"/>'))
    assert workspace.run().stdout.endswith("2 passed, 0 failed\n")
    done = workspace.run("--all")
    assert "failed: variants: Arm.moves\n" in done.stdout
    assert done.returncode == 1


def test_variants_that_did_not_run_are_red(workspace):
    (workspace.folder / "variants.kept").unlink()
    done = workspace.run("--all")
    assert "failed: variants: no test passed\n" in done.stdout
    assert done.returncode == 1


def test_a_whole_run_is_recorded_and_its_age_is_reported(workspace):
    assert "make test-all: no record of a run\n" in workspace.run().stdout
    workspace.git("init", "-q")
    workspace.git("add", "src")
    workspace.git("commit", "-q", "-m", "one")
    assert workspace.run("--all").returncode == 0
    (line,) = (workspace.folder / "docs/figures/test-all.jsonl").read_text().splitlines()
    row = json.loads(line)
    assert (row["passed"], row["failed"]) == (3, "none")
    assert row["processor"]
    workspace.test.with_name("note").touch()
    (workspace.folder / "src/arm/src").mkdir(parents=True)
    (workspace.folder / "src/arm/src/arm.py").touch()
    workspace.git("add", "src")
    workspace.git("commit", "-q", "-m", "two")
    printed = workspace.run().stdout
    assert f"make test-all: last run 1 commit ago ({row['commit']}, {row['date']}," in printed
    assert "3 passed, failed: none; changed since: arm, cell\n" in printed


def test_rostests_use_no_subtests():
    """The runner of rosunit does not print why a subtest failed."""
    files = [*ROOT.glob("src/*/test/rostest/*.py"), *ROOT.glob("src/flexbe/*/test/rostest/*.py")]
    assert files
    assert [str(file) for file in files if "subTest" in file.read_text()] == []
