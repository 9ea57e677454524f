"""The form that starts an order: which, and how many of its tasks."""

from __future__ import annotations

from collections.abc import Awaitable, Collection
from typing import Protocol

from nicegui import run, ui

from remodel_console.core.use_case.use_case import UseCase
from remodel_console.errors import CommandError
from remodel_console.web.page import Page
from remodel_run.progress import Phase, sums_words


class StartOrder(Protocol):
    """Asks the supervisor to start an order."""

    def __call__(self, order: str, tasks: int, *, again: bool) -> Awaitable[object]:
        """Start it: at most so many tasks (0: all), `again` also those that are done."""


class OrderForm:
    """Shows how the last run ended, and starts another."""

    def __init__(self, page: Page, start: StartOrder) -> None:
        """Build the form."""
        self._page = page
        self._start_order = start
        with ui.element("div").classes("ending") as self._ending:
            self._words = ui.label()
            self._sums = ui.label()
            self._link = ui.link("Replay this run")
        self._order = ui.select(
            [], label="Order", with_input=True, new_value_mode="add-unique", clearable=True
        )
        self._order.props("outlined dense").classes("wide").set_enabled(page.is_operator)
        self._order.on("focus", self._list)
        self._tasks = ui.number("Number of tasks", min=1, step=1, placeholder="all")
        self._tasks.props("outlined dense stack-label").classes("wide")
        self._tasks.set_enabled(page.is_operator)
        self._again = ui.checkbox("The panel is empty: repeat finished tasks")
        self._again.props("dense").set_enabled(page.is_operator)
        page.button("Start the order", self._start, icon="play_arrow")

    def show(self, now: UseCase, ticked: Collection[str]) -> None:
        """Show how the last run ended, or why no order can be taken.

        Args:
            now: the last run.
            ticked: its wires by hand that are placed.
        """
        is_over = now.phase is Phase.ENDED
        words = f"Order '{now.order}', run {now.run}: {now.message}" if is_over else now.message
        self._ending.set_visibility(bool(words))
        is_all_done = is_over and now.sums.is_complete and len(ticked) >= now.sums.by_hand
        # Not `replace`, which would show again what is hidden.
        self._ending.classes(add="" if is_all_done else "bad", remove="bad" if is_all_done else "")
        self._words.text = words
        self._sums.text = f"{sums_words(now.sums)}." if is_over else ""
        self._sums.set_visibility(is_over)
        self._link.set_visibility(now.run > 0)
        self._link.props(f'href="/replay?run={now.run}"')
        if is_over and self._order.value is None:
            self._order.set_options([now.order], value=now.order)  # to go on with what is left

    async def _list(self) -> None:
        """Offer the orders that the production database has."""
        recorder = self._page.console.recorder
        try:
            orders = (await run.io_bound(recorder.orders)) if recorder else ()
        except CommandError:
            return  # a name can be typed
        known = {*orders, self._order.value} - {None, ""}
        self._order.set_options(sorted(known), value=self._order.value)

    async def _start(self) -> None:
        order = str(self._order.value or "").strip()
        if not order:
            ui.notify("Choose the order, or type its name.", type="warning")
            return
        tasks = int(self._tasks.value or 0)
        await self._start_order(order, tasks, again=bool(self._again.value))
