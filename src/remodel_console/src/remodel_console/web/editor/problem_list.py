"""What is wrong with a chart, on the editor's page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import PurePath

from nicegui import ui

from flexbe_synthesizer.core.chart.problem import Problem, Severity
from remodel_console.core.editor.fixes import Found, unambiguous
from remodel_console.core.editor.inspection import Inspection
from remodel_console.web.editor.editing_page import EditingPage

Reveal = Callable[[int], None]


class ProblemList:
    """Shows what the checks have found, each a button that leads to its line."""

    def __init__(self, page: EditingPage, reveal: Reveal) -> None:
        """Build an empty list; `reveal` shows a line of the XML."""
        self._page = page
        self._reveal = reveal
        self._area = ui.element("div").classes("problems").props('role="status"')

    def show(self, inspection: Inspection, own: str, found: Sequence[Found]) -> None:
        """Show the problems of the chart in the file `own`."""
        self._area.clear()
        with self._area:
            count = inspection.error_count
            words = "No errors." if not count else f"{count} error{'s' * (count > 1)}"
            if inspection.unchecked:
                words = f"Not checked: {inspection.unchecked}"
            is_fine = not count and not inspection.unchecked
            ui.label(words).classes("soft" if is_fine else "bad-count")
            certain = unambiguous(found)
            if len(certain) > 1:
                words = f"Fix the {len(certain)} errors that have one correction"
                self._page.button(words, partial(self._page.fix_all, certain), look="quiet")
            for one in found:
                self._line(one, own)

    def _line(self, one: Found, own: str) -> None:
        """Add a problem: a button that shows its line, and one for each change that corrects it."""
        _problem_line(one.problem, own, partial(self._show, one))
        if one.fixes:
            with ui.row().classes("fixes"):
                for fix in one.fixes:
                    self._page.button(fix.words, partial(self._page.fix, fix), look="quiet")

    def _show(self, one: Found, line: int) -> None:
        if one.path:
            self._page.select(one.path)
        self._reveal(line)


def _problem_line(problem: Problem, own: str, reveal: Reveal) -> None:
    """Add a problem as a button."""
    file, line, _ = problem.position
    where = f"line {line}" if file == own else f"{PurePath(file).name}, line {line}"
    style = "warning" if problem.code.severity is Severity.WARNING else "error"
    with ui.element("button").classes(f"problem {style}").on("click", lambda: reveal(line)):
        ui.label(where).classes("place")
        ui.label(problem.message)
