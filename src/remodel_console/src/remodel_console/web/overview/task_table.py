"""The tasks of an order as a table, whose rows stay while they change: no click is lost."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from nicegui import ui

from remodel_console.core.cell.wire_history import PHASE_WORDS
from remodel_console.core.use_case.use_case import Task, TaskPhase, duration_words, shown_tasks

_OPEN = (TaskPhase.WAITING, TaskPhase.RUNNING)

Deed = Callable[[str], object]


class TaskTable:
    """Shows tasks with state, attempts and time; offers to skip open and retry skipped ones."""

    def __init__(self, skip: Deed, retry: Deed, *, is_operator: bool) -> None:
        """Build an empty table; `skip` and `retry` get the name of a task."""
        self._deeds = {"Skip": skip, "Retry": retry}
        self._is_operator = is_operator
        with (
            ui.element("div").classes("tasks"),
            ui.element("table").classes("plain") as self._table,
            ui.element("tr"),
        ):
            for head in ("Task", "State", "Attempts", "Time", "Commands"):
                with ui.element("th"):
                    ui.label(head).classes("unseen" if head == "Commands" else "")
        self._more = ui.label().classes("soft")
        self._rows: dict[str, _Row] = {}

    def show(self, all_tasks: tuple[Task, ...], *, is_under_way: bool) -> None:
        """Show tasks, in their order; of many, those around the current one."""
        tasks = shown_tasks(all_tasks)
        self._table.set_visibility(bool(tasks))
        self._more.text = f"{len(tasks)} of {len(all_tasks)} tasks are shown."
        self._more.set_visibility(len(tasks) < len(all_tasks))
        self._arrange([task.name for task in tasks])
        for task in tasks:
            self._rows[task.name].show(task, is_under_way=is_under_way)

    def _arrange(self, names: list[str]) -> None:
        """Have a row for each task, in this order; those that there are move."""
        if names == list(self._rows):
            return
        for name in self._rows.keys() - set(names):
            self._rows.pop(name).element.delete()
        with self._table:
            for name in names:
                if name not in self._rows:
                    self._rows[name] = _Row(name, self._deeds, self._is_operator)
        rows = self._table.default_slot.children
        for place, name in enumerate(names, start=1):  # after the heads
            row = self._rows[name].element
            if rows[place] is not row:
                row.move(target_index=place)
        self._rows = {name: self._rows[name] for name in names}


class _Row:
    """A task."""

    def __init__(self, name: str, deeds: dict[str, Deed], is_operator: bool) -> None:
        self._shown: tuple[Task, bool] | None = None
        with ui.element("tr") as self.element:
            with ui.element("td").classes("name"):
                ui.label(name)
                self._description = ui.label().classes("description")
            self._phase, self._attempts, self._time = (
                _cell("phase"),
                _cell("attempts"),
                _cell("time"),
            )
            with ui.element("td").classes("deeds"):
                self._skip = _button("Skip", "skip_next", name, deeds, is_operator=is_operator)
                self._retry = _button("Retry", "replay", name, deeds, is_operator=is_operator)

    def show(self, task: Task, *, is_under_way: bool) -> None:
        """Show what may have changed."""
        if self._shown == (task, is_under_way):
            return
        self._shown = (task, is_under_way)
        self._description.text = task.description
        self.element.classes(replace=f"task {task.phase.value}")
        self._phase.text = PHASE_WORDS[task.phase]
        self._attempts.text = str(task.attempts or "")
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
