"""The values that a chart or container takes and gives, among the properties."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from nicegui import ui

from flexbe_synthesizer.core.chart.literal import format_literal
from flexbe_synthesizer.core.chart.model import Chart, Input
from remodel_console.core.editor.chart_edit import with_input, with_output
from remodel_console.core.editor.editing import Path

# The row is left, and not only one of its fields for the next.
_LEFT = "(event) => { if (!event.currentTarget.contains(event.relatedTarget)) emit(); }"
Change = Callable[[str, Path, Callable[[Chart], Chart]], object]


class InterfacePanel:
    """A row for each value, and an empty one to add another."""

    def __init__(self, scope: Chart, path: Path, change: Change, *, is_operator: bool) -> None:
        """Build the rows.

        Args:
            scope: chart or content of the container.
            path: of the container; empty for the chart.
            change: changes what is at a path.
            is_operator: who uses the page may change something.
        """
        self._path = path
        self._change = change
        self._is_operator = is_operator
        has_defaults = not path  # only a start gives the chart a value
        ui.label("Inputs").classes("heading")
        for place, port in enumerate((*scope.inputs, None)):
            self._row(f"Input {place + 1}", port, partial(self._put_input, place), has_defaults)
        ui.label("Outputs").classes("heading")
        for place, port in enumerate((*scope.outputs, None)):
            self._row(f"Output {place + 1}", port, partial(self._put_output, place), False)

    async def _put_input(self, place: int, name: str, kind: str, default: str = "") -> None:
        change = partial(with_input, place=place, name=name, kind=kind, default=default)
        await self._do(f"input '{name}' {kind} {default}".rstrip(), change)

    async def _put_output(self, place: int, name: str, kind: str) -> None:
        change = partial(with_output, place=place, name=name, kind=kind)
        await self._do(f"output '{name}' {kind}".rstrip(), change)

    async def _do(self, what: str, change: Callable[[Chart], Chart]) -> None:
        await self._change(what, self._path, change)  # type: ignore[misc]

    def _row(self, label: str, port: object, put: Callable[..., object], has_default: bool) -> None:
        """Add a row, whose values are taken when it is left."""
        values = [getattr(port, "name", ""), getattr(port, "type", "") or ""]
        hints = ["name", "any type"]
        if has_default:
            default = port.default if isinstance(port, Input) else None
            values.append("" if default is None else format_literal(default, values[1]))
            hints.append("required")
        with ui.element("div").classes("ports") as row:
            fields = [ui.input(value=v, placeholder=h) for v, h in zip(values, hints, strict=True)]
        taken = list(values)

        async def take() -> None:
            found = [(field.value or "").strip() for field in fields]
            if found != taken and (found[0] or port is not None):
                taken[:] = found
                await put(*found)  # type: ignore[misc]

        for field, hint in zip(fields, hints, strict=True):
            field.props(f'outlined dense aria-label="{label}: {hint}"')
            field.set_enabled(self._is_operator)
            field.on("keydown.enter", take)
        row.on("focusout", take, js_handler=_LEFT)
