"""The form that starts a behavior: which, how freely, and with what."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import ui

from flexbe_synthesizer.core.chart.literal import Literal, format_literal
from remodel_console.core.run.order import LEVELS, UNATTENDED, Pairs, Start
from remodel_console.edge.catalogue import Installed
from remodel_console.web.page import Page


class StartForm:
    """Shows what the loaded behavior takes, and starts it."""

    def __init__(self, page: Page, start: Callable[[Start], Awaitable[object]]) -> None:
        """Build the form."""
        self._page = page
        self._start_behavior = start
        self._known = {one.name: one for one in page.console.catalogue.behaviors()}
        chart = page.console.session.chart
        loaded = chart.name if chart and chart.name in self._known else None
        choice = ui.select(
            sorted(self._known),
            value=loaded,
            label="Behavior",
            with_input=True,
            on_change=lambda event: page.load(event.value),
        )
        choice.props("outlined dense").classes("wide").set_enabled(page.is_operator)
        if chart is not None and loaded is None:
            ui.label(f"'{chart.name}' is not saved as a behavior yet; save it to run it.")
        if loaded is not None:
            self._build(self._known[loaded])

    def _build(self, installed: Installed) -> None:
        behavior = installed.behavior
        self._level = ui.select(
            {level: word.capitalize() for level, word in LEVELS.items()},
            value=UNATTENDED,
            label="Autonomy: what needs no confirmation",
        )
        self._level.props("outlined dense").classes("wide")
        chart = self._page.console.session.chart
        usual = {port.name: port.default for port in chart.inputs} if chart else {}
        self._parameters = {
            p.name: _entry(p.name, "default of the behavior") for p in behavior.parameters
        }
        self._inputs = {
            port.name: _entry(port.name, _usually(usual.get(port.name), port.type))
            for port in behavior.inputs
        }
        if not self._page.console.session.is_saved:
            ui.label(
                "Start runs the saved version, without the unsaved changes in the editor."
            ).classes("held")
        self._page.button("Start", self._start, icon="play_arrow")
        self._installed = installed

    async def _start(self) -> None:
        await self._start_behavior(
            Start(
                name=self._installed.name,
                behavior_id=self._installed.behavior_id,
                source_checksum=self._installed.source_checksum,
                level=int(self._level.value),
                parameters=_given(self._parameters),
                inputs=_given(self._inputs),
            )
        )


def _entry(name: str, hint: str) -> ui.input:
    entry = ui.input(name, placeholder=hint)
    entry.props("outlined dense stack-label").classes("wide")
    return entry


def _usually(default: Literal, kind: str | None) -> str:
    """Return what an input is if it is left empty, or what it takes."""
    return f"default: {format_literal(default)}" if default is not None else kind or "any"


def _given(entries: dict[str, ui.input]) -> Pairs:
    """Return what was given; the behavior's own defaults stay for what was not."""
    return tuple(
        (name, entry.value.strip())
        for name, entry in entries.items()
        if (entry.value or "").strip()
    )
