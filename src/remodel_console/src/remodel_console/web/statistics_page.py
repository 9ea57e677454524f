"""Statistics across runs: yield and utilisation over time, terminals that jam, time per wire."""

from __future__ import annotations

from nicegui import background_tasks, run, ui

from remodel_console.core.plots import bar_plot, line_plot
from remodel_console.core.use_case import duration_words
from remodel_console.core.world import ALL_PARTS, World
from remodel_console.errors import CommandError
from remodel_console.web.page import Page, Plot, card, table
from remodel_run.progress import Sums
from remodel_run.record import Statistics

_ALL = "all orders"
_SHOWN_RUNS = 60  # the latest
_SHOWN = 20  # terminals and wires: the worst; runs: the latest
_UNKNOWN = "The figures of recorded runs are here once the supervisor is running."
_NONE = "No task has ended in a recorded run. With the first, its figures are here."
_SUMS = ("Run", "Done before", "Done", "Skipped", "Interrupted", "Open", "By hand")


class StatisticsPage(Page):
    """The page of what recorded runs have in common."""

    PARTS = ALL_PARTS

    def build(self) -> None:
        """Build a card for each matter."""
        self._has_supervisor = False
        with ui.element("div").classes("statistics"):
            with ui.row().classes("choice-row"):
                self._order = ui.select([_ALL], value=_ALL, label="Order", on_change=self._load)
                self._order.props("outlined dense")
                reload = ui.button(icon="refresh", on_click=self._load, color=None)
                reload.props('flat dense round title="Reload" aria-label="Reload"')
                self._message = ui.label(_UNKNOWN).classes("soft").props('role="status"')
            with card("First-pass yield", "Share of the tasks of each run done at once."):
                self._yields = Plot("First-pass yield over runs")
            with card("Tasks", "What became of the tasks of each run, the latest first."):
                self._sums = ui.element("div").classes("wide")
            hint = (
                "Share of each run, from its first operation on, in which an ability was executed."
            )
            with card("Utilisation", hint):
                self._utilisations = Plot("Utilisation over runs")
            with card("Time per wire", "Mean of all runs, the slowest first."):
                self._times = Plot("Mean time of the slowest wires")
                self._wires = ui.element("div").classes("wide")
            with card("Terminals", "Insertions that ended with an error, most first."):
                self._terminals = ui.element("div").classes("wide")

    def show(self, world: World) -> None:
        """Read the statistics as soon as a supervisor is running."""
        if world.has_supervisor and not self._has_supervisor:
            background_tasks.create(self._load())
        self._has_supervisor = world.has_supervisor

    async def _load(self) -> None:
        """Read the statistics of the order that is chosen, and show them."""
        recorder = self.console.recorder
        if recorder is None:
            return
        order = "" if self._order.value == _ALL else str(self._order.value)
        try:
            orders = await run.io_bound(recorder.orders)
            found = await run.io_bound(recorder.statistics, order)
        except CommandError as error:
            self._message.text = str(error)
            return
        self._message.text = "" if found.yields else _NONE
        self._order.set_options([_ALL, *orders], value=self._order.value)
        self._show_found(found)

    def _show_found(self, found: Statistics) -> None:
        latest = found.yields[-_SHOWN_RUNS:]
        self._yields.show(line_plot([f"run {n}" for n, _ in latest], [y for _, y in latest]))
        self._sums.clear()
        with self._sums:
            table(_SUMS, map(_sums_row, reversed(found.sums[-_SHOWN:])))
        latest = found.utilisations[-_SHOWN_RUNS:]
        self._utilisations.show(line_plot([f"run {n}" for n, _ in latest], [u for _, u in latest]))
        slowest = found.wires[:_SHOWN]
        self._times.show(bar_plot([name for name, _ in slowest], [s for _, s in slowest], "s"))
        self._wires.clear()
        with self._wires:
            table(("Wire", "Mean time"), ((name, duration_words(s)) for name, s in slowest))
        self._terminals.clear()
        with self._terminals:
            head = ("Terminal", "Insertions", "Failed", "Share")
            table(head, map(_terminal_row, found.terminals[:_SHOWN]))


def _sums_row(one: tuple[int, Sums]) -> tuple[str, ...]:
    run_number, sums = one
    counts = (sums.done_before, sums.done, sums.skipped, sums.interrupted, sums.open, sums.by_hand)
    return str(run_number), *map(str, counts)


def _terminal_row(terminal: tuple[str, int, int]) -> tuple[str, str, str, str]:
    name, insertions, failures = terminal
    return name, str(insertions), str(failures), f"{failures / insertions:.0%}"
