"""Overview: the order and its tasks, the cameras, the four levels, failures, and the figures.

Statistics: what recorded runs have in common.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial

from nicegui import background_tasks, run, ui

from remodel_console.console import Supervisor
from remodel_console.core.commands import DONE
from remodel_console.core.plots import bar_plot, count_height, count_plot, line_plot
from remodel_console.core.use_case import (
    Figures,
    UseCase,
    duration_words,
    figures,
    hand_words,
    level_rows,
)
from remodel_console.core.world import ALL_PARTS, World, supervisor_words
from remodel_console.errors import CommandError
from remodel_console.watched import Viewer
from remodel_console.web.cell_view import CameraView, LiveCell
from remodel_console.web.elements import Plot, card, icon_button, table, time_words
from remodel_console.web.overview_heads import (
    PAUSING,
    LastHead,
    OrderForm,
    RunHead,
    StartCard,
    TaskTable,
)
from remodel_console.web.page import Page
from remodel_run.progress import HandWire, Phase, Sums
from remodel_run.record import Statistics, decision_words, fault_words
from remodel_run.whole_task import counted

_PLOTTED_TASKS = 100  # the latest; the figures are of all


class FigureCards:
    """Shows a card for each figure, once a task has ended.

    Attributes:
        area: the element that has the cards.
    """

    def __init__(self) -> None:
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


Tick = Callable[[str, str, bool], Awaitable[bool]]


class HandList:
    """Shows a row for each wire by hand, with what a person needs to place it."""

    def __init__(self, tick: Tick, *, is_operator: bool) -> None:
        """Build an empty list; `tick` gets product, wire, and whether it is placed."""
        self._tick = tick
        self._is_operator = is_operator
        self._wires: tuple[HandWire, ...] = ()
        self._product = ""
        self._ticked: frozenset[str] = frozenset()
        self._boxes: dict[str, ui.checkbox] = {}
        with ui.element("div").classes("by-hand wide") as self._area:
            self._head = ui.label().classes("heading").props('role="status"')
            self._rows = ui.element("div").classes("wide")

    def show(
        self,
        wires: tuple[HandWire, ...],
        ticked: frozenset[str],
        product: str,
        *,
        is_before: bool,
    ) -> None:
        """Show the wires of a product, and which of them are placed.

        `is_before`: it is not the product that is built now, so that its serial number is shown.
        """
        self._area.set_visibility(bool(wires))
        self._product = product
        if wires != self._wires:
            self._wires = wires
            self._rows.clear()
            with self._rows:
                self._boxes = {wire.name: self._row(wire) for wire in wires}
        self._ticked = ticked
        self._show_ticks()
        words = hand_words(wires, ticked)
        self._head.text = f"{product}, built before. {words}" if is_before else words

    def _show_ticks(self) -> None:
        for name, box in self._boxes.items():
            box.set_value(name in self._ticked)

    async def _on_click(self, name: str, *, is_placed: bool) -> None:
        if is_placed == (name in self._ticked):
            return  # the box shows what another page has ticked
        if not await self._tick(self._product, name, is_placed) and not self._area.is_deleted:
            self._show_ticks()

    def _row(self, wire: HandWire) -> ui.checkbox:
        """Add a row."""
        with ui.element("div").classes("hand-wire"):
            marker = f", marker {wire.marker}" if wire.marker not in ("", wire.name) else ""
            box = ui.checkbox(f"{wire.name}{marker}").props("dense")
            box.set_enabled(self._is_operator)
            box.on_value_change(lambda: self._on_click(wire.name, is_placed=bool(box.value)))
            ui.label(wire.words).classes("line")
            ui.label(f"By hand, because {wire.reason}").classes("line soft")
        return box


_CAMERAS = (
    ("overhead", "From above", "no picture yet; the cell's next observation sends one"),
    ("wrist", "From the hand", "no picture yet; the cell's next observation sends one"),
    ("scene", "The cell", "no picture yet"),
)
_SHOWN_FAILURES = 20  # the latest; the record has all


class OverviewPage(Page):
    """The page of the order that the cell works on (Deliverable 5.1, T3.2)."""

    PARTS = ALL_PARTS
    KEYS = (("Alt+P", "pause or resume the run"),)

    def build(self) -> None:
        """Build the order on the left, the cameras in the middle, what happens on the right."""
        self._use_case: UseCase | None = None
        self._shown: object = None
        self._hand: tuple[str, tuple[HandWire, ...]] = "", ()
        self._ticked: frozenset[str] = frozenset()
        self._gone = ""
        self._pending: list[str] = []
        self._head: RunHead | OrderForm | LastHead | None = None
        self._viewer = Viewer(self.console.pictures)
        ui.context.client.on_delete(lambda: self._viewer.watch(False))
        with ui.element("div").classes("overview"):
            self._arrangement.splitter("Width of the order", "order", is_column=True)
            with ui.element("section").classes("order").props('tabindex="0" aria-label="Order"'):
                self._start_card = StartCard(self)
                self._head_area = ui.element("div").classes("order-head")
                skip, retry = partial(self._do_task, "skip"), partial(self._do_task, "retry")
                self._tasks = TaskTable(skip, retry, is_operator=self.is_operator)
                self._by_hand = HandList(self._tick, is_operator=self.is_operator)
            part, splitter = self._arrangement.part, self._arrangement.splitter
            with ui.element("section").classes("watch").props('tabindex="0" aria-label="Cell"'):
                with part("Cell", "watch"):
                    self._cell = LiveCell(self.console)
                with part("Cameras", "watch"), ui.element("div").classes("cameras"):
                    self._cameras = {name: CameraView(*words) for name, *words in _CAMERAS}
                with part("Figures", "watch"):
                    self._figures = FigureCards()
            splitter("Width of the activity", "panel", is_column=True)
            with ui.element("aside").classes("panel").props('tabindex="0" aria-label="Activity"'):
                with part("Levels", "panel"):
                    ui.label("Activity of each level").classes("heading")
                    self._levels = ui.element("div").classes("levels")
                with part("Failures", "panel"):
                    ui.label("Failures").classes("heading")
                    self._failures = ui.element("div").classes("failures wide")
        self._parts = (self._tasks.area, self._figures.area, self._levels, self._failures)

    def show(self, world: World) -> None:
        """Show the parts that have changed."""
        self._cell.follow(world.use_case)
        self._cameras["scene"].set_visibility(not self._cell.is_available)
        # Have the cell rendered for people where it cannot be drawn here.
        wants = not self._cell.is_available and self._arrangement.is_shown("Cameras")
        self._viewer.watch(wants)
        for camera, view in self._cameras.items():
            picture = self.console.pictures.newest(camera)
            view.show(f"/picture/{camera}?number={picture.number}" if picture else "")
        self._head_area.set_visibility(self._start_card.show(world))
        now = world.use_case or UseCase(Phase.IDLE)
        if now.by_hand:
            self._hand = now.serial, now.by_hand
        elif now.serial or not all(self._hand):
            self._hand = self.console.hand_wires.left()
        product, wires = self._hand  # stays when all are ticked off: a tick may be taken back
        ticked = self.console.hand_wires.ticked(product)
        words = supervisor_words(world, time_words)
        shown = (now, product, ticked, words)
        if shown == self._shown:
            return
        before, self._shown = self._use_case, shown
        self._use_case, self._ticked, self._gone = now, ticked, words
        is_current = world.outdated_s is None
        for part in self._parts:
            part.classes(
                add=None if is_current else "outdated", remove="outdated" if is_current else None
            )
        self._show_head()
        self._tasks.show(now.tasks, is_under_way=now.is_under_way and is_current)
        self._by_hand.show(wires, ticked, product, is_before=product != now.serial)
        self._show_levels(now)
        if before is None or before.failures != now.failures:
            self._show_failures(now)
        # The sums arrive with the state, tasks and failures by messages of their own.
        if before is None or _counted(before) != _counted(now):
            self._figures.show(figures(now))

    def set_in_view(self, is_in_view: bool) -> None:
        """Draw the cell, and request pictures of it, only while the page is in view."""
        self._cell.set_shown(is_in_view and self._arrangement.is_shown("Cell"))
        if not is_in_view:
            self._viewer.watch(False)

    def press_with_alt(self, key: str) -> None:
        """Pause the run, or resume it; a protective stop is released by its button alone."""
        now = self._use_case
        if key != "p" or now is None or not now.is_under_way or self._gone or not self.is_operator:
            return
        if now.phase is Phase.PROTECTIVE_STOP:
            return
        deed = self._resume if now.is_held else self._pause
        with self._dialogs:
            background_tasks.create(deed())

    # The order

    def _show_head(self) -> None:
        """Show the run, or the form that starts one; what is filled in there stays."""
        now = self._use_case or UseCase(Phase.IDLE)
        wanted = LastHead if self._gone else RunHead if now.is_under_way else OrderForm
        if not isinstance(self._head, wanted):
            self._head_area.clear()
            with self._head_area:
                self._head = self._new_head(wanted)
        match self._head:
            case RunHead():
                self._head.show(now, self._pending)
            case OrderForm():
                self._head.show(now, self._ticked)
            case LastHead():
                self._head.show(now, self._gone)

    def _new_head(self, wanted: type) -> RunHead | OrderForm | LastHead:
        if wanted is not RunHead:
            return LastHead() if wanted is LastHead else OrderForm(self, self.start)
        deeds = (self._pause, self._resume, self._ask_stop, self._stop_motion, self._release)
        return RunHead(self.button, *deeds)

    # What happens

    def _show_levels(self, now: UseCase) -> None:
        self._levels.clear()
        with self._levels:
            for number, (word, level) in enumerate(level_rows(now), start=1):
                ui.label(str(number)).classes("number")
                with ui.element("div").classes("level"):
                    ui.label(f"{word}: {level.name}" if level and level.name else word)
                    if level is None or not (level.name or level.doing):
                        ui.label("idle").classes("soft")
                        continue
                    ui.label(level.doing).classes("soft")
                    if level.since_s:
                        time_s = now.stamp_s - level.since_s
                        ui.label(f"for {duration_words(time_s)}").classes("soft")

    def _show_failures(self, now: UseCase) -> None:
        self._failures.clear()
        with self._failures:
            if not now.failures:
                ui.label("None in this run.").classes("soft")
            for failure in reversed(now.failures[-_SHOWN_FAILURES:]):
                with ui.element("div").classes("failure"):
                    ui.label(f"{failure.task}: {fault_words(failure.fault)}").classes("what")
                    ability = f"{failure.ability}: " if failure.ability else ""
                    ui.label(f"{ability}{failure.text}")
                    because = f", because {failure.because}" if failure.because else ""
                    ui.label(f"The cell {decision_words(failure.decision)}{because}.").classes(
                        "soft"
                    )

    # Commands

    async def start(self, order: str, tasks: int, *, again: bool) -> bool:
        """Start an order; return whether the supervisor accepted it.

        Args:
            order: its name.
            tasks: how many of its tasks, from the first; 0 for all.
            again: repeat finished tasks, on an empty panel.
        """
        what = f"run order '{order}'"
        what += f", its first {counted(tasks, 'task')}" if tasks else ""
        what += ", on an empty panel" if again else ""
        return await self._give(
            what, lambda supervisor, by: supervisor.run(order, tasks, by, again=again)
        )

    async def _give(
        self, what: str, deed: Callable[[Supervisor, str], str], pending: str = ""
    ) -> bool:
        """Give a command to the supervisor, and return whether it was accepted.

        Args:
            what: the command, for the record.
            deed: gives it.
            pending: what the page shows until it is answered, which may take as long as an
                operation; empty for commands that are answered at once.
        """
        by = self.actor.name

        def do() -> str:
            return self.console.command(lambda supervisor: deed(supervisor, by))

        if not pending:
            return (await self.give(what, do)).state == DONE
        self._pending.append(pending)
        self._show_head()
        try:
            return (await self.give(what, do)).state == DONE
        finally:
            self._pending.remove(pending)
            if not self._head_area.is_deleted:
                self._show_head()

    async def _pause(self) -> None:
        if PAUSING not in self._pending:
            await self._give("pause the run", lambda supervisor, by: supervisor.pause(by), PAUSING)

    async def _resume(self) -> None:
        await self._give("resume the run", lambda supervisor, by: supervisor.resume(by))

    async def _release(self) -> None:
        await self._give(
            "release the protective stop", lambda supervisor, by: supervisor.release(by)
        )

    async def _stop_motion(self) -> None:
        """Stop all motion, without a question first: it costs nothing but time."""
        await self._give(
            "protective stop",
            lambda supervisor, by: supervisor.protective_stop(by),
            "stopping all motion",
        )

    def _ask_stop(self) -> None:
        async def stop() -> None:
            await self._give(
                "stop the run", lambda supervisor, by: supervisor.stop(by), "stopping the run"
            )

        self.ask("Stop the run safely? Finished tasks stay done.", "Stop the run", stop)

    async def _tick(self, product: str, wire: str, is_placed: bool) -> bool:
        """Tick a wire by hand off, or take its tick back; returns whether that is kept."""
        what = f"wire {wire} of {product} is placed by hand"
        answer = await self.give(
            what if is_placed else f"take back: {what}",
            lambda: self.console.hand_wires.tick(product, wire, is_placed=is_placed),
        )
        return answer.state == DONE

    async def _do_task(self, word: str, task: str) -> None:
        def deed(supervisor: Supervisor, by: str) -> str:
            command = supervisor.skip if word == "skip" else supervisor.retry
            return command(task, by)

        pending = f"skipping {task}" if word == "skip" else ""
        await self._give(f"{word} task {task}", deed, pending)


def _counted(use_case: UseCase) -> tuple[object, ...]:
    """Return what the figures depend on."""
    return use_case.sums, use_case.tasks, use_case.failures


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
                icon_button("refresh", "Reload", self._load)
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
