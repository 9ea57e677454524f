"""What a rehearsal says of an order, on a page: each wire's chance, and what to check."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui

from remodel_console.core.use_case import duration_words
from remodel_console.web.page import scrollable, table
from remodel_run.rehearsal import Forecast, WireForecast

_LISTED = 300  # wires


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
    for wire in found.failing[:3]:
        _show_failing(wire, address_of)
    with ui.element("details").classes("wide"):
        with ui.element("summary"):
            ui.label(f"Wires in their order ({len(found.wires)})")
        with scrollable("Rehearsed wires"):
            rows = (
                (
                    *(wire.wire, str(wire.trials), str(wire.at_once), str(wire.placed)),
                    *(f"{wire.cell_s:.0f} s", _failure_words(wire)),
                )
                for wire in found.wires[:_LISTED]
            )
            heads = ("Wire", "Trials", "At the first attempt", "Placed", "Takes", "Most often")
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
