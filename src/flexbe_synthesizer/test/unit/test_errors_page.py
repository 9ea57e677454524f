"""docs/reference/errors.md: each code has a wrong example that gives it, and a mended one."""

import os
import re
from pathlib import Path

import pytest

from flexbe_synthesizer.core.chart.problem import ProblemKind, Severity
from flexbe_synthesizer.edge.output_package import OutputPackage
from flexbe_synthesizer.edge.package_path import find_packages, read_library
from flexbe_synthesizer.synthesis import check_files

ROOT = Path(__file__).parents[4]
PAGE = (ROOT / "docs" / "reference" / "errors.md").read_text()
SECTIONS = re.findall(r"^## ([\w-]+)\n(.*?)(?=^## |\Z)", PAGE, re.MULTILINE | re.DOTALL)
PACKAGES = (
    "src/flexbe/flexbe_states",
    "src/remodel_msgs",
    "src/remodel_states",
    "src/remodel_behaviors",
)
# The page leaves out the names of all states there are.
NAMES = re.compile(r"allowed: '.*' and \d+ more")
EXPORTS = "<export><flexbe_states/><flexbe_behaviors/></export>"


def blocks(section, language):
    return re.findall(rf"^```{language}\n(.*?)^```$", section, re.MULTILINE | re.DOTALL)


def example(section, mark):
    """Return the example's text: its lines without the other mark, without their first letter."""
    (diff,) = blocks(section, "diff")
    return "".join(line[1:] + "\n" for line in diff.splitlines() if line[0] in (" ", mark))


def complaints(section, mark, folder):
    """Return the lines that the checker reports for an example, as the page shows them."""
    for text in (*blocks(section, "python"), *blocks(section, "xml")):
        path = folder / re.match(r"(?:#|<!--) (\S+)", text)[1]
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        if "/" in text.splitlines()[0]:
            package = folder / path.relative_to(folder).parts[0]
            (package / "package.xml").write_text(
                f"<package><name>{package.name}</name>{EXPORTS}</package>"
            )
    (folder / "chart.xml").write_text(example(section, mark))
    search = os.pathsep.join([str(folder), *(str(ROOT / package) for package in PACKAGES)])
    library, warnings = read_library(find_packages(search)[0])
    assert warnings == ()
    package = OutputPackage("new_behaviors", folder, {})
    files = check_files([str(folder / "chart.xml")], library, lambda _path: package)
    lines = [str(problem).replace(f"{folder}/", "") for problem in files.problems]
    return [NAMES.sub("allowed: ...", line) for line in lines]


def test_every_code_has_its_section_and_its_row():
    assert [slug for slug, _ in SECTIONS] == [code.slug for code in ProblemKind]
    warning = {Severity.WARNING: " (warning)", Severity.ERROR: ""}
    rows = re.findall(r"^\| \[([\w-]+)\]\(#\1\) \| ([^|]+) \|$", PAGE, re.MULTILINE)
    assert rows == [(code.slug, code.meaning + warning[code.severity]) for code in ProblemKind]


@pytest.mark.parametrize(("slug", "section"), SECTIONS, ids=[slug for slug, _ in SECTIONS])
def test_the_wrong_example_gives_its_code_and_the_mended_one_nothing(slug, section, tmp_path):
    (shown,) = blocks(section, "text")
    (tmp_path / "wrong").mkdir()
    found = complaints(section, "-", tmp_path / "wrong")
    assert found == shown.splitlines()
    assert {re.search(r"\[([\w-]+)\]", line)[1] for line in found} == {slug}
    (tmp_path / "mended").mkdir()
    assert complaints(section, "+", tmp_path / "mended") == []
