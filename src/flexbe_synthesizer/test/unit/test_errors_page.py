"""docs/reference/errors.md: each code has a wrong example that gives it, and a mended one."""

import os
import re
from pathlib import Path

import pytest
from synthesizer_support.errors_page import CODES, EXAMPLES

from flexbe_synthesizer.core.chart.problem import ProblemKind
from flexbe_synthesizer.edge.output_package import OutputPackage
from flexbe_synthesizer.edge.package_path import find_packages, read_library
from flexbe_synthesizer.synthesis import check_files

ROOT = Path(__file__).parents[4]
PACKAGES = (
    "src/flexbe/flexbe_states",
    "src/remodel_msgs",
    "src/remodel_states",
    "src/remodel_behaviors",
)
# The page leaves out the names of all states there are.
NAMES = re.compile(r"allowed: '.*' and \d+ more")
EXPORTS = "<export><flexbe_states/><flexbe_behaviors/></export>"


def complaints(example, mark, folder):
    """Return the lines that the checker reports for an example, as the page shows them."""
    for name, text in example.files(mark).items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        if "/" in name:
            package = folder / path.relative_to(folder).parts[0]
            (package / "package.xml").write_text(
                f"<package><name>{package.name}</name>{EXPORTS}</package>"
            )
    search = os.pathsep.join([str(folder), *(str(ROOT / package) for package in PACKAGES)])
    library, warnings = read_library(find_packages(search)[0])
    assert warnings == ()
    package = OutputPackage("new_behaviors", folder, {})
    files = check_files([str(folder / example.chart)], library, lambda _path: package)
    lines = [str(problem).replace(f"{folder}/", "") for problem in files.problems]
    return [NAMES.sub("allowed: ...", line) for line in lines]


def test_every_code_has_its_row_and_its_example():
    assert [example.slug for example in EXAMPLES] == [code.slug for code in ProblemKind]
    assert list(CODES) == [code.slug for code in ProblemKind]
    for code in ProblemKind:
        assert CODES[code.slug].startswith(f"{code.meaning[0].upper()}{code.meaning[1:]}."), code


@pytest.mark.parametrize("example", EXAMPLES, ids=[example.slug for example in EXAMPLES])
def test_the_wrong_example_gives_its_code_and_the_mended_one_nothing(example, tmp_path):
    (tmp_path / "wrong").mkdir()
    found = complaints(example, "-", tmp_path / "wrong")
    assert found == [*example.messages]
    assert {re.search(r"\[([\w-]+)\]", line)[1] for line in found} == {example.slug}
    (tmp_path / "mended").mkdir()
    assert complaints(example, "+", tmp_path / "mended") == []
