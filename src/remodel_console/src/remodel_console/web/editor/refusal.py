"""A chart that cannot be used: its text, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from nicegui import ui


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
