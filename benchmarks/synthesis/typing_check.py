#!/usr/bin/env python3
"""How long the console takes to check a chart again after each change that is typed.

The chart is that of `sizes.py`; it names another one of the same size, and both lie in a package of
a workspace with the golden packages. Each check is the one of the console's editor, from the text
to the problems and to what each state offers. Times are CPU time, the best of a few changes.

Usage: typing_check.py [STATES]
"""

import math
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from sizes import PACKAGE, chain

from flexbe_synthesizer.core.chart.chart_writer import write_chart
from remodel_console.edge.workspace import Workspace, inspect_text

STATES, CHANGES = 100, 20
AIM_S = 0.010  # [s]
_NAMED = """  <behavior id="Inner" type="inner.xml">
    <transition event="finished" target="finished"/>
    <transition event="failed" target="failed"/>
  </behavior>
</statemachine>
"""


def lay_workspace(top: Path, text: str) -> Path:
    """Lay out the packages and both charts as if they were old; return the chart's file."""
    packages = shutil.copytree(PACKAGE / "test" / "golden" / "packages", top / "src")
    file = packages / "cell_behaviors" / "charts" / "chain.xml"
    file.parent.mkdir()
    file.write_text(text)
    inner = text.replace('name="Chain"', 'name="Inner"', 1)
    (file.parent / "inner.xml").write_text(inner)
    for path in (*file.parent.iterdir(), file.parent, file.parent.parent):
        os.utime(path, (0, 0))  # what is new is read again at each check
    return file


def changes(text: str) -> dict[str, Callable[[int], str]]:
    """Return what is typed: by name, a function of the number of the change."""
    named = text.replace('target="finished"', 'target="Inner"').replace("</statemachine>", _NAMED)
    failed, s50 = 'event="failed" target="failed"', 'target="S50"'
    return {
        "a value": lambda i: text.replace('value="20.0"', f'value="{i}.5"', 1),
        "a value, beside another chart": lambda i: named.replace('"20.0"', f'"{i}.5"', 1),
        "a misspelt target": lambda i: text.replace(s50, f'target="S50{i}x"', 1),
        "a loop without limit": lambda i: text.replace(failed, f'event="failed" target="S{i}"', 1),
        "a tag that is not closed": lambda i: text[: len(text) // 2 + i],
    }


def main(states: int) -> None:
    """Print a row for each kind of change."""
    text = write_chart(chain(states))
    print(f"{'typed':<32} {'CPU [ms]':>9} {'problems':>9}")  # noqa: T201
    with tempfile.TemporaryDirectory() as folder:
        file = lay_workspace(Path(folder), text)
        workspace = Workspace(str(Path(folder) / "src"))
        inspect_text(workspace, text, str(file))
        for name, change in changes(text).items():
            shortest, problems = math.inf, 0
            for number in range(CHANGES):
                draft = change(number)
                start = time.process_time()
                _chart, inspection = inspect_text(workspace, draft, str(file))
                shortest = min(shortest, time.process_time() - start)
                problems = len(inspection.problems)
            print(f"{name:<32} {shortest * 1000:>9.1f} {problems:>9}")  # noqa: T201
    print(f"aimed for: {AIM_S * 1000:.0f} ms")  # noqa: T201


if __name__ == "__main__":
    main(int(sys.argv[1]) if sys.argv[1:] else STATES)
