"""Elements of pages that are made of several of NiceGUI's."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

from nicegui import ui

from remodel_console.core.plots import Options


def icon_button(icon: str, title: str, deed: Callable[[], object]) -> ui.button:
    """Return a round button without a text; the title says what it does."""
    made = ui.button(icon=icon, on_click=deed, color=None).props("flat dense round")
    made.props["title"] = made.props["aria-label"] = title
    return made


def text_in(tag: str, text: str, style: str = "") -> ui.label:
    """Add an element with a text, such as a cell of a table, and return the text."""
    with ui.element(tag).classes(style):
        return ui.label(text)


@contextmanager
def unfolding(title: str) -> Iterator[None]:
    """Add what is shown when a person asks for it; it is built inside."""
    with ui.element("details").classes("wide"):
        text_in("summary", title)
        yield


def card(title: str, hint: str) -> ui.element:
    """Return a part of a page with a title and a hint, to be filled."""
    made = ui.element("section").classes("card matter")
    with made:
        ui.label(title).classes("title")
        ui.label(hint).classes("soft")
    return made


def scrollable(name: str) -> ui.element:
    """Return a frame for what may be too wide or too high, such as a table; keys scroll it, too."""
    frame = ui.element("div").classes("table-frame wide").props('tabindex="0" role="region"')
    frame.props["aria-label"] = name
    return frame


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> None:
    """Add a plain table."""
    with ui.element("table").classes("plain"):
        with ui.element("tr"):
            for text in head:
                text_in("th", text)
        for row in rows:
            with ui.element("tr"):
                for text in row:
                    text_in("td", text)


def time_words(wall_s: float) -> str:
    """Return the time of day of a wall time [s]."""
    return time.strftime("%H:%M:%S", time.localtime(wall_s))


class Plot:
    """Shows the options of `core.plots`; the browser draws them."""

    def __init__(self, label: str) -> None:
        """Show nothing yet; `label` names the plot for screen readers."""
        self._chart = ui.echart({}, renderer="svg").classes("plot")
        self._chart.props["role"] = "img"
        self._chart.props["aria-label"] = label

    def show(self, options: Options, height: int | None = None) -> None:
        """Show another plot, of a height [pixels] other than usual if one is given."""
        self._chart.options.clear()
        self._chart.options.update(options)
        if height is not None:
            self._chart.style(f"height: {height}px")
        self._chart.update()
