"""What is generated from tables and figures is committed as it is generated now."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

TOOL = Path(__file__).parents[1] / "tools" / "generate.py"
sys.path.insert(0, str(TOOL.parent))

import figure_tables  # noqa: E402

DOCS = TOOL.parents[1] / "docs"
# Of runs of `make test-all`: `make test` prints the last one.
RECORD = "test-all.jsonl"


def test_generated_files_are_those_of_the_tables():
    done = subprocess.run([sys.executable, TOOL, "--check"], capture_output=True, text=True)
    assert done.returncode == 0, f"run make generate\n{done.stdout}{done.stderr}"


def test_each_file_of_figures_is_shown_on_a_page():
    pages = "".join(text for _page, text in figure_tables.pages_with_figures())
    shown = re.findall(r"<!-- figures: (\S+) -->", pages)
    written = {file.name for file in (DOCS / "figures").glob("*.jsonl")} - {RECORD}
    assert sorted(shown) == sorted(written)


@pytest.mark.parametrize(
    ("figures", "table"),
    [
        (
            [
                {"what": "sag", "value": 0.15, "unit": "%", "least": None, "most": 0.1},
                {"what": "factor", "value": 10.0, "unit": "x", "least": 5.0, "most": None},
                {"what": "bare", "value": 1.0, "unit": "", "floor": 0.5},
                {"what": "many", "value": 71202, "unit": ""},
            ],
            "| figure | target | measured |\n| --- | --- | --- |\n"
            "| sag | at most 0.1 % | 0.15 % (missed) |\n| factor | at least 5 x | 10 x |\n"
            "| bare |  | 1, 2.0 times its floor |\n| many |  | 71,202 |\n",
        ),
        (
            [
                {"what": "sag, 1 m", "value": 1, "unit": "%", "most": 2},
                {"what": "sag, 2 m", "value": 3, "unit": "%", "most": 2},
                {"what": "idle: load", "value": 3, "unit": "%", "most": 4},
                {"what": "idle: wake-ups", "value": 3, "unit": "1/s"},
            ],
            "| figure | target | measured |\n| --- | --- | --- |\n"
            "| sag | at most 2 % | 1 m: 1 %<br>2 m: 3 % (missed) |\n"
            "| idle |  | load: 3 % (at most 4 %)<br>wake-ups: 3 1/s |\n",
        ),
        (
            [{"at": "1 m", "lost": 0}, {"at": "2 m", "lost": 1}, {"at": "3 m", "lost": 0}],
            "| at | lost |\n| --- | --- |\n| 1 m<br>3 m | 0 |\n| 2 m | 1 |\n",
        ),
        ([{"yield": "a", "frozen": "63"}], "| yield | frozen |\n| --- | --- |\n| a | 63 |\n"),
    ],
)
def test_a_page_gets_the_figures_of_its_file(tmp_path, monkeypatch, figures, table):
    (tmp_path / "f.jsonl").write_text("".join(f"{json.dumps(row)}\n" for row in figures))
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- figures: f.jsonl -->\nold\n<!-- end of figures -->\nafter\n")
    monkeypatch.setattr(figure_tables, "DOCS", tmp_path)
    monkeypatch.setattr(figure_tables, "FIGURES", tmp_path)
    ((found, text),) = figure_tables.pages_with_figures()
    assert found == page
    block = f"<!-- figures: f.jsonl -->\n{table}<!-- end of figures -->"
    assert text == f"before\n{block}\nafter\n"
