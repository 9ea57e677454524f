"""What is wrong with a chart, on the editor's page."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import PurePath

from nicegui import ui

from flexbe_synthesizer.core.chart.problem import Problem, Severity
from remodel_console.core.editor.inspection import Inspection

Reveal = Callable[[int], None]


class ProblemList:
    """Shows what the checks have found, each a button that leads to its line."""

    def __init__(self, reveal: Reveal) -> None:
        """Build an empty list; `reveal` shows a line of the XML."""
        self._reveal = reveal
        self._area = ui.element("div").classes("problems").props('role="status"')

    def show(self, inspection: Inspection, own: str) -> None:
        """Show the problems of the chart in the file `own`."""
        self._area.clear()
        with self._area:
            count = inspection.error_count
            words = "No errors." if not count else f"{count} error{'s' * (count > 1)}"
            if inspection.unchecked:
                words = f"Not checked: {inspection.unchecked}"
            is_fine = not count and not inspection.unchecked
            ui.label(words).classes("soft" if is_fine else "bad-count")
            for problem in inspection.problems:
                _problem_line(problem, own, self._reveal)


def show_refusal(goal: str, text: str, words: str, close: Callable[[], None]) -> None:
    """Add the errors of a chart that cannot be used, beside its lines.

    Args:
        goal: path of the chart's file.
        text: its content.
        words: the answer of the checks, a line for each error.
        close: called by the button at the end.
    """
    ui.label(f"{goal} cannot be used").classes("title")
    with ui.element("div").classes("refusal"):
        wrong = frozenset(_error_lines(words))
        with ui.element("pre").classes("source"):
            for number, line in enumerate(text.splitlines(), start=1):
                row = ui.label(f"{number:4}  {line}")
                if number in wrong:
                    row.classes("xml-error")
        with ui.element("div").classes("errors"):
            for line in words.splitlines():
                ui.label(_without_file(line))
    ui.button("Close", on_click=close).props("no-caps flat autofocus")


def _problem_line(problem: Problem, own: str, reveal: Reveal) -> None:
    """Add a problem as a button."""
    file, line, _ = problem.position
    where = f"line {line}" if file == own else f"{PurePath(file).name}, line {line}"
    style = "warning" if problem.code.severity is Severity.WARNING else "error"
    with ui.element("button").classes(f"problem {style}").on("click", lambda: reveal(line)):
        ui.label(where).classes("place")
        ui.label(problem.message)


def _without_file(line: str) -> str:
    """Return a line of an answer without the file, which stands above it."""
    parts = line.split(":", 3)
    return f"Line {parts[1]}:{parts[3]}" if len(parts) > 3 and parts[1].isdigit() else line


def _error_lines(words: str) -> Iterable[int]:
    """Yield the lines that an answer of the checks names, `file:line:column: [code] message`."""
    for parts in (line.split(":") for line in words.splitlines()):
        if len(parts) > 3 and parts[1].isdigit():
            yield int(parts[1])
