"""The columns of a wire list on a page: their first rows, and what each of them means."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui

from remodel_console.core.order_desk.columns import LENGTH_UNITS, SECTION_UNITS, ListColumns
from remodel_console.edge.order_desk.order_drafts import DraftState
from remodel_console.errors import CommandError
from remodel_console.web.page import Page, card, scrollable


class ColumnsPanel:
    """Shows the columns, and has the file read by what they mean."""

    def __init__(self, page: Page, read: Callable[[str], Awaitable[object]]) -> None:
        """Take the page; `read` reads the file by the YAML of a mapping."""
        self._page = page
        self._read = read

    def show(self, now: DraftState) -> None:
        """Add the card, if the columns of a list were read."""
        columns = now.columns
        if columns is None:
            return
        hint = "Choose what each column means: at least both ends of a wire."
        with card("Columns of the list", hint).classes("across"):
            with scrollable("Columns of the list"):
                meanings = self._show_table(columns)
            with ui.row().classes("options"):
                section = ui.select(
                    {
                        unit: unit.replace("mm2", "mm²").replace("awg", "AWG")
                        for unit in SECTION_UNITS
                    },
                    value=columns.units.get("section"),
                    label="Sections without a unit",
                )
                length = ui.select(
                    list(LENGTH_UNITS),
                    value=columns.units.get("length"),
                    label="Lengths without a unit",
                )
                separator = ui.input(
                    "Sign between component and terminal", value=columns.terminal_separator
                )
            for field in (section, length, separator):
                field.props("outlined dense stack-label").set_enabled(self._page.is_operator)
            problem = ui.label().classes("bad-count").props('role="alert"')

            async def read() -> None:
                try:
                    mapping = columns.mapping(
                        {heading: str(each.value) for heading, each in meanings.items()},
                        {"section": section.value, "length": length.value},
                        separator.value or "",
                    )
                except CommandError as error:
                    problem.text = str(error)
                    return
                problem.text = ""
                await self._read(mapping)

            self._page.button("Read the file by these columns", read, icon="refresh")

    def _show_table(self, columns: ListColumns) -> dict[str, ui.select]:
        """Add the headings and first rows, and return the choices by heading."""
        meanings: dict[str, ui.select] = {}
        shown = [i for i, heading in enumerate(columns.headings) if heading]
        with ui.element("table").classes("plain columns"):
            with ui.element("tr"):
                for i in shown:
                    heading = columns.headings[i]
                    with ui.element("th"):
                        choice = ui.select(
                            columns.choices, value=columns.meaning(heading), label=heading
                        )
                        choice.props("outlined dense stack-label options-dense")
                        choice.set_enabled(self._page.is_operator)
                        meanings[heading] = choice
            for row in columns.rows:
                with ui.element("tr"):
                    for i in shown:
                        with ui.element("td"):
                            ui.label(row[i] if i < len(row) else "")
        return meanings
