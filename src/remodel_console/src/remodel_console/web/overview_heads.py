"""The head of the overview: what starts, the order's form, the run; and the table of tasks."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Collection, Iterable
from functools import partial

from nicegui import run, ui

from remodel_console.core.commands import DONE
from remodel_console.core.use_case import (
    CableTask,
    Task,
    UseCase,
    duration_words,
    shown_tasks,
    stop_words,
    with_cables,
)
from remodel_console.core.world import Part, World
from remodel_console.errors import CommandError
from remodel_console.web.bar import Button
from remodel_console.web.elements import icon_button, text_in
from remodel_console.web.page import Page
from remodel_run.progress import Count, Phase, TaskPhase, sums_words


class LastHead:
    """Shows why nothing can be started or commanded, and what was known last, without a button."""

    def __init__(self) -> None:
        with ui.element("div").classes("ending bad").props('role="alert"'):
            self._words = ui.label()
        with ui.element("div").classes("outdated wide") as self._run:
            with ui.row().classes("headline"):
                self._title = ui.label().classes("title")
                self._phase = ui.label().classes("state away")
                self._serial = ui.label().classes("soft")
            self._progress = ui.label().classes("soft")
            self._message = ui.label()

    def show(self, last: UseCase, words: str) -> None:
        """Show what was known last, and why that is all."""
        self._words.text = words
        self._run.set_visibility(last.run > 0)
        self._title.text, self._serial.text = last.order, last.serial
        self._phase.text = f"was: {last.phase.words}"
        self._progress.text = sums_words(last.sums)
        self._message.text = last.message


class OrderForm:
    """Shows how the last run ended, and starts another."""

    def __init__(self, page: Page, start: Callable[..., Awaitable[object]]) -> None:
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


# What the page shows until a pause is answered.
PAUSING = "pausing"

Deed = Callable[[], object]
_STYLES = {
    Phase.ASKING: "asking",
    Phase.PAUSING: "asking",
    Phase.PAUSED: "paused",
    Phase.PROTECTIVE_STOP: "away",
}


class RunHead:
    """Shows a run; its elements stay while it changes, and Stop in its place: no click is lost."""

    def __init__(
        self,
        button: Button,
        pause: Deed,
        resume: Deed,
        stop: Deed,
        protective_stop: Deed,
        release: Deed,
    ) -> None:
        """Build it; `button` makes buttons that only operators can press."""
        with ui.element("div").classes("protective").props('role="alert"') as self._banner:
            self._stopped_by = ui.label().classes("question")
            self._how_to_release = ui.label()
            self._release = button("Release the protective stop", release, icon="lock_open")
        with ui.row().classes("headline"):
            self._title = ui.label().classes("title")
            self._phase = ui.label()
            self._link = ui.link().classes("soft")
            self._serial = ui.label().classes("soft")
        with ui.row().classes("controls"):
            self._resume = button("Resume", resume, icon="play_arrow")
            self._pause = button("Pause", pause, icon="pause", look="quiet")
            button("Stop", stop, icon="stop", look="stop")
        self._protect = button("Protective stop", protective_stop, icon="front_hand", look="stop")
        self._protect.classes("protect")
        self._pending = ui.label().classes("soft").props('role="status"')
        self._pending.set_visibility(False)
        with ui.element("div").classes("progress wide").props('role="img"') as self._bar:
            self._done = ui.element("div").classes("part done")
            self._aside = ui.element("div").classes("part aside")
        self._progress = ui.label().classes("soft")
        self._message = ui.label()
        self._interruptions = ui.label().classes("soft")

    def show(self, now: UseCase, pending: Iterable[str] = ()) -> None:
        """Show what may have changed.

        Args:
            now: the run.
            pending: commands that the supervisor has not answered yet, such as "pausing".
        """
        self._show_protective_stop(now)
        self._title.text = now.order
        self._serial.text = now.serial
        self._phase.text = now.phase.words
        self._phase.classes(replace=f"state {_STYLES.get(now.phase, 'running')}")
        self._link.text = f"run {now.run}" if now.run else ""
        self._link.props(f'href="/replay?run={now.run}"')
        words = _progress_words(now)
        self._progress.text = words
        self._bar.props(f'aria-label="{words}"')
        self._done.style(f"width: {_percent(now.sums.done_in_all, now.sums.tasks)}")
        self._aside.style(f"width: {_percent(now.sums.skipped, now.sums.tasks)}")
        self._message.text = now.message
        self._message.set_visibility(bool(now.message) and now.phase is not Phase.ASKING)
        self._interruptions.text = _interruption_words(now.interruptions)
        self._interruptions.set_visibility(now.interruptions > 0)
        commands = tuple(pending)
        self._resume.set_visibility(now.is_held and now.phase is not Phase.PROTECTIVE_STOP)
        self._pause.set_visibility(not now.is_held and PAUSING not in commands)
        self._pending.text = " ".join(f"{command}…" for command in commands)
        self._pending.set_visibility(bool(commands))

    def _show_protective_stop(self, now: UseCase) -> None:
        is_stopped = now.phase is Phase.PROTECTIVE_STOP
        self._banner.set_visibility(is_stopped)
        self._protect.set_visibility(not is_stopped)
        self._release.set_visibility(now.is_releasable)
        self._stopped_by.text, self._how_to_release.text = stop_words(now)


def _progress_words(now: UseCase) -> str:
    if not now.run:
        return ""
    words = f"{sums_words(now.sums)}; {duration_words(now.worked_s)} of work so far"
    return words + (f", about {duration_words(now.left_s)} left" if now.left_s else "")


def _interruption_words(count: int) -> str:
    what = "an interruption" if count == 1 else f"{count} interruptions"
    return f"Resumed after {what}."


def _percent(part: int, total: int) -> str:
    return f"{100 * part / total:.1f}%" if total else "0"


_CELLS = {
    False: ("Simulated cell", "physics and cameras; a wire takes about a minute"),
    True: ("Fake cell", "no physics and no pictures; abilities answer at once"),
}
_NEXT = "Orders of your own: drop a wire list or a design on the Order desk."


class StartCard:
    """Built once; shown while nothing runs, and while what was started here is starting."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self._everything = page.console.everything
        with ui.element("div").classes("start-card wide") as self._card:
            self._title = ui.label().classes("title")
            self._words = ui.label().classes("soft")
            self._trouble = ui.label().classes("code lines")
            with ui.column().classes("choices") as self._choices:
                for fake, (name, means) in _CELLS.items():
                    page.button(name, partial(self._start, fake), icon="play_arrow")
                    ui.label(means).classes("soft")
            self._stop = page.button("Stop what was started here", self._end, look="quiet")

    def show(self, world: World) -> bool:
        """Show what fits; return whether an order can be started."""
        runs = [part for part in (Part.ENGINE, Part.SUPERVISOR, Part.CELL) if world.has(part)]
        is_ours, trouble = self._everything.is_running, self._everything.trouble
        is_starting = is_ours and len(runs) < 3
        is_lost = world.has_lost_run and not self._everything.was_ended
        is_offered = not runs and not is_ours and not is_lost
        self._card.set_visibility(is_offered or is_ours)
        self._choices.set_visibility(is_offered)
        self._stop.set_visibility(is_ours)
        self._trouble.set_visibility(bool(trouble))
        self._trouble.text = trouble
        if is_offered:
            self._title.text = "Nothing runs here" if not trouble else "It has ended by itself"
            self._words.text = (
                "Start engine, supervisor and a cell on this computer, and wire the first wires of "
                "a sample order:"
            )
        elif is_starting:
            missing = {Part.ENGINE, Part.SUPERVISOR, Part.CELL} - set(runs)
            names = ", ".join(sorted(part.value for part in missing))
            self._title.text, self._words.text = "Starting", f"waiting for: {names}"
        else:
            self._title.text, self._words.text = "Started here", _NEXT
        return not is_offered and not is_starting

    async def _start(self, fake: bool) -> None:
        page, name = self._page, _CELLS[fake][0].lower()
        by = page.actor.name
        answer = await page.give(
            f"start everything with a {name}",
            lambda: page.console.start_everything(by, fake=fake),
        )
        if answer.state == DONE and not self._card.is_deleted:
            self.show(page.console.live.world)

    def _end(self) -> None:
        page = self._page
        page.ask(
            "Stop engine, supervisor and cell? A run that is under way is interrupted.",
            "Stop them",
            lambda: page.give("stop what was started here", page.console.stop_everything),
        )


