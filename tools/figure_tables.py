"""Tables of figures in the docs, from the files that benchmarks write.

A page holds a block

    <!-- figures: sim.jsonl -->
    <!-- end of figures -->

and `make generate` writes the rows of docs/figures/sim.jsonl between its lines. A line of JSON is a
figure with `what`, `value`, `unit`, what it is to be: at most `most` or `target`, at least `least`,
and perhaps the `floor` that it is compared with; or else a row of a table, whose keys are the
columns. Figures whose `what` is equal up to the first comma or colon share a row, and so do rows of
a table that differ in the first column only. `test/test_generated.py` compares, so that page and
file cannot disagree.
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
    return f"{block['begin']}{text}{block['end']}"


def _rows(figures: list[dict[str, Any]]) -> list[dict[str, str]]:
    """Return the rows: one for each kind of figures, or for those of a table that are alike."""
    if not all("value" in figure for figure in figures):
        return _alike([{name: str(value) for name, value in row.items()} for row in figures])
    groups = defaultdict(list)
    for figure in figures:
        groups[re.split(", |: ", figure["what"], maxsplit=1)[0]].append(figure)
    rows = [_row(kind, group) for kind, group in groups.items()]
    return [dict(zip(COLUMNS, row, strict=True)) for row in rows]


def _row(kind: str, figures: list[dict[str, Any]]) -> tuple[str, str, str]:
    """Return the row of a kind; targets that differ stand beside what was measured."""
    targets = [_target(figure) for figure in figures]
    common = targets[0][0] if len({target for target, _ in targets}) == 1 else None
    if len(figures) == 1:
        kind = figures[0]["what"]
    shown = []
    for figure, (target, is_met) in zip(figures, targets, strict=True):
        notes = [target] if common is None and target else []
        notes += [] if is_met else ["missed"]
        case = figure["what"][len(kind) + 2 :]
        value = _measured(figure) + (f" ({', '.join(notes)})" if notes else "")
        shown.append(f"{case}: {value}" if case else value)
    return kind.replace("|", "/"), common or "", "<br>".join(shown).replace("|", "/")


def _alike(rows: list[dict[str, str]]) -> list[dict[str, str]]:
    """Return the rows of a table; those that differ in their first cell only are one."""
    names = defaultdict(list)
    for row in rows:
        (column, name), *rest = row.items()
        names[column, tuple(rest)].append(name)
    return [{column: "<br>".join(alike), **dict(rest)} for (column, rest), alike in names.items()]


def _target(figure: dict[str, Any]) -> tuple[str, bool]:
    """Return the target of a figure, and whether it is met."""
    least, most = figure.get("least"), figure.get("most", figure.get("target"))
    value, unit = figure["value"], f" {figure['unit']}".rstrip()
    if least is not None:
        return f"at least {least:g}{unit}", value >= least
    if most is not None:
        return f"at most {most:g}{unit}", value <= most
    return "", True


def _measured(figure: dict[str, Any]) -> str:
    value = figure["value"]
    number = f"{value:.3g}" if value < _LARGE else f"{value:,.0f}"
    floor = f", {value / figure['floor']:.1f} times its floor" if figure.get("floor") else ""
    return f"{number} {figure['unit']}".rstrip() + floor
