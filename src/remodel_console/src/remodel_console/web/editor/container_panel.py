"""What only containers have, among the properties: synthesis, how they run, and what ends them."""

from __future__ import annotations

from functools import partial

from nicegui import ui

from flexbe_synthesizer.core.chart.model import Chart, Container, ContainerKind
from remodel_console.core.editor.chart_edit import KIND_WORDS, with_condition, with_kind
from remodel_console.core.editor.editing import Path
from remodel_console.web.editor.editing_page import EditingPage


class ContainerPanel:
    """Shows what can be set of a container, and sets it."""

    def __init__(self, page: EditingPage) -> None:
        """Remember for the page which containers use synthesis."""
        self._page = page
        self._uses_synthesis: set[Path] = set()

    def show(self, node: Container, path: Path) -> None:
        """Add the fields of a container."""
        self._synthesis(node, path)
        self._kind(node, path)
        if node.runs is ContainerKind.CONCURRENCY:
            self._conditions(node.body, path)

    def _synthesis(self, node: Container, path: Path) -> None:
        """Show what fills a container from a chart (Deliverable 5.1, 4.1)."""
        settings = self._page.console.settings.now
        if not settings.is_synthesis_enabled:
            return
        is_served = bool(settings.synthesis_topic)  # a server may know charts that lie elsewhere
        with ui.element("div").classes("card synthesis"):
            box = ui.checkbox("Use synthesis", value=path in self._uses_synthesis)
            with ui.element("div").classes("wide fields").bind_visibility_from(box, "value"):
                initial = ui.input("Initial conditions", placeholder="start")
                initial.props("outlined dense stack-label").classes("wide")
                goal = ui.select(
                    list(self._page.console.workspace.files()),
                    label="Goal: a chart",
                    with_input=True,
                    new_value_mode="add-unique" if is_served else None,
                )
                goal.props("outlined dense").classes("wide")

                async def synthesize() -> None:
                    text = (initial.value or "").strip()
                    if not goal.value:
                        ui.notify("Choose the chart to fill the container with.", type="warning")
                        return
                    await self._page.synthesize(path, text, str(goal.value))

                self._page.button("Synthesize", synthesize, icon="auto_awesome")

            def remember() -> None:
                deed = self._uses_synthesis.add if box.value else self._uses_synthesis.discard
                deed(path)

            box.on_value_change(remember)

    def _kind(self, node: Container, path: Path) -> None:
        async def put(kind: ContainerKind) -> None:
            change = partial(with_kind, node_id=node.id, kind=kind)
            await self._page.change(f"{node.id}: execution {KIND_WORDS[kind]}", path[:-1], change)

        choice = ui.select(
            dict(KIND_WORDS),
            value=node.runs,
            label="Execution",
            on_change=lambda event: put(event.value),
        )
        choice.props("outlined dense").classes("wide").set_enabled(self._page.is_operator)

    def _conditions(self, body: Chart, path: Path) -> None:
        """Show what must have happened for each outcome of a concurrency container."""
        inspection = self._page.inspection
        pairs = [
            (node.id, event)
            for node in body.nodes
            for event in inspection.events("/".join((*path, node.id)), node)
        ]
        for condition in body.conditions:
            pairs += [(w.state, w.event) for w in condition.all_of]
        pairs = list(dict.fromkeys(pairs))
        ui.label("It ends when all events of a condition have happened").classes("heading")
        for place in range(len(body.conditions) + 1):
            self._condition(body, path, place, pairs)

    def _condition(self, body: Chart, path: Path, place: int, pairs: list[tuple[str, str]]) -> None:
        """Add a condition: its outcome, and what must have happened; the last one is to be made."""
        known = body.conditions[place] if place < len(body.conditions) else None
        outcomes = {"": "no outcome yet" if known is None else "remove"}
        outcomes |= {outcome.name: outcome.name for outcome in body.outcomes}
        chosen = [pairs.index((w.state, w.event)) for w in known.all_of] if known else []
        names = {index: f"{state}: {event}" for index, (state, event) in enumerate(pairs)}

        async def put(outcome: str, indices: list[int]) -> None:
            wanted = tuple(pairs[index] for index in indices)
            if (outcome and not wanted) or (not outcome and known is None):
                return  # not complete yet
            words = ", ".join(names[index] for index in indices)
            change = partial(with_condition, place=place, outcome=outcome, pairs=wanted)
            await self._page.change(f"ends with '{outcome}' when {words}", path, change)

        with ui.element("div").classes("pair"):
            number = f"Condition {place + 1}"
            events = ui.select(names, value=chosen, label=f"{number}: all of", multiple=True)
            outcome = ui.select(
                outcomes,
                value=known.outcome if known else "",
                label=f"{number}: ends with",
                on_change=lambda event: put(event.value, list(events.value)),
            )
        for choice in (events, outcome):
            choice.props("outlined dense").classes("wide").set_enabled(self._page.is_operator)
        events.on("popup-hide", lambda: put(str(outcome.value), list(events.value)))
