"""A plot on a page."""

from __future__ import annotations

from nicegui import ui

from remodel_console.core.plot import Options


class Plot:
    """Shows the options of `core.plot`; the browser draws them."""

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
