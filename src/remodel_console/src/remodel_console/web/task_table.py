"""The tasks of an order as a table, whose rows stay while they change: no click is lost."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from nicegui import ui

from remodel_console.core.use_case import Task, TaskPhase, duration_words, shown_tasks

_WORDS = {
    TaskPhase.WAITING: "waiting",
    TaskPhase.RUNNING: "runs",
    TaskPhase.DONE: "done",
    TaskPhase.SET_ASIDE: "set aside",
}
_OPEN = (TaskPhase.WAITING, TaskPhase.RUNNING)

Deed = Callable[[str], object]


class TaskTable:
    """Shows tasks with state, tries and time; offers to skip those that are open, and so on."""

    def __init__(self, skip: Deed, retry: Deed, *, is_operator: bool) -> None:
        """Build an empty table; `skip` and `retry` get the name of a task."""
        self._deeds = {"Skip": skip, "Retry": retry}
        self._is_operator = is_operator
        self._area = ui.element("div").classes("tasks")
        self._more = ui.label().classes("soft")
        self._rows: dict[str, _Row] = {}

    def show(self, all_tasks: tuple[Task, ...], *, is_under_way: bool) -> None:
        """Show tasks, in their order; of many, those around the current one."""
        tasks = shown_tasks(all_tasks)
        self._more.text = f"{len(tasks)} of {len(all_tasks)} tasks are shown."
        self._more.set_visibility(len(tasks) < len(all_tasks))
        if [task.name for task in tasks] != list(self._rows):
            self._build(tasks)
        for task in tasks:
            self._rows[task.name].show(task, is_under_way=is_under_way)

    def _build(self, tasks: tuple[Task, ...]) -> None:
        self._area.clear()
        self._rows.clear()
        if not tasks:
            return
        with self._area, ui.element("table").classes("plain"):
            with ui.element("tr"):
                for head in ("Task", "State", "Tries", "Time", ""):
                    with ui.element("th"):
                        ui.label(head)
            for task in tasks:
                self._rows[task.name] = _Row(task, self._deeds, self._is_operator)


class _Row:
    """A task."""

    def __init__(self, task: Task, deeds: dict[str, Deed], is_operator: bool) -> None:
        self._shown: tuple[Task, bool] | None = None
        with ui.element("tr") as self._row:
            with ui.element("td").classes("name"):
                ui.label(task.name)
                ui.label(task.description).classes("description")
            self._phase, self._tries, self._time = _cell("phase"), _cell("tries"), _cell("time")
            with ui.element("td").classes("deeds"):
                self._skip = _button("Skip", "skip_next", task.name, deeds, is_operator)
                self._retry = _button("Retry", "replay", task.name, deeds, is_operator)

    def show(self, task: Task, *, is_under_way: bool) -> None:
        """Show what may have changed."""
        if self._shown == (task, is_under_way):
            return
        self._shown = (task, is_under_way)
        self._row.classes(replace=f"task {task.phase.value}")
        self._phase.text = _WORDS[task.phase]
        self._tries.text = str(task.attempts or "")
        self._time.text = _time_words(task)
        self._skip.set_visibility(is_under_way and task.phase in _OPEN)
        self._retry.set_visibility(is_under_way and task.phase is TaskPhase.SET_ASIDE)


def _cell(style: str) -> ui.label:
    with ui.element("td").classes(style):
        return ui.label()


def _button(
    word: str, icon: str, task: str, deeds: dict[str, Deed], is_operator: bool
) -> ui.button:
    made = ui.button(icon=icon, on_click=partial(deeds[word], task), color=None)
    made.props(f'flat dense round title="{word} {task}" aria-label="{word} {task}"')
    made.set_enabled(is_operator)
    return made


def _time_words(task: Task) -> str:
    """Return what a task has taken, and what it still takes."""
    taken = duration_words(task.taken_s) if task.taken_s else ""
    left = f"{duration_words(task.expected_s)} left" if task.expected_s else ""
    return ", ".join(filter(None, (taken, left)))
