"""Configuration: synthesis, commands of ROS, chart folders; all kept across restarts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from nicegui import ui
from nicegui.elements.mixins.value_element import ValueElement

from remodel_console.core.commands import DONE, Role
from remodel_console.core.settings import Settings, difference
from remodel_console.core.world import World
from remodel_console.web.elements import card, text_in
from remodel_console.web.page import Page


class ConfigurationPage(Page):
    """The page of what is configured; each change counts once its field is left."""

    NEEDS = Role.ENGINEER

    def build(self) -> None:
        """Build a card for each matter."""
        self._fields: list[tuple[ValueElement, Callable[[Settings], object]]] = []
        self._shown: Settings | None = None
        with ui.element("div").classes("configuration"):
            with card(
                "Synthesis", "Containers are filled from charts, in the editor or by command."
            ):
                self._box("Enable synthesis", "is_synthesis_enabled")
                self._text(
                    "Action topic",
                    "synthesis_topic",
                    "Action of the synthesis server, such as flexbe/synthesize. "
                    "Empty: the console synthesizes by itself.",
                )
                self._text("System", "system", "Name of the robot system, if the server needs it.")
            with card(
                "ROS commands", "The console executes the commands sent to /flexbe/uicommand."
            ):
                self._box("Allow ROS commands", "are_commands_allowed")
                self._key()
            with card(
                "Chart folders", "The console searches these folders for charts, first to last."
            ):
                self._always = ui.element("ul").classes("folders")
                self._folders()
            self._status = ui.label().classes("soft").props('role="status"')

    def show(self, world: World) -> None:
        """Show the configuration, also when another page has changed it."""
        settings = self.console.settings.now
        if settings == self._shown:
            return
        before, self._shown = self._shown, settings
        for field, value_of in self._fields:
            if before is None or value_of(before) != value_of(settings):  # else it may be typed in
                field.value = value_of(settings)
        self._always.clear()
        added = set(settings.chart_folders)
        with self._always:
            for folder, words in self.console.workspace.folder_words():
                if str(folder) not in added:
                    text_in("li", words).tooltip(str(folder))

    def _box(self, label: str, name: str) -> None:
        box = ui.checkbox(label, value=getattr(self.console.settings.now, name))
        box.set_enabled(self.is_operator)
        box.on("update:model-value", lambda: self._change(**{name: bool(box.value)}))
        self._fields.append((box, lambda settings: getattr(settings, name)))

    def _text(self, label: str, name: str, hint: str) -> None:
        entry = ui.input(label, value=getattr(self.console.settings.now, name))
        entry.props("outlined dense stack-label").classes("wide")
        ui.label(hint).classes("soft")
        self._taken(entry, lambda: self._change(**{name: (entry.value or "").strip()}))
        self._fields.append((entry, lambda settings: getattr(settings, name)))

    def _key(self) -> None:
        """Add the field of the key, which is not sent to who may not change it."""

        def shown(settings: Settings) -> str:
            return settings.command_key if self.is_operator else ""

        entry = ui.input("Command key", value=shown(self.console.settings.now), password=True)
        entry.props("outlined dense stack-label autocomplete=off").classes("wide")
        ui.label("The key that each command must contain. Empty: none.").classes("soft")
        self._taken(entry, lambda: self._change(command_key=(entry.value or "").strip()))
        self._fields.append((entry, shown))

    def _folders(self) -> None:
        entry = ui.textarea("More folders, one per line")
        entry.props("outlined dense stack-label autogrow").classes("wide")
        ui.label("In the home folder or in a ROS package.").classes("soft")

        async def take() -> None:
            lines = dict.fromkeys(filter(None, map(str.strip, (entry.value or "").splitlines())))
            await self._change(chart_folders=tuple(lines))

        self._taken(entry, take, enter=False)
        self._fields.append((entry, lambda settings: "\n".join(settings.chart_folders)))

    def _taken(self, entry: ui.input, take: Callable[[], object], *, enter: bool = True) -> None:
        """Have the value of a field taken when it is left, or Enter is pressed."""
        entry.set_enabled(self.is_operator)
        entry.on("blur", take)
        if enter:
            entry.on("keydown.enter", take)

    async def _change(self, **changed: object) -> None:
        """Save what has changed, and show that; an invalid value stays in its field."""
        old = self.console.settings.now
        try:
            new = replace(old, **changed)
        except ValueError as error:
            ui.notify(str(error), type="warning")
            return
        if new == old:
            return
        what = f"configure: {difference(old, new)}"
        kept = self.console.settings
        answer = await self.give(what, lambda: kept.change(lambda now: replace(now, **changed)))
        self._status.text = "Saved." if answer.state == DONE else "Not saved; the message says why."
