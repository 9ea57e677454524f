"""The parts of a page that a person arranges: shown or hidden, up or down, and how large."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from urllib.parse import unquote

from nicegui import ui

from remodel_console.core.arrangement import Part, arranged, arrangement_text, moved, with_shown
from remodel_console.web.bar import set_cookie


class Arrangement:
    """Keeps the parts of one page; the browser remembers them in a cookie."""

    def __init__(
        self,
        page: str,
        cookies: Mapping[str, str],
        dialog: Callable[[str], AbstractContextManager[ui.dialog]],
        on_change: Callable[[], None],
    ) -> None:
        """Arrange a page as its cookie says.

        Args:
            page: its title.
            cookies: of the browser.
            dialog: opens a dialog of a name.
            on_change: is called when a part was shown or hidden.
        """
        self._page = page.lower().replace(" ", "_")
        self._cookie = f"remodel_layout_{self._page}"
        self._text = unquote(cookies.get(self._cookie, ""))
        self._dialog = dialog
        self._on_change = on_change
        self._defaults: tuple[Part, ...] = ()
        self._parts: tuple[Part, ...] = ()
        self._elements: dict[str, ui.element] = {}

    def __bool__(self) -> bool:
        """Return whether the page has parts to arrange."""
        return bool(self._parts)

    @contextmanager
    def part(self, title: str, area: str) -> Iterator[None]:
        """Add a part in a column of the page; what is built inside belongs to it."""
        with ui.element("div").classes("part") as element:
            yield
        self._elements[title] = element
        self._defaults = (*self._defaults, Part(title, area))
        self._take(arranged(self._defaults, self._text))

    def splitter(self, what: str, size: str, *, is_column: bool) -> None:
        """Add a line that is dragged to change a size.

        Args:
            what: the size, for a person who does not see it.
            size: its name, which the style of the page has as `--PAGE-SIZE`.
            is_column: it changes a width.
        """
        line = (
            ui.element("div")
            .classes(f"splitter of-{size}")
            .props(
                f'role="separator" tabindex="0" aria-valuenow="0" '
                f'aria-orientation="{"vertical" if is_column else "horizontal"}"'
            )
        )
        line.props["aria-label"] = what
        line.props["data-size"] = f"--{self._page}-{size}"

    def is_shown(self, title: str) -> bool:
        """Return whether a part is shown."""
        return next(part.is_shown for part in self._parts if part.title == title)

    def ask(self) -> None:
        """Open the dialog in which the parts are arranged."""
        with self._dialog("Layout"):
            ui.label("Layout of this page").classes("title")
            ui.label("Lines between the parts can be dragged. This browser keeps it.").classes(
                "soft"
            )
            rows = ui.element("div").classes("wide")
            self._list(rows)
            ui.button("As it was delivered", on_click=partial(self._reset, rows), color=None).props(
                "no-caps flat"
            )

    def _list(self, rows: ui.element) -> None:
        rows.clear()
        with rows:
            for part in self._parts:
                with ui.row().classes("layout-row"):
                    shown = ui.checkbox(part.title, value=part.is_shown)
                    shown.on_value_change(partial(self._show, part.title, shown))
                    ui.space()
                    for icon, word, step in (
                        ("arrow_upward", "up", -1),
                        ("arrow_downward", "down", 1),
                    ):
                        button = ui.button(
                            icon=icon,
                            on_click=partial(self._move, rows, part.title, step),
                            color=None,
                        )
                        button.props(f'flat dense round aria-label="{part.title} {word}"')

    def _show(self, title: str, shown: ui.checkbox) -> None:
        self._keep(with_shown(self._parts, title, is_shown=bool(shown.value)))

    def _move(self, rows: ui.element, title: str, step: int) -> None:
        self._keep(moved(self._parts, title, step))
        self._list(rows)

    def _reset(self, rows: ui.element) -> None:
        self._keep(self._defaults)
        ui.run_javascript(f"forgetSizes('--{self._page}-')")
        self._list(rows)

    def _keep(self, parts: tuple[Part, ...]) -> None:
        self._take(parts)
        set_cookie(self._cookie, arrangement_text(parts))
        self._on_change()

    def _take(self, parts: tuple[Part, ...]) -> None:
        self._parts = parts
        for place, part in enumerate(parts):
            element = self._elements[part.title]
            element.style(f"order: {place}")
            element.set_visibility(part.is_shown)
