"""The plan of an order on a page: a Gantt chart, the order of its tasks, and its explanation."""

from __future__ import annotations

from nicegui import ui

from remodel_console.core.order_desk.gantt import (
    gantt_height,
    gantt_plot,
    task_times,
    violated_words,
)
from remodel_console.core.order_desk.preferences import entry_words
from remodel_console.core.use_case.use_case import duration_words
from remodel_console.edge.order_desk.order_drafts import DraftState
from remodel_console.web.page import card, scrollable, table
from remodel_console.web.plot import Plot
from remodel_run.findings import NoPlan, Plan

_LISTED = 300  # tasks


def show_plan(now: DraftState) -> None:
    """Add the card."""
    if now.imported is None:
        return
    hint = "What each arm does when. Drag the bar below it, or Ctrl and the wheel, to zoom."
    with card("Plan", hint).classes("across"):
        if not now.is_planned and (now.plan or now.no_plan):
            with ui.element("div").classes("held"):
                ui.label("The preferences or options have changed since: plan again.")
        if now.no_plan is not None:
            _show_no_plan(now.no_plan)
        elif now.plan is not None:
            _show(now.plan, now.explanation)
        else:
            words, triage = "There is no plan yet.", now.imported.triage
            if triage is not None and triage.is_long:
                words += f" To plan {len(triage.robot)} tasks takes minutes."
            ui.label(words).classes("soft")


def _show_no_plan(found: NoPlan) -> None:
    """Say why there is no plan, and which requirements contradict."""
    with ui.element("div").classes("ending bad").props('role="alert"'):
        ui.label("There is no plan.").classes("question")
        ui.label(found.error.splitlines()[0] if found.conflicts else found.error).classes("lines")
    for conflict in found.conflicts:
        ui.label(
            "The design contradicts this requirement:"
            if len(conflict) == 1
            else f"No plan keeps all of these {len(conflict)} requirements; remove or change one:"
        )
        with ui.element("ul").classes("lines conflicting"):
            for each in conflict:
                with ui.element("li"):
                    ui.label(str(each.entry.get("name", "without a name"))).classes("name")
                    ui.label(entry_words(each.entry)).classes("code")


def _show(plan: Plan, explanation: str) -> None:
    times = task_times(plan)
    tasks = len({each.task for each in times})
    words = f"{tasks} task{'' if tasks == 1 else 's'} in {duration_words(plan.makespan_s)}"
    ui.label(f"{words}, cost {plan.cost}").classes("plan-words")
    for line in plan.split_cables:
        ui.label(line).classes("lines")
    plot = Plot(f"Gantt chart: {words}; the table below lists the tasks")
    plot.show(gantt_plot(plan), gantt_height(plan))
    with ui.element("details").classes("wide"):
        with ui.element("summary"):
            ui.label(f"Tasks in their order ({len(times)})")
        with scrollable("Tasks in their order"):
            rows = (
                (
                    *(str(number), each.words, each.arm),
                    *(f"{each.start_s:.1f} s", f"{each.end_s:.1f} s"),
                    violated_words(plan, each.wires),
                )
                for number, each in enumerate(times[:_LISTED], start=1)
            )
            table(("", "Task", "Arm", "From", "To", "Preference violated"), rows)
    if explanation:
        with ui.element("details").classes("wide"):
            with ui.element("summary"):
                ui.label("Explanation: what the plan costs, and what preferences would")
            ui.label(explanation).classes("explanation")
