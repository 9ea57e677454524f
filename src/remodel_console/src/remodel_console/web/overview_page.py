"""Overview: the order and its tasks, the cameras, the four levels, failures, and the figures."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from nicegui import background_tasks, ui

from remodel_console.console import Supervisor
from remodel_console.core.answer import DONE
from remodel_console.core.plot import bar_plot, count_plot, line_plot
from remodel_console.core.production import Figures, figures
from remodel_console.core.use_case import (
    Choice,
    Phase,
    Question,
    Task,
    TaskPhase,
    UseCase,
    decision_words,
    duration_words,
    fault_words,
    level_rows,
)
from remodel_console.core.world import Notice, World, supervisor_notice
from remodel_console.web.camera_view import CameraView
from remodel_console.web.order_form import OrderForm
from remodel_console.web.page import Page

_CAMERAS = (
    ("overhead", "From above", "no picture yet: it takes one when the cell looks"),
    ("wrist", "From the hand", "no picture yet: it takes one when the cell looks"),
    ("scene", "The cell", "no picture yet"),
)
_TASK_WORDS = {
    TaskPhase.WAITING: "waiting",
    TaskPhase.RUNNING: "runs",
    TaskPhase.DONE: "done",
    TaskPhase.SET_ASIDE: "set aside",
}
_SHOWN_FAILURES = 20  # the latest; the record has all


class OverviewPage(Page):
    """The page of the order that the cell works on (Deliverable 5.1, T3.2)."""

    KEYS = (("P", "pause the run, or let it go on"),)

    def build(self) -> None:
        """Build the order on the left, the cameras in the middle, what happens on the right."""
        self._use_case: UseCase | None = None
        self._form: OrderForm | None = None
        pictures = self.console.pictures
        pictures.add_viewer(1)
        ui.context.client.on_delete(lambda: pictures.add_viewer(-1))
        with ui.element("div").classes("overview"):
            with ui.element("section").classes("order"):
                self._head = ui.element("div").classes("order-head")
                self._tasks = ui.element("div").classes("tasks")
            with ui.element("section").classes("watch"):
                with ui.element("div").classes("cameras"):
                    self._cameras = {name: CameraView(*words) for name, *words in _CAMERAS}
                self._figures = ui.element("div").classes("figures")
            with ui.element("aside").classes("panel"):
                self._question = ui.element("div").classes("wide")
                ui.label("What each level does").classes("heading")
                self._levels = ui.element("div").classes("levels")
                ui.label("Failures").classes("heading")
                self._failures = ui.element("div").classes("failures wide")

    def more_notices(self, world: World) -> Iterable[Notice]:
        """Return whether the supervisor is away."""
        return supervisor_notice(world)

    def show(self, world: World) -> None:
        """Show the parts that have changed."""
        for camera, view in self._cameras.items():
            picture = self.console.pictures.newest(camera)
            view.show(f"/picture/{camera}?number={picture.number}" if picture else "")
        now = world.use_case or UseCase(Phase.IDLE)
        if now == self._use_case:
            return
        before, self._use_case = self._use_case, now
        self._show_head(now)
        if before is None or before.tasks != now.tasks:
            self._show_tasks(now)
        if before is None or before.question != now.question:
            self._show_question(now.question)
        if before is None or before.levels != now.levels:
            self._show_levels(now)
        if before is None or before.failures != now.failures:
            self._show_failures(now)
        found = figures(now)
        if before is None or figures(before) != found:
            self._show_figures(found)

    def press(self, key: str, *, ctrl: bool) -> None:
        """Pause the run, or let it go on."""
        now = self._use_case
        if key.lower() != "p" or ctrl or now is None or not now.is_under_way:
            return
        deed = self._resume if now.phase is Phase.PAUSED else self._pause
        with self._dialogs:
            background_tasks.create(deed())

    # The order

    def _show_head(self, now: UseCase) -> None:
        """Show the run, or the form that starts one; what is filled in there stays."""
        if now.is_under_way:
            self._form = None
            self._head.clear()
            with self._head:
                self._show_run(now)
            return
        if self._form is None:
            self._head.clear()
            with self._head:
                self._form = OrderForm(self)
        self._form.show(now)

    def _show_run(self, now: UseCase) -> None:
        with ui.row().classes("headline"):
            ui.label(now.order).classes("title")
            ui.label(now.phase.words).classes(f"state {_style(now.phase)}")
            if now.run:
                ui.link(f"run {now.run}", f"/replay?run={now.run}").classes("soft")
        done, total = now.count(TaskPhase.DONE), len(now.tasks)
        aside = now.count(TaskPhase.SET_ASIDE)
        words = f"{done} of {total} tasks done"
        words += f", {aside} set aside" if aside else ""
        words += f"; about {duration_words(now.left_s)} left" if now.left_s else ""
        with ui.element("div").classes("progress wide").props('role="img"') as bar:
            bar.props(f'aria-label="{words}"')
            ui.element("div").classes("part done").style(f"width: {_percent(done, total)}")
            ui.element("div").classes("part aside").style(f"width: {_percent(aside, total)}")
        ui.label(words).classes("soft")
        if now.message:
            ui.label(now.message)
        if now.interruptions:
            ui.label(
                f"It went on after {now.interruptions} interruptions."
                if now.interruptions > 1
                else "It went on after an interruption."
            ).classes("soft")
        with ui.row().classes("controls"):
            if now.phase is Phase.PAUSED:
                self.button("Go on", self._resume, icon="play_arrow")
            else:
                self.button("Pause", self._pause, icon="pause", look="quiet")
            self.button("Stop", self._ask_stop, icon="stop", look="stop")

    def _show_tasks(self, now: UseCase) -> None:
        self._tasks.clear()
        if not now.tasks:
            return
        with self._tasks, ui.element("table").classes("plain"):
            with ui.element("tr"):
                for head in ("Task", "State", "Tries", "Time", ""):
                    _cell("th", head)
            for task in now.tasks:
                with ui.element("tr").classes(f"task {task.phase.value}"):
                    self._show_task(task, is_under_way=now.is_under_way)

    def _show_task(self, task: Task, *, is_under_way: bool) -> None:
        with ui.element("td").classes("name"):
            ui.label(task.name)
            ui.label(task.description).classes("description")
        _cell("td", _TASK_WORDS[task.phase], "phase")
        _cell("td", str(task.attempts or ""))
        _cell("td", _time_words(task), "time")
        with ui.element("td").classes("deeds"):
            if not is_under_way:
                return
            if task.phase in (TaskPhase.WAITING, TaskPhase.RUNNING):
                self._deed("Skip", task, "skip_next")
            elif task.phase is TaskPhase.SET_ASIDE:
                self._deed("Retry", task, "replay")

    def _deed(self, word: str, task: Task, icon: str) -> None:
        made = ui.button(icon=icon, on_click=partial(self._do_task, word.lower(), task), color=None)
        made.props(f'flat dense round title="{word} {task.name}" aria-label="{word} {task.name}"')
        made.set_enabled(self.is_operator)

    # What happens

    def _show_question(self, question: Question | None) -> None:
        """Show what the run asks, and a button for each answer."""
        self._question.clear()
        if question is None:
            return
        with self._question, ui.element("div").classes("request").props('role="alert"'):
            ui.label(f"{question.task}: the cell needs you").classes("question")
            ui.label(question.text)
            for place, choice in enumerate(question.choices):
                look = "main" if place == 0 else "quiet"
                made = self.button(choice.words, partial(self._answer, question, choice), look=look)
                with made.classes("choice"):
                    ui.label(choice.meaning).classes("meaning")

    def _show_levels(self, now: UseCase) -> None:
        self._levels.clear()
        with self._levels:
            for number, (word, level) in enumerate(level_rows(now), start=1):
                ui.label(str(number)).classes("number")
                with ui.element("div").classes("level"):
                    ui.label(f"{word}: {level.name}" if level and level.name else word)
                    ui.label(level.doing if level else "nothing").classes("soft")

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

    def _show_figures(self, found: Figures) -> None:
        self._figures.clear()
        yield_words = "-" if found.first_pass_yield is None else f"{found.first_pass_yield:.0%}"
        cycle = "-" if found.mean_cycle_s is None else duration_words(found.mean_cycle_s)
        recovered = str(sum(count for _, count in found.recoveries))
        with self._figures:
            _plot(
                "First-pass yield",
                yield_words,
                line_plot("First-pass yield over tasks", found.tasks, found.yields, 1.0),
            )
            _plot(
                "Cycle time",
                f"{cycle} on average" if found.tasks else cycle,
                bar_plot("Time of each task", found.tasks, found.cycles_s, "s"),
            )
            _plot(
                "Recoveries by cause",
                recovered,
                count_plot("Recoveries by cause", found.recoveries),
            )

    # Deeds

    async def start(self, order: str, tasks: int) -> bool:
        """Start an order; tell whether the supervisor took it."""
        what = f"run order '{order}'" + (f", its first {tasks} tasks" if tasks else "")
        return await self._give(what, lambda supervisor, by: supervisor.run(order, tasks, by))

    async def _give(self, what: str, deed: Callable[[Supervisor, str], str]) -> bool:
        """Give a command to the supervisor, and tell whether it was taken."""
        by = self.actor.name

        def do() -> str:
            return self.console.command(lambda supervisor: deed(supervisor, by))

        return (await self.give(what, do)).state == DONE

    async def _pause(self) -> None:
        await self._give("pause the run", lambda supervisor, by: supervisor.pause(by))

    async def _resume(self) -> None:
        await self._give("go on with the run", lambda supervisor, by: supervisor.resume(by))

    def _ask_stop(self) -> None:
        async def stop() -> None:
            await self._give("stop the run", lambda supervisor, by: supervisor.stop(by))

        self.ask("Stop the run safely? What is done stays done.", "Stop the run", stop)

    async def _do_task(self, word: str, task: Task) -> None:
        def deed(supervisor: Supervisor, by: str) -> str:
            command = supervisor.skip if word == "skip" else supervisor.retry
            return command(task.name, by)

        await self._give(f"{word} task {task.name}", deed)

    async def _answer(self, question: Question, choice: Choice) -> None:
        number = question.number
        await self._give(
            f"answer question {number} about {question.task}: {choice.words}",
            lambda supervisor, by: supervisor.answer(number, choice, by),
        )


def _style(phase: Phase) -> str:
    return {Phase.ASKING: "asking", Phase.PAUSED: "paused"}.get(phase, "running")


def _percent(part: int, total: int) -> str:
    return f"{100 * part / total:.1f}%" if total else "0"


def _time_words(task: Task) -> str:
    """Return what a task has taken, and what it still takes."""
    taken = duration_words(task.taken_s) if task.taken_s else ""
    left = f"{duration_words(task.expected_s)} left" if task.expected_s else ""
    return ", ".join(filter(None, (taken, left)))


def _cell(tag: str, text: str, style: str = "") -> None:
    with ui.element(tag).classes(style):
        ui.label(text)


def _plot(title: str, figure: str, svg: str) -> None:
    with ui.element("div").classes("card plot-card"):
        with ui.row().classes("plot-head"):
            ui.label(title).classes("soft")
            ui.label(figure).classes("figure")
        ui.html(svg, sanitize=False).classes("wide")