_OPEN = (TaskPhase.WAITING, TaskPhase.RUNNING)

TaskDeed = Callable[[str], object]


class TaskTable:
    """Shows tasks with state, attempts and time; offers to skip open and retry skipped ones.

    Attributes:
        area: the element that is the table.
    """

    def __init__(self, skip: TaskDeed, retry: TaskDeed, *, is_operator: bool) -> None:
        """Build an empty table; `skip` and `retry` get the name of a task."""
        self._new_row = partial(_Row, skip=skip, retry=retry, is_operator=is_operator)
        with (
            ui.element("div").classes("tasks") as self.area,
            ui.element("table").classes("plain") as self._table,
            ui.element("tr"),
        ):
            for head in ("Task", "State", "Attempts", "Time"):
                text_in("th", head)
            text_in("th", "Commands").classes("unseen")
        self._more = ui.label().classes("soft")
        self._rows: dict[tuple[str, bool], _Row] = {}

    def show(self, all_tasks: tuple[Task, ...], *, is_under_way: bool) -> None:
        """Show tasks, in their order; of many, those around the current one."""
        tasks = shown_tasks(all_tasks)
        self._table.set_visibility(bool(tasks))
        self._more.text = f"{len(tasks)} of {len(all_tasks)} tasks are shown."
        self._more.set_visibility(len(tasks) < len(all_tasks))
        shown = {_key(each): each for each in with_cables(tasks)}
        self._arrange(shown)
        for key, each in shown.items():
            self._rows[key].show(each, is_under_way=is_under_way)

    def _arrange(self, shown: dict[tuple[str, bool], CableTask | Task]) -> None:
        """Have a row for each task and cable, in this order; those that there are move."""
        if list(shown) == list(self._rows):
            return
        for key in self._rows.keys() - shown.keys():
            self._rows.pop(key).element.delete()
        with self._table:
            for key, each in shown.items():
                if key not in self._rows:
                    self._rows[key] = self._new_row(each)
        rows = self._table.default_slot.children
        for place, key in enumerate(shown, start=1):  # after the heads
            row = self._rows[key].element
            if rows[place] is not row:
                row.move(target_index=place)
        self._rows = {key: self._rows[key] for key in shown}


