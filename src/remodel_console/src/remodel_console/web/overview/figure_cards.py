"""The production figures of a run: first-pass yield, cycle times and recoveries, with plots."""

from __future__ import annotations

from nicegui import ui

from remodel_console.core.plot import bar_plot, count_height, count_plot, line_plot
from remodel_console.core.use_case.production import Figures
from remodel_console.core.use_case.use_case import duration_words
from remodel_console.web.plot import Plot

_PLOTTED_TASKS = 100  # the latest; the figures are of all


class FigureCards:
    """Shows a card for each figure, once a task has ended.

    Attributes:
        area: the element that has the cards.
    """

    def __init__(self) -> None:
        """Build the cards."""
        self._shown: Figures | None = None
        with ui.element("div").classes("figures") as self.area:
            self._yield, self._yields = _card("First-pass yield", "First-pass yield over tasks")
            self._cycle, self._cycles = _card("Cycle time", "Time of each task")
            self._recovered, self._causes = _card("Recoveries by cause", "Recoveries by cause")

    def show(self, found: Figures) -> None:
        """Show the figures of a run."""
        if found == self._shown:
            return
        self._shown = found
        share, mean_s = found.sums.first_pass_yield, found.sums.mean_cycle_s
        self.area.set_visibility(share is not None)
        if share is None:
            return
        tasks, done = found.tasks[-_PLOTTED_TASKS:], found.done[-_PLOTTED_TASKS:]
        self._yield.text = f"{share:.0%}"
        self._yields.show(line_plot(tasks, found.yields[-_PLOTTED_TASKS:]))
        self._cycle.text = "" if mean_s is None else f"{duration_words(mean_s)} on average"
        self._cycles.show(bar_plot(done, found.cycles_s[-_PLOTTED_TASKS:], "s"))
        self._recovered.text = str(sum(count for _, count in found.recoveries))
        self._causes.show(count_plot(found.recoveries), count_height(len(found.recoveries)))


def _card(title: str, label: str) -> tuple[ui.label, Plot]:
    """Return the label of a new card's figure, and the card's plot."""
    with ui.element("div").classes("card plot-card"):
        with ui.row().classes("plot-head"):
            ui.label(title).classes("soft")
            figure = ui.label().classes("figure")
        return figure, Plot(label)
