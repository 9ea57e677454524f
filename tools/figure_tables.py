"""Tables of figures in the docs, from the files that benchmarks write.

A page holds a block

    <!-- figures: sim.jsonl -->
    <!-- end of figures -->

and `make generate` writes the rows of docs/figures/sim.jsonl between its lines. A line of JSON is a
figure with `what`, `value`, `unit`, what it is to be: at most `most` or `target`, at least `least`,
and perhaps the `floor` that it is compared with; or else a row of a table, whose keys are the
columns. Figures whose `what` is equal up to the first comma, and whose targets are equal, share a
row. `test/test_generated.py` compares, so that page and file cannot disagree.
"""

import json
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parents[1] / "docs"
FIGURES = DOCS / "figures"

BLOCK = re.compile(
    r"(?P<begin><!-- figures: (?P<file>[\w-]+\.jsonl) -->\n).*?(?P<end><!-- end of figures -->)",
    re.DOTALL,
)
# From here on a figure is shown without decimals.
_LARGE = 1000

COLUMNS = ("figure", "target", "measured")


def pages_with_figures() -> Iterator[tuple[Path, str]]:
    """Yield each page that has a block, with the text that it should have."""
    for page in sorted([*DOCS.rglob("*.md"), *DOCS.parent.glob("src/**/README.md")]):
        text = page.read_text(encoding="utf-8")
        if BLOCK.search(text):
            yield page, BLOCK.sub(_filled, text)


def _filled(block: re.Match[str]) -> str:
    lines = (FIGURES / block["file"]).read_text(encoding="utf-8").splitlines()
    rows = _rows([json.loads(line) for line in lines])
    columns = list(dict.fromkeys(column for row in rows for column in row))
    table = [columns, ["---"] * len(columns), *([row.get(c, "") for c in columns] for row in rows)]
    text = "".join(f"| {' | '.join(cells)} |\n" for cells in table)
    return f"{block['begin']}\n{text}\n{block['end']}"


def _rows(figures: list[dict[str, Any]]) -> list[dict[str, str]]:
    """Return the rows; figures of one kind, `KIND, CASE`, and one target are one row."""
    if not all("value" in figure for figure in figures):
        return [{column: str(value) for column, value in figure.items()} for figure in figures]
    groups = defaultdict(list)
    for figure in figures:
        what, target, measured = _cells(figure)
        groups[what.partition(", ")[0], target].append((what, measured))
    rows = []
    for (kind, target), measurements in groups.items():
        if len(measurements) == 1:
            ((kind, shown),) = measurements
        else:
            cases = [(what.partition(", ")[2], measured) for what, measured in measurements]
            shown = "<br>".join(f"{case}: {m}" if case else m for case, m in cases)
        rows.append(dict(zip(COLUMNS, (kind, target, shown), strict=True)))
    return rows


def _cells(figure: dict[str, Any]) -> tuple[str, str, str]:
    """Return what a figure is, its target, and what was measured."""
    least, most = figure.get("least"), figure.get("most", figure.get("target"))
    value, unit = figure["value"], f" {figure['unit']}".rstrip()
    target, met = "", True
    if most is not None:
        target, met = f"at most {most:g}{unit}", value <= most
    if least is not None:
        target, met = f"at least {least:g}{unit}", value >= least
    number = f"{value:.3g}" if value < _LARGE else f"{value:,.0f}"
    floor = f", {value / figure['floor']:.1f} times its floor" if figure.get("floor") else ""
    return (
        figure["what"].replace("|", "/"),
        target,
        f"{number}{unit}{floor}{'' if met else ' (missed)'}",
    )
