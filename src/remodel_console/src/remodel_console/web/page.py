"""What all pages have: navigation, notices, the operator's name, keys, and commands."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

from nicegui import ui
from nicegui.events import KeyEventArguments
from starlette.requests import Request

from remodel_console.console import Console
from remodel_console.core.access import Actor, Role, tidy_name
from remodel_console.core.answer import DONE, CommandResult
from remodel_console.core.commands import Command, Verb
from remodel_console.core.world import Notice, World, notices
from remodel_console.session import Session
from remodel_console.web.broadcast import Broadcast
from remodel_console.web.guard import role_of
from remodel_console.web.own_thread import on_own_thread

NAME_COOKIE = "remodel_name"
DARK_COOKIE = "remodel_dark"
_ACCENT = "#0f5ea8"  # as in console.css
_YEAR_S = 365 * 24 * 3600
_DEEDS = {True: "dark", False: "light"}


class Page:
    """One open page."""

    PAGES = (
        ("Overview", "/overview"),
        ("Runtime control", "/runtime"),
        ("Editor", "/editor"),
        ("Replay", "/replay"),
        ("Configuration", "/configuration"),
    )
    KEYS: tuple[tuple[str, str], ...] = ()

    def __init__(
        self, console: Console, broadcast: Broadcast, request: Request, title: str
    ) -> None:
        """Build the page, and have it shown again after each change."""
        self.console = console
        self.role = role_of(request.scope)
        self.query = request.query_params
        self._address = request.client.host if request.client else "?"
        self._name = tidy_name(request.cookies.get(NAME_COOKIE, ""))
        self._dark = ui.dark_mode(value=request.cookies.get(DARK_COOKIE) == "dark")
        self._shown_notices: tuple[object, ...] = ("not shown yet",)
        ui.page_title(f"{title} · REMODEL")
        ui.run_javascript("watchConnection()")
        ui.colors(primary=_ACCENT)
        self._bar(title)
        self._notices = ui.column().classes("notices")
        self._dialogs = ui.element("div")  # what is asked stays, whatever the page shows next
        with ui.element("main").classes("page"):
            self.build()
        typed_in = ["input", "select", "textarea"]
        ui.keyboard(on_key=self._on_key, repeating=False, ignore=typed_in)
        broadcast.add(ui.context.client, self._show)
        self._show()

    @property
    def actor(self) -> Actor:
        """Return who uses the page, for the record."""
        return Actor(self._name or self.role.value, self._address, self.role)

    @property
    def is_operator(self) -> bool:
        """Return whether the user of the page may give commands."""
        return self.role is Role.OPERATOR

    def build(self) -> None:
        """Build what this page has of its own."""
        raise NotImplementedError

    def show(self, world: World) -> None:
        """Show what has changed."""
        raise NotImplementedError

    def more_notices(self, world: World) -> Iterable[Notice]:
        """Return the notices that only this page shows."""
        return ()

    def press(self, key: str, *, ctrl: bool) -> None:
        """Do what a key means on this page."""

    async def give(self, command: str, deed: Callable[[], str | None]) -> CommandResult:
        """Execute a command, show its error if it fails, and return the answer.

        Its sender may have closed the dialog, or the page, before the answer comes.
        """
        actor = self.actor
        answer = await on_own_thread(lambda: self.console.desk.give(actor, command, deed))
        if answer.state != DONE and not self._dialogs.is_deleted:
            with self._dialogs:
                ui.notify(
                    answer.words, type="negative", multi_line=True, close_button="OK", timeout=0
                )
        return answer

    def button(
        self, text: str, deed: Callable[[], object], *, icon: str | None = None, look: str = "main"
    ) -> ui.button:
        """Return a button for operators; observers cannot press it.

        Args:
            text: what is on it.
            deed: what it does.
            icon: name of an icon of Google's Material set.
            look: "main", "quiet" or "stop".
        """
        color = "primary" if look == "main" else None
        made = ui.button(text, on_click=deed, icon=icon, color=color).classes(look)
        made.props("no-caps unelevated").set_enabled(self.is_operator)
        return made

    @contextmanager
    def dialog(self) -> Iterator[ui.dialog]:
        """Open a dialog; what is added inside is in it. It is gone once it is closed."""
        with self._dialogs, ui.dialog(value=True) as dialog, ui.card().classes("card"):
            dialog.on("hide", dialog.delete)
            yield dialog

    def ask(self, question: str, yes: str, deed: Callable[[], object]) -> None:
        """Ask before something is done that cannot be undone."""
        with self.dialog() as dialog:
            ui.label(question).classes("question")
            with ui.row():
                button = ui.button(yes, on_click=deed).props("no-caps unelevated autofocus")
                button.on_click(dialog.close)
                ui.button("Cancel", on_click=dialog.close).props("no-caps flat")

    @property
    def session(self) -> Session:
        """Return the session that this page loads behaviors into."""
        return self.console.session

    async def load(self, name: str) -> None:
        """Load a behavior into the session; ask first if something would be lost."""
        session = self.session
        command = Command(f"load {name}", Verb.LOAD, {"name": name})

        async def do() -> None:
            await self.give(command.text, lambda: session.carry_out(command))

        if session.is_saved or session.chart is None:
            await do()
        else:
            question = f"'{session.chart.name}' has unsaved changes."
            self.ask(question, "Discard and load", do)

    def _show(self) -> None:
        world = self.console.live.world
        self._show_notices(world)
        for chip, is_there in zip(
            self._chips, (world.has_master, world.has_engine, world.has_cell), strict=True
        ):
            chip.classes(replace=f"presence {'there' if is_there else 'gone'}")
        self.show(world)

    def _show_notices(self, world: World) -> None:
        found = (*notices(world), *self.more_notices(world))
        if found == self._shown_notices:
            return
        self._shown_notices = found
        self._notices.clear()
        with self._notices:
            for notice in found:
                with ui.row().classes("notice").props('role="status"'):
                    ui.label(f"{notice.what}:").classes("what")
                    ui.label(f"{notice.meaning}. Start it with:")
                    ui.label(notice.remedy).classes("code")

    def _bar(self, title: str) -> None:
        with ui.header().classes("bar"):
            ui.label("REMODEL").classes("brand")
            with ui.element("nav").props('aria-label="Pages"'):
                for number, (name, address) in enumerate(self.PAGES, start=1):
                    link = ui.link(name, address).classes("tab")
                    link.props(f'title="Alt+{number}" accesskey="{number}"')
                    if name == title:
                        link.classes("here").props('aria-current="page"')
            ui.space()
            self._chips = [_chip(name) for name in ("ROS", "Engine", "Cell")]
            if not self.is_operator:
                ui.label("read-only").classes("watching")
            self._who = ui.button(self._name or "Your name", on_click=self._ask_name, color=None)
            self._who.props('flat dense no-caps title="Your name, for the record of commands"')
            _icon("contrast", "Dark or light", self._toggle_dark)
            _icon("keyboard", "Keys (?)", self._show_keys)

    def _toggle_dark(self) -> None:
        self._dark.value = not self._dark.value
        _set_cookie(DARK_COOKIE, _DEEDS[bool(self._dark.value)])

    def _ask_name(self) -> None:
        with self.dialog() as dialog:
            ui.label("Your name").classes("title")
            ui.label("The console records your commands under this name.").classes("soft")
            entry = ui.input("Name", value=self._name).props("outlined dense autofocus")

            def take() -> None:
                self._name = tidy_name(entry.value or "")
                self._who.text = self._name or "Your name"
                _set_cookie(NAME_COOKIE, self._name)
                dialog.close()

            entry.on("keydown.enter", take)
            ui.button("Save", on_click=take).props("no-caps unelevated")

    def _show_keys(self) -> None:
        pages = ((f"Alt+{n}", name) for n, (name, _) in enumerate(self.PAGES, start=1))
        canvas = (("+  -  0", "zoom in, zoom out, show all (after a click on the drawing)"),)
        with self.dialog():
            ui.label("Keys").classes("title")
            with ui.element("dl").classes("keys"):
                for key, meaning in (*self.KEYS, *canvas, *pages, ("?", "this list")):
                    _text("dt", key)
                    _text("dd", meaning)

    def _on_key(self, event: KeyEventArguments) -> None:
        if not event.action.keydown or event.modifiers.alt or event.modifiers.meta:
            return
        if event.key == "?":
            self._show_keys()
        else:
            self.press(str(event.key), ctrl=event.modifiers.ctrl)


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> None:
    """Add a plain table."""
    with ui.element("table").classes("plain"):
        with ui.element("tr"):
            for text in head:
                _text("th", text)
        for row in rows:
            with ui.element("tr"):
                for text in row:
                    _text("td", text)


def _text(tag: str, text: str) -> None:
    with ui.element(tag):
        ui.label(text)


def _chip(name: str) -> ui.label:
    return ui.label(name).classes("presence")


def _icon(icon: str, title: str, deed: Callable[[], None]) -> None:
    ui.button(icon=icon, on_click=deed, color=None).props(
        f'flat dense round title="{title}" aria-label="{title}"'
    )


def _set_cookie(name: str, value: str) -> None:
    ui.run_javascript(
        f"document.cookie = '{name}=' + encodeURIComponent({json.dumps(value)}) "
        f"+ '; path=/; max-age={_YEAR_S}; SameSite=Strict'"
    )