def _key(each: CableTask | Task) -> tuple[str, bool]:
    """Return what a row stays the same for: a task, or the cable before the first of its cores."""
    return (each.cores[0].name, True) if isinstance(each, CableTask) else (each.name, False)


class _Row:
    """A task, or a cable, whose cores are skipped and retried one by one."""

    def __init__(
        self, shown: CableTask | Task, skip: TaskDeed, retry: TaskDeed, *, is_operator: bool
    ) -> None:
        self._shown: tuple[CableTask | Task, bool] | None = None
        name = shown.name
        with ui.element("tr") as self.element:
            with ui.element("td").classes("name"):
                ui.label(name)
                self._description = ui.label().classes("description")
            self._phase = text_in("td", "", "phase")
            self._attempts = text_in("td", "", "attempts")
            self._time = text_in("td", "", "time")
            with ui.element("td").classes("deeds"):
                if isinstance(shown, Task):
                    self._skip = icon_button("skip_next", f"Skip {name}", partial(skip, name))
                    self._retry = icon_button("replay", f"Retry {name}", partial(retry, name))
                    for button in (self._skip, self._retry):
                        button.set_enabled(is_operator)

    def show(self, task: CableTask | Task, *, is_under_way: bool) -> None:
        """Show what may have changed."""
        if self._shown == (task, is_under_way):
            return
        self._shown = (task, is_under_way)
        self._phase.text = task.words
        self._time.text = _time_words(task, is_under_way=is_under_way)
        self._description.text = task.description
        if isinstance(task, CableTask):
            self.element.classes(replace=f"cable {task.phase.value}")
            return
        kind = "task core" if task.cable else "task"
        style = task.counts_as.value if task.counts_as is Count.INTERRUPTED else task.phase.value
        self.element.classes(replace=f"{kind} {style}")
        self._attempts.text = str(task.attempts or "")
        self._skip.set_visibility(is_under_way and task.phase in _OPEN)
        self._retry.set_visibility(is_under_way and task.phase is TaskPhase.SET_ASIDE)


def _time_words(task: CableTask | Task, *, is_under_way: bool) -> str:
    """Return what a task has taken, and what it still takes in a run that is under way."""
    taken = duration_words(task.taken_s) if task.taken_s else ""
    is_left = is_under_way and task.expected_s
    left = f"{duration_words(task.expected_s)} left" if is_left else ""
    return ", ".join(filter(None, (taken, left)))
