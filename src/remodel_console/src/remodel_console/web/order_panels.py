"""Panels of the order desk: account of the import, columns of a wire list, plan, rehearsal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Awaitable, Callable, Sequence

from nicegui import ui

from remodel_console.core.order_desk import (
    LENGTH_UNITS,
    SECTION_UNITS,
    ListColumns,
    entry_words,
    gantt_height,
    gantt_plot,
    task_times,
    violated_words,
)
from remodel_console.core.use_case import duration_words
from remodel_console.edge.order_drafts import DraftState
from remodel_console.errors import CommandError
from remodel_console.web.elements import Plot, card, scrollable, table, text_in, unfolding
from remodel_console.web.page import Page
from remodel_run.findings import Account, CellFit, Imported, NoPlan, Plan, Triage
from remodel_run.rehearsal import Forecast, WireForecast
from remodel_run.whole_task import counted

_LINES_LISTED = 500  # lines; the planner's `import --verbose` prints all


def show_account(imported: Imported) -> ui.element:
    """Return the card of what the file says, what was assumed, and what is not used."""
    account = imported.account
    with card(f"Import of {imported.title}", _count_words(imported)) as made:
        with ui.element("ul").classes("lines"):
            text_in("li", f"{_counted(account.connections, account.unit)} in the file")
            if account.joined:
                wires = _counted(account.wires_joined, "wires")
                text_in("li", f"{account.joined} of them are merged into {wires}")
            for reason, count in Counter(each.reason for each in account.left_out).most_common():
                text_in("li", f"{count} left out: {reason}")
            outside = imported.counts["wires"] - imported.wires_in_cabinet
            if outside:
                inside = _counted(imported.wires_in_cabinet, "wires")
                text_in("li", f"{inside} on the plate, {outside} leave it")
        for each in account.unused_columns:
            text_in("div", f"{each.source} is not used: {each.reason}", "held")
        _unfolding("Assumptions", account.assumptions)
        _unfolding("Left out", _omissions(account))
        _unfolding("Wires shorter than their routes", imported.lengths.too_short)
        _unfolding("Wires much longer than their routes", imported.lengths.too_long)
        _unfolding("Bundles longer than the rest of their rings", imported.lengths.rings)
        _unfolding("Wires cut longer than needed", imported.lengths.cut_longer)
    return made


def show_before_start(triage: Triage | None, nothing_to_plan: str, cell: CellFit | None) -> None:
    """Add what a person should know before the start: what is by hand, and what is refused."""
    refused = cell.misfits if cell else ()
    if triage is None:
        refused = (nothing_to_plan,)
    elif not triage.robot:
        refused = (*refused, "no task is for the robot")
    for reason in refused:
        text_in("div", f"Start will be refused: {reason}", "ending bad")
    by_hand = len(triage.by_hand) + len(triage.outside) if triage else 0
    if by_hand:
        words = _counted(by_hand, "tasks")
        ui.label(f"A person does {words} by hand; 'Who does which task' says which and why.")


def show_triage(triage: Triage | None, nothing_to_plan: str, cell: CellFit | None) -> None:
    """Add the card of which tasks are for the robot, by which method, and which by hand."""
    with card("Who does which task", "Decided by the use case; its file and key stand beside."):
        if triage is None:
            text_in("div", f"Nothing can be planned: {nothing_to_plan}", "ending bad")
            return
        others = sum(len(each.tasks) for each in triage.other_methods)
        words = [("robot", len(triage.robot)), ("by hand", len(triage.by_hand))]
        if triage.cables:
            cores = sum(map(len, triage.cables.values()))
            cables = "a cable" if len(triage.cables) == 1 else "cables"
            words.insert(1, (f"of these {cables} of {cores} cores", len(triage.cables)))
        if others:
            words.append(("by another method", others))
        with ui.row().classes("counts"):
            for word, count in words:
                with ui.element("div").classes("count"):
                    ui.label(str(count)).classes("figure")
                    ui.label(word).classes("soft")
        ui.label(f"Use case {triage.use_case}").classes("soft")
        if cell is not None:
            summary = cell.summary[:1].upper() + cell.summary[1:]
            text_in("div", summary, "ending bad" if cell.misfits else "soft")
        if triage.other_methods:
            with scrollable("Tasks by another method"):
                head = ("Tasks", "Method", "Not the preferred one, because")
                rows = (
                    (_names(each.tasks), each.method, each.reason) for each in triage.other_methods
                )
                table(head, rows)
        if triage.by_hand:
            with scrollable("Tasks by hand").classes("by-hand"):
                rows = ((each.words, each.reason) for each in triage.by_hand[:_LINES_LISTED])
                table(("By hand", "Because"), rows)
        _unfolding(
            "Wires that leave the plate, by hand",
            tuple(f"{each.words}: {each.reason}" for each in triage.outside),
        )


def _count_words(imported: Imported) -> str:
    found = ((count, name) for name, count in imported.counts.items() if count)
    return ", ".join(_counted(count, name) for count, name in found)


def _counted(number: int, nouns: str) -> str:
    """Return a number with its noun, which is given in the plural."""
    return f"{number} {nouns if number != 1 else nouns.removesuffix('s')}"


def _omissions(account: Account) -> Sequence[str]:
    found = (*account.left_out, *account.ignored)
    return tuple(f"{each.source}: {each.reason}" for each in found)


def _unfolding(title: str, lines: Sequence[str]) -> None:
    """Add lines that are shown when a person asks for them."""
    if not lines:
        return
    left = len(lines) - _LINES_LISTED
    more = (f"and {left} more, which `import --verbose` prints",) if left > 0 else ()
    with unfolding(f"{title} ({len(lines)})"), ui.element("ul").classes("lines"):
        for line in (*lines[:_LINES_LISTED], *more):
            text_in("li", line)


def _names(tasks: Sequence[str]) -> str:
    shown = ", ".join(tasks[:6])
    return f"{len(tasks)}: {shown}, …" if len(tasks) > 6 else shown


class ColumnsPanel:
    """Shows the columns, and has the file read by what they mean."""

    def __init__(self, page: Page, read: Callable[[str], Awaitable[object]]) -> None:
        """Take the page; `read` reads the file by the YAML of a mapping."""
        self._page = page
        self._read = read

    def show(self, now: DraftState) -> None:
        """Add the card, if the columns of a list were read."""
        columns = now.columns
        if columns is None:
            return
        hint = "Choose what each column means: at least both ends of a wire."
        with card("Columns of the list", hint).classes("across"):
            with scrollable("Columns of the list"):
                meanings = self._show_table(columns)
            with ui.row().classes("options"):
                section = ui.select(
                    {
                        unit: unit.replace("mm2", "mm²").replace("awg", "AWG")
                        for unit in SECTION_UNITS
                    },
                    value=columns.units.get("section"),
                    label="Sections without a unit",
                )
                length = ui.select(
                    list(LENGTH_UNITS),
                    value=columns.units.get("length"),
                    label="Lengths without a unit",
                )
                separator = ui.input(
                    "Sign between component and terminal", value=columns.terminal_separator
                )
            for field in (section, length, separator):
                field.props("outlined dense stack-label").set_enabled(self._page.is_operator)
            problem = ui.label().classes("bad-count").props('role="alert"')

            async def read() -> None:
                try:
                    mapping = columns.mapping(
                        {heading: str(each.value) for heading, each in meanings.items()},
                        {"section": section.value, "length": length.value},
                        separator.value or "",
                    )
                except CommandError as error:
                    problem.text = str(error)
                    return
                problem.text = ""
                await self._read(mapping)

            self._page.button("Read the file by these columns", read, icon="refresh")

    def _show_table(self, columns: ListColumns) -> dict[str, ui.select]:
        """Add the headings and first rows, and return the choices by heading."""
        meanings: dict[str, ui.select] = {}
        shown = [i for i, heading in enumerate(columns.headings) if heading]
        with ui.element("table").classes("plain columns"):
            with ui.element("tr"):
                for i in shown:
                    heading = columns.headings[i]
                    with ui.element("th"):
                        choice = ui.select(
                            columns.choices, value=columns.meaning(heading), label=heading
                        )
                        choice.props("outlined dense stack-label options-dense")
                        choice.set_enabled(self._page.is_operator)
                        meanings[heading] = choice
            for row in columns.rows:
                with ui.element("tr"):
                    for i in shown:
                        text_in("td", row[i] if i < len(row) else "")
        return meanings


_TASKS_LISTED = 300  # tasks


def show_plan(now: DraftState) -> None:
    """Add the card."""
    if now.imported is None:
        return
    hint = "What each arm does when. Drag the bar below it, or Ctrl and the wheel, to zoom."
    with card("Plan", hint).classes("across"):
        if not now.is_planned and (now.plan or now.no_plan):
            words = "The preferences or options have changed since: plan again."
            text_in("div", words, "held")
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
    words = f"{counted(tasks, 'task')} in {duration_words(plan.makespan_s)}"
    ui.label(f"{words}, cost {plan.cost}").classes("plan-words")
    for line in plan.split_cables:
        ui.label(line).classes("lines")
    plot = Plot(f"Gantt chart: {words}; the table below lists the tasks")
    plot.show(gantt_plot(plan), gantt_height(plan))
    rows = (
        (
            *(str(number), each.words, each.arm),
            *(f"{each.start_s:.1f} s", f"{each.end_s:.1f} s"),
            violated_words(plan, each.wires),
        )
        for number, each in enumerate(times[:_TASKS_LISTED], start=1)
    )
    with unfolding(f"Tasks in their order ({len(times)})"), scrollable("Tasks in their order"):
        table(("", "Task", "Arm", "From", "To", "Preference violated"), rows)
    if explanation:
        with unfolding("Explanation: what the plan costs, and what preferences would"):
            ui.label(explanation).classes("explanation")


_LISTED = 300  # wires


def can_be_adopted(found: Forecast | None) -> bool:
    """Return whether changes were tried that are not in the order's preferences."""
    return (
        found is not None and found.adopted is None and any(wire.changes for wire in found.failing)
    )


