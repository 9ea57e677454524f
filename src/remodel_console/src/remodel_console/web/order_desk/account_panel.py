"""What was read of a design file: the account of the import, and who does which task."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from nicegui import ui

from remodel_console.web.page import card, scrollable, table
from remodel_run.findings import Account, CellFit, Imported, Triage

_LISTED = 500  # lines; the planner's `import --verbose` prints all


def show_account(imported: Imported) -> ui.element:
    """Return the card of what the file says, what was assumed, and what is not used."""
    account = imported.account
    with card(f"Import of {imported.title}", _count_words(imported)) as made:
        with ui.element("ul").classes("lines"):
            _line(f"{_counted(account.connections, account.unit)} in the file")
            if account.joined:
                wires = _counted(account.wires_joined, "wires")
                _line(f"{account.joined} of them are merged into {wires}")
            for reason, count in Counter(each.reason for each in account.left_out).most_common():
                _line(f"{count} left out: {reason}")
            outside = imported.counts["wires"] - imported.wires_in_cabinet
            if outside:
                inside = _counted(imported.wires_in_cabinet, "wires")
                _line(f"{inside} on the plate, {outside} leave it")
        for each in account.unused_columns:
            with ui.element("div").classes("held"):
                ui.label(f"{each.source} is not used: {each.reason}")
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
        with ui.element("div").classes("ending bad"):
            ui.label(f"Start will be refused: {reason}")
    by_hand = len(triage.by_hand) + len(triage.outside) if triage else 0
    if by_hand:
        words = _counted(by_hand, "tasks")
        ui.label(f"A person does {words} by hand; 'Who does which task' says which and why.")


def show_triage(triage: Triage | None, nothing_to_plan: str, cell: CellFit | None) -> None:
    """Add the card of which tasks are for the robot, by which method, and which by hand."""
    with card("Who does which task", "Decided by the use case; its file and key stand beside."):
        if triage is None:
            with ui.element("div").classes("ending bad"):
                ui.label(f"Nothing can be planned: {nothing_to_plan}")
            return
        others = sum(len(each.tasks) for each in triage.other_methods)
        words = [("robot", len(triage.robot)), ("by hand", len(triage.by_hand))]
        if triage.cables:
            cores = sum(map(len, triage.cables.values()))
            cables = "a cable" if len(triage.cables) == 1 else "cables"
            words.insert(1, (f"of these {cables} of {cores} cores", len(triage.cables)))
        with ui.row().classes("counts"):
            for word, count in words:
                with ui.element("div").classes("count"):
                    ui.label(str(count)).classes("figure")
                    ui.label(word).classes("soft")
            if others:
                with ui.element("div").classes("count"):
                    ui.label(str(others)).classes("figure")
                    ui.label("by another method").classes("soft")
        ui.label(f"Use case {triage.use_case}").classes("soft")
        if cell is not None:
            with ui.element("div").classes("ending bad" if cell.misfits else "soft"):
                ui.label(cell.summary[:1].upper() + cell.summary[1:])
        if triage.other_methods:
            with scrollable("Tasks by another method"):
                head = ("Tasks", "Method", "Not the preferred one, because")
                rows = (
                    (_names(each.tasks), each.method, each.reason) for each in triage.other_methods
                )
                table(head, rows)
        if triage.by_hand:
            with scrollable("Tasks by hand").classes("by-hand"):
                rows = ((each.words, each.reason) for each in triage.by_hand[:_LISTED])
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
    with ui.element("details").classes("wide"):
        with ui.element("summary"):
            ui.label(f"{title} ({len(lines)})")
        with ui.element("ul").classes("lines"):
            _lines(lines[:_LISTED])
            if len(lines) > _LISTED:
                _line(f"and {len(lines) - _LISTED} more, which `import --verbose` prints")


def _lines(lines: Iterable[str]) -> None:
    for line in lines:
        _line(line)


def _line(text: str) -> None:
    with ui.element("li"):
        ui.label(text)


def _names(tasks: Sequence[str]) -> str:
    shown = ", ".join(tasks[:6])
    return f"{len(tasks)}: {shown}, …" if len(tasks) > 6 else shown
