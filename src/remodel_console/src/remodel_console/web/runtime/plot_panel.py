"""Fields of topics that a person has chosen, plotted live."""

from __future__ import annotations

from dataclasses import replace

from nicegui import run, ui

from remodel_console.console import Console
from remodel_console.core.plot import recent_plot
from remodel_console.core.run.topic_plot import WINDOW_S
from remodel_console.errors import CommandError
from remodel_console.web.page import Page
from remodel_console.web.plot import Plot


class PlotPanel:
    """Shows the last minute of each plot, and the fields in which a person chooses one more."""

    def __init__(self, page: Page) -> None:
        """Build it; the plots are kept with the settings, for all pages."""
        self._page = page
        self._console: Console = page.console
        self._shown: tuple[str, ...] = ()
        self._rows: dict[str, tuple[ui.label, ui.label, Plot]] = {}
        self._is_viewer = False
        with ui.element("section").classes("wide plot-panel").props('aria-label="Plots"'):
            ui.label("Plots").classes("heading")
            self._area = ui.element("div").classes("wide")
            self._topic = ui.select({}, label="Topic", with_input=True)
            self._topic.on("focus", self._list_topics).on_value_change(self._list_fields)
            # Another element of a list is typed, such as position[3].
            self._field = ui.select([], label="Field", with_input=True, new_value_mode="add-unique")
            for choice in (self._topic, self._field):
                choice.props("outlined dense").classes("wide").set_enabled(page.is_operator)
            page.button("Plot", self._add, look="quiet")
        ui.context.client.on_delete(lambda: self.set_shown(False))
        self.set_shown(True)

    def set_shown(self, is_shown: bool) -> None:
        """Receive no values while the page is in the background, and go on."""
        if is_shown != self._is_viewer:
            self._is_viewer = is_shown
            self._console.plots.add_viewer(1 if is_shown else -1)

    def show(self) -> None:
        """Show the plots that are chosen now, also by another page."""
        plots = self._console.settings.now.plots
        if plots == self._shown:
            return
        self._shown = plots
        self._area.clear()
        self._rows.clear()
        with self._area:
            for plot in plots:
                with ui.row().classes("plot-head"):
                    ui.label(plot).classes("soft where")
                    figure = ui.label().classes("figure")
                    self._remove_button(plot)
                problem = ui.label().classes("soft").props('role="status"')
                self._rows[plot] = (figure, problem, Plot(plot))

    def _remove_button(self, plot: str) -> None:
        button = self._page.button("", lambda: self._remove(plot), icon="close", look="quiet")
        button.props(f'aria-label="Remove the plot {plot}" dense')

    def follow(self) -> None:
        """Show the newest values."""
        for plot, (figure, problem, drawing) in self._rows.items():
            points = self._console.plots.points(plot)
            figure.text = f"{points[-1][1]:.4g}" if points else "-"
            problem.text = self._console.plots.problem(plot)
            problem.set_visibility(bool(problem.text))
            drawing.show(recent_plot(points, WINDOW_S))

    async def _list_topics(self) -> None:
        source = self._console.plots.source
        try:
            topics = await run.io_bound(source.topics) if source else {}
        except CommandError:
            return  # the line of status says that there is no master
        names = {topic: f"{topic} ({kind})" for topic, kind in topics.items()}
        if names != self._topic.options:
            value = self._topic.value
            self._topic.set_options(names, value=value if value in names else None)

    async def _list_fields(self) -> None:
        topic, source = self._topic.value, self._console.plots.source
        if not topic or source is None:
            self._field.set_options([], value=None)
            return
        try:
            fields = await run.io_bound(source.fields, str(topic))
        except CommandError as error:
            self._page.show_error(str(error))
            return
        self._field.set_options(list(fields), value=fields[0] if fields else None)

    async def _add(self) -> None:
        plot = f"{self._topic.value or ''}.{self._field.value or ''}"
        await self._page.give(f"plot {plot}", lambda: self._console.add_plot(plot))

    async def _remove(self, plot: str) -> None:
        settings = self._console.settings
        await self._page.give(
            f"remove the plot {plot}",
            lambda: settings.change(
                lambda now: replace(now, plots=tuple(p for p in now.plots if p != plot))
            ),
        )
