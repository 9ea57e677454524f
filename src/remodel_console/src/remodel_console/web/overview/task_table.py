"""The tasks of an order as a table, whose rows stay while they change: no click is lost."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from nicegui import ui

from remodel_console.core.use_case.use_case import (
    CableTask,
    Task,
    duration_words,
    shown_tasks,
    with_cables,
)
from remodel_run.progress import Count, TaskPhase

_OPEN = (TaskPhase.WAITING, TaskPhase.RUNNING)

Deed = Callable[[str], object]


class TaskTable:
    """Shows tasks with state, attempts and time; offers to skip open and retry skipped ones.

    Attributes:
        area: the element that is the table.
    """

    def __init__(self, skip: Deed, retry: Deed, *, is_operator: bool) -> None:
        """Build an empty table; `skip` and `retry` get the name of a task."""
        self._deeds = {"Skip": skip, "Retry": retry}
        self._is_operator = is_operator
        with (
            ui.element("div").classes("tasks") as self.area,
            ui.element("table").classes("plain") as self._table,
            ui.element("tr"),
        ):
            for head in ("Task", "State", "Attempts", "Time", "Commands"):
                with ui.element("th"):
                    ui.label(head).classes("unseen" if head == "Commands" else "")
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
                    self._rows[key] = _Row(each, self._deeds, self._is_operator)
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

    def __init__(self, shown: CableTask | Task, deeds: dict[str, Deed], is_operator: bool) -> None:
        self._shown: tuple[CableTask | Task, bool] | None = None
        name = shown.name
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
                if isinstance(shown, Task):
                    self._skip = _button("Skip", "skip_next", name, deeds, is_operator=is_operator)
                    self._retry = _button("Retry", "replay", name, deeds, is_operator=is_operator)

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


def _time_words(task: CableTask | Task, *, is_under_way: bool) -> str:
    """Return what a task has taken, and what it still takes in a run that is under way."""
    taken = duration_words(task.taken_s) if task.taken_s else ""
    is_left = is_under_way and task.expected_s
    left = f"{duration_words(task.expected_s)} left" if is_left else ""
    return ", ".join(filter(None, (taken, left)))
