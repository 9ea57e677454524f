"""What the editor says of a chart: problems, a refusal, changes, the certificate."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from difflib import unified_diff
from functools import partial
from html import escape
from pathlib import PurePath

from nicegui import run, ui

from flexbe_synthesizer.core.chart.problem import Problem, Severity
from remodel_console.core.editor.fixes import Found, unambiguous
from remodel_console.core.editor.inspection import Inspection, certificate_html
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


def _without_file(line: str) -> str:
    """Return a line of an answer without the file, which stands above it."""
    parts = line.split(":", 3)
    return f"Line {parts[1]}:{parts[3]}" if len(parts) > 3 and parts[1].isdigit() else line


def _error_lines(words: str) -> Iterable[int]:
    """Yield the lines that an answer of the checks names, `file:line:column: [code] message`."""
    for parts in (line.split(":") for line in words.splitlines()):
        if len(parts) > 3 and parts[1].isdigit():
            yield int(parts[1])


_NO_CHANGES = "The file is as the chart is."
_NEW = "The chart has no file yet. Save writes all of it."
_MOST_LINES = 2000  # of text that are compared; more would hold the page up


class ChangesPanel:
    """Shows which lines Save changes."""

    def __init__(self, page: EditingPage) -> None:
        """Build an empty panel."""
        self._page = page
        self._words = ui.label(_NO_CHANGES).classes("soft")
        self._lines = ui.html("", sanitize=False).classes("wide changes")

    def show(self) -> None:
        """Show what Save would change."""
        session = self._page.session
        old, new = session.saved_text, session.text
        is_same = session.is_saved or old == new
        self._words.text = _NO_CHANGES if is_same else "" if old else _NEW
        self._words.set_visibility(is_same or not old)
        self._lines.set_content("" if is_same or not old else changes_html(old, new))


def changes_html(old: str, new: str) -> str:
    """Return the lines that differ between two texts, with three around each, as HTML."""
    lines = [text.splitlines() for text in (old, new)]
    if max(map(len, lines)) > _MOST_LINES:
        return f"<p>The text has more than {_MOST_LINES} lines; they are not compared here.</p>"
    parts = []
    for line in list(unified_diff(*lines, lineterm=""))[2:]:
        style = {"+": "added", "-": "removed", "@": "place"}.get(line[0], "")
        parts.append(f'<div class="{style}">{escape(line)}</div>')
    return "".join(parts)


_NO_CERTIFICATE = "A chart with errors has no certificate."


class CertificatePanel:
    """Shows the certificate, as it is written when the chart is saved."""

    def __init__(self) -> None:
        """Build an empty panel."""
        self._words = ui.label(_NO_CERTIFICATE).classes("soft")
        self._tables = ui.html("", sanitize=False).classes("wide certificate")
        self._shown: Inspection | None = None

    async def show(self, inspection: Inspection) -> None:
        """Show what holds for the chart as it was checked last."""
        if inspection is self._shown:
            return
        self._shown = inspection
        certificate = await run.io_bound(inspection.certify)
        if inspection is self._shown:
            self._words.set_visibility(certificate is None)
            self._tables.set_content("" if certificate is None else certificate_html(certificate))
