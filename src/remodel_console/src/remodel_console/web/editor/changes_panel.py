"""The difference between the chart and its file, on the editor's page, before it is saved."""

from __future__ import annotations

from difflib import unified_diff
from html import escape

from nicegui import ui

from remodel_console.web.editor.editing_page import EditingPage

_NONE = "The file is as the chart is."
_NEW = "The chart has no file yet. Save writes all of it."
_MOST_LINES = 2000  # of text that are compared; more would hold the page up


class ChangesPanel:
    """Shows which lines Save changes."""

    def __init__(self, page: EditingPage) -> None:
        """Build an empty panel."""
        self._page = page
        self._words = ui.label(_NONE).classes("soft")
        self._lines = ui.html("", sanitize=False).classes("wide changes")

    def show(self) -> None:
        """Show what Save would change."""
        session = self._page.session
        old, new = session.saved_text, session.text
        is_same = session.is_saved or old == new
        self._words.text = _NONE if is_same else "" if old else _NEW
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
