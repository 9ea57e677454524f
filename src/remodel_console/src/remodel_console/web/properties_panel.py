"""The properties on the editor's page: of the selected state or container, or of the chart."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial

from nicegui import ui

from flexbe_synthesizer.core.chart.error_routes import FAILED_EVENT, format_routes
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Autonomy,
    Behavior,
    Chart,
    Container,
    ContainerKind,
    Input,
    State,
    format_literal,
)
from remodel_console.core import chart_edit
from remodel_console.core.chart_edit import (
    KIND_WORDS,
    kind_at,
    with_condition,
    with_input,
    with_kind,
    with_output,
)
from remodel_console.core.editing import Path
from remodel_console.web.editing_page import EditingPage, show_fixes


class ContainerPanel:
    """Shows what can be set of a container, and sets it."""

    def __init__(self, page: EditingPage) -> None:
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


# The row is left, and not only one of its fields for the next.
_LEFT = "(event) => { if (!event.currentTarget.contains(event.relatedTarget)) emit(); }"


class InterfacePanel:
    """A row for each value, and an empty one to add another."""

    def __init__(self, page: EditingPage, scope: Chart, path: Path) -> None:
        """Build the rows of a container of a path, or of the chart if that is empty."""
        self._page = page
        self._path = path
        has_defaults = not path  # only a start gives the chart a value
        ui.label("Inputs").classes("heading")
        for place, port in enumerate((*scope.inputs, None)):
            self._row(f"Input {place + 1}", port, partial(self._put_input, place), has_defaults)
        ui.label("Outputs").classes("heading")
        for place, port in enumerate((*scope.outputs, None)):
            self._row(f"Output {place + 1}", port, partial(self._put_output, place), False)

    async def _put_input(self, place: int, name: str, kind: str, default: str = "") -> None:
        change = partial(with_input, place=place, name=name, kind=kind, default=default)
        await self._page.change(f"input '{name}' {kind} {default}".rstrip(), self._path, change)

    async def _put_output(self, place: int, name: str, kind: str) -> None:
        change = partial(with_output, place=place, name=name, kind=kind)
        await self._page.change(f"output '{name}' {kind}".rstrip(), self._path, change)

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
            field.set_enabled(self._page.is_operator)
            field.on("keydown.enter", take)
        row.on("focusout", take, js_handler=_LEFT)


_BY_NAME = "by name"  # an input without a connection gets the value of its name
_NOWHERE = "not connected"
_ANY_AUTONOMY = "default"  # the chart says nothing about it


class PropertiesPanel:
    """Shows what can be set, and sets it."""

    def __init__(self, page: EditingPage) -> None:
        self._page = page
        self._change = page.change
        self._area = ui.element("div").classes("properties")
        self._container = ContainerPanel(page)
        self._shown: object = None

    def show(self) -> None:
        """Show the properties of what is selected now, once the checks know it."""
        page = self._page
        if page.inspected is not page.chart:
            return  # not twice, so that no element moves before a click
        settings = page.console.settings.now
        synthesis = (settings.is_synthesis_enabled, settings.synthesis_topic)
        shown = (page.chart, page.selected, page.inspection, synthesis)
        if shown == self._shown:
            return
        self._shown = shown
        self._area.clear()
        if page.chart is None:
            return
        node = chart_edit.node_at(page.chart, page.selected)
        with self._area:
            if node is None:
                self._show_chart(page.chart)
            else:
                self._show_node(node, page.selected)

    def _show_chart(self, chart: Chart) -> None:
        ui.label(chart.name).classes("title")
        self._description(chart)
        with ui.element("div").classes("pair"):
            for name, text in (("author", chart.author), ("tags", chart.tags)):
                self._about(name, text)
        self._outcomes_entry(chart, ())
        self._interface(chart, ())
        ui.label(
            "Click a state in the drawing to edit it; choose one on the left to add it."
        ).classes("soft")

    def _about(self, name: str, text: str) -> None:
        """Show who wrote the chart, or by which words its behavior is found."""

        async def put(given: str) -> None:
            change = partial(replace, **{name: given})
            await self._change(f"{name} {given}".rstrip(), (), change)

        self._entry(name.capitalize(), text, put)

    def _description(self, chart: Chart) -> None:
        """Show what the behavior does, for people, as a text that can be changed."""
        entry = ui.textarea("Description", value=chart.description)
        entry.props("outlined dense stack-label autogrow").classes("wide description")
        entry.set_enabled(self._page.is_operator)

        async def take() -> None:
            text = (entry.value or "").strip()
            if text != chart.description:
                await self._change(
                    "description", (), lambda scope: replace(scope, description=text)
                )

        entry.on("blur", take)

    def _show_node(self, node: AnyNode, path: Path) -> None:
        scope = self._page.scope_of(path)
        if len(path) > 1:
            ui.label(" / ".join(path[:-1])).classes("soft")
        self._name_entry(node, path)
        self._problems(path)
        if isinstance(node, Container):
            ui.label("container").classes("soft")
            self._outcomes_entry(node.body, path)
            self._container.show(node, path)
            self._interface(node.body, path)
        else:
            ui.label(node.type).classes("soft")
        if isinstance(node, Behavior):
            deed = partial(self._page.load, self._behavior_name(node, path))
            self._page.button("Open", deed, icon="open_in_new", look="quiet")
        self._parameters(node, path)
        self._topic(node, path)
        self._limits(node, path)
        is_beside = self._is_in_concurrency(path)
        if is_beside:
            ui.label("The conditions of its container define what its outcomes mean.").classes(
                "soft"
            )
        else:
            self._transitions(node, scope, path)
        self._inputs(node, scope, path)
        with ui.row():
            if scope.initial != node.id and not is_beside:
                start = partial(chart_edit.started_at, node_id=node.id)
                deed = partial(self._change, f"start at '{node.id}'", path[:-1], start)
                self._page.button("Start here", deed, icon="flag", look="quiet")
            self._page.button("Delete", self._page.delete, icon="delete", look="quiet")

    def _problems(self, path: Path) -> None:
        """Show what is wrong with the state, and what corrects it."""
        for found in self._page.found:
            if found.path == path:
                style = found.problem.code.severity.value
                with ui.element("div").classes(f"problem {style}"):
                    ui.label(found.problem.message)
                    show_fixes(self._page, found)

    def _name_entry(self, node: AnyNode, path: Path) -> None:
        async def rename(text: str) -> None:
            change = partial(chart_edit.renamed, old=node.id, new=text)
            if await self._change(f"rename '{node.id}' to '{text}'", path[:-1], change):
                self._page.select((*path[:-1], text))

        self._entry("Name", node.id, rename)

    def _outcomes_entry(self, scope: Chart, path: Path) -> None:
        """Show the outcomes of a chart or container as a list that can be changed."""

        async def put(text: str) -> None:
            wanted = tuple(dict.fromkeys(filter(None, (w.strip() for w in text.split(",")))))
            change = partial(chart_edit.with_outcomes, wanted=wanted)
            await self._change(f"outcomes {', '.join(wanted)}", path, change)

        self._entry("Outcomes", ", ".join(o.name for o in scope.outcomes), put)

    def _parameters(self, node: AnyNode, path: Path) -> None:
        entry = self._page.inspection.uses.get("/".join(path))
        parameters = entry.signature.parameters if entry and entry.signature else ()
        if isinstance(node, Container) or not parameters:
            return
        ui.label("Parameters").classes("heading")
        given = {param.name: param.text for param in node.params}
        for parameter in parameters:
            hint = f"{parameter.type or 'any'}{', required' if parameter.required else ''}"
            name = parameter.name

            async def put(text: str, name: str = name) -> None:
                change = partial(chart_edit.with_parameter, node_id=node.id, name=name, text=text)
                await self._change(f"{node.id}: {name} = {text}", path[:-1], change)

            entry = self._entry(name, given.get(name, ""), put, hint)
            if parameter.required and name not in given and self._page.wants_value:
                self._page.wants_value = False
                entry.run_method("focus")

    def _behavior_name(self, node: Behavior, path: Path) -> str:
        """Return the display name of a behavior, which a chart may call by its class or path."""
        use = self._page.inspection.uses.get("/".join(path))
        return use.declaration.name if use and use.declaration else node.type

    def _topic(self, node: AnyNode, path: Path) -> None:
        """Show the name of the action that a state calls, if its class leaves the choice."""
        use = self._page.inspection.uses.get("/".join(path))
        names = {p.name for p in use.signature.parameters} if use and use.signature else set()
        if not isinstance(node, State) or "topic" not in names:
            return

        async def put(text: str) -> None:
            change = partial(chart_edit.with_topic, node_id=node.id, topic=text)
            await self._change(f"{node.id}: topic {text or 'of its class'}", path[:-1], change)

        self._entry("Action", node.topic or "", put, "that of its class")

    def _limits(self, node: AnyNode, path: Path) -> None:
        attempts = "" if node.attempts is None else str(node.attempts)
        timeout = "" if node.timeout_s is None else f"{node.timeout_s:g}"

        async def put(attempts: str, timeout: str) -> None:
            try:
                count = int(attempts) if attempts else None
                time_s = float(timeout) if timeout else None
            except ValueError:
                ui.notify("Give a whole number of attempts and a time in seconds.", type="warning")
                return
            change = partial(chart_edit.limited, node_id=node.id, attempts=count, timeout_s=time_s)
            await self._change(
                f"{node.id}: limits {attempts or '-'} {timeout or '-'}", path[:-1], change
            )

        with ui.element("div").classes("pair"):
            self._entry("Maximum attempts", attempts, lambda text: put(text, timeout), "no limit")
            self._entry("Timeout [s]", timeout, lambda text: put(attempts, text), "no limit")

    def _is_in_concurrency(self, path: Path) -> bool:
        chart = self._page.chart
        return chart is not None and kind_at(chart, path[:-1]) is ContainerKind.CONCURRENCY

    def _interface(self, scope: Chart, path: Path) -> None:
        InterfacePanel(self._page, scope, path)
        self._outputs(scope, path)

    def _outputs(self, scope: Chart, path: Path) -> None:
        """Show which output of a state each output of the chart or container gets."""
        if not scope.outputs:
            return
        ui.label("Output connections").classes("heading")
        self._feeds(scope, path, scope.name, [port.name for port in scope.outputs])

    def _feeds(self, scope: Chart, path: Path, node_id: str, keys: Iterable[str]) -> None:
        """Show where values of a node, or of the chart or container itself, come from."""
        prefix = "".join(f"{part}/" for part in path)
        sources = list(self._page.inspection.sources(scope, prefix))
        names = {index: _source_words(scope, source) for index, source in enumerate(sources)}
        for key in keys:
            source = chart_edit.feed_of(scope, node_id, key)
            value = sources.index(source) if source in sources else -1

            async def put(index: int, name: str = key) -> None:
                chosen = None if index < 0 else sources[index]
                change = partial(chart_edit.fed, node_id=node_id, input_name=name, source=chosen)
                words = _BY_NAME if chosen is None else ".".join(chosen)
                await self._change(f"{node_id}: {name} is fed {words}", path, change)

            self._choice(key, {-1: _BY_NAME} | names, value, put)

    def _error_routes(self, node: AnyNode, path: Path) -> None:
        """Show where failures lead by their error codes; for all others the transition says so."""

        async def put(text: str) -> None:
            change = partial(chart_edit.routed, node_id=node.id, text=text)
            await self._change(f"{node.id}: on error {text or 'as failed'}", path[:-1], change)

        hint = "INSERTION_JAMMED: Withdraw; above_behavior: failed"
        self._entry("Failures by error code", format_routes(node.on_error), put, hint)

    def _transitions(self, node: AnyNode, scope: Chart, path: Path) -> None:
        events = self._page.inspection.events("/".join(path), node)
        if not events:
            return
        ui.label("Transitions").classes("heading")
        known_transitions = {transition.event: transition for transition in node.transitions}
        levels = {None: _ANY_AUTONOMY} | {level: level.value.capitalize() for level in Autonomy}
        choices = {"": _NOWHERE} | {name: name for name in chart_edit.targets(scope)}
        for event in events:
            transition = known_transitions.get(event)
            target = transition.target if transition else ""
            known = choices if target in choices else choices | {target: f"{target} (missing)"}

            async def put(target: str, event: str = event) -> None:
                change = partial(chart_edit.led, node_id=node.id, event=event, target=target)
                await self._change(f"{node.id}: '{event}' leads to '{target}'", path[:-1], change)

            async def put_level(level: Autonomy | None, event: str = event) -> None:
                change = partial(
                    chart_edit.with_autonomy, node_id=node.id, event=event, level=level
                )
                what = f"{node.id}: autonomy of '{event}' {levels[level]}"
                await self._change(what, path[:-1], change)

            with ui.element("div").classes("pair"):
                self._choice(event, known, target, put)
                if transition is not None:
                    level = transition.autonomy
                    self._choice(f"Autonomy of {event}", levels, level, put_level)
        if node.on_error or FAILED_EVENT in events:
            self._error_routes(node, path)

    def _inputs(self, node: AnyNode, scope: Chart, path: Path) -> None:
        entry = self._page.inspection.uses.get("/".join(path))
        if entry is None or not entry.inputs:
            return
        ui.label("Input connections").classes("heading")
        self._feeds(scope, path[:-1], node.id, entry.inputs)

    # Elements

    def _entry(
        self, label: str, value: str, put: Callable[[str], object], hint: str = ""
    ) -> ui.input:
        """Add a text that is taken when it is left or Enter is pressed."""
        entry = ui.input(label, value=value, placeholder=hint)
        entry.props("outlined dense stack-label").classes("wide")
        entry.set_enabled(self._page.is_operator)

        async def take() -> None:
            nonlocal value  # Enter, and then leaving the field, change it once
            text = (entry.value or "").strip()
            if text != value:
                value = text
                await put(text)  # type: ignore[misc]

        entry.on("blur", take)
        entry.on("keydown.enter", take)
        return entry

    def _choice(
        self, label: str, choices: dict, value: object, put: Callable[[object], object]
    ) -> None:
        choice = ui.select(
            choices, value=value, label=label, on_change=lambda event: put(event.value)
        )
        choice.props("outlined dense").classes("wide").set_enabled(self._page.is_operator)


def _source_words(scope: Chart, source: tuple[str, str]) -> str:
    where, name = source
    return f"input: {name}" if where == scope.name else f"{where}: {name}"