def show_forecast(found: Forecast, address_of: Callable[[str], str]) -> None:
    """Add the forecast of an order.

    Args:
        found: to be shown.
        address_of: returns the address of a picture by its name.
    """
    mean, low, high = (duration_words(seconds) for seconds in found.cell_s)
    ui.label(
        f"{found.all_at_once:.0%} without a failure; {mean} in the cell, {low} to {high}"
    ).classes("plan-words")
    if found.adopted is not None:
        with ui.element("div").classes("held").props('role="status"'):
            ui.label("Adopted, in the order's preferences:").classes("question")
            for name in found.adopted or ("nothing: no change helps for certain",):
                ui.label(name).classes("lines")
    for wire in found.failing[:3]:
        _show_failing(wire, address_of)
    heads = ("Wire", "Trials", "At the first attempt", "Placed", "Takes", "Most often")
    rows = (
        (
            *(wire.wire, str(wire.trials), str(wire.at_once), str(wire.placed)),
            *(f"{wire.cell_s:.0f} s", _failure_words(wire)),
        )
        for wire in found.wires[:_LISTED]
    )
    with unfolding(f"Wires in their order ({len(found.wires)})"), scrollable("Rehearsed wires"):
        table(heads, rows)


def _show_failing(wire: WireForecast, address_of: Callable[[str], str]) -> None:
    with ui.element("div").classes("held"):
        ui.label(f"Check {wire.wire}: {wire.at_once} at the first attempt").classes("question")
        if wire.failure is not None:
            ui.label(wire.failure.text).classes("lines")
        for each in wire.changes:
            ui.label(f"{each.text}: {each.at_once}").classes("lines")
        if wire.picture:
            picture = ui.element("img").props(f'alt="How {wire.wire} failed in a rehearsal"')
            picture.classes("failure-picture").props["src"] = address_of(wire.picture)


def _failure_words(wire: WireForecast) -> str:
    return f"{wire.failure.ability} {wire.failure.code}".strip() if wire.failure else ""
