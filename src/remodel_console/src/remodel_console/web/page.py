"""What all pages have: the bar, the inbox, the status, keys, and commands."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import ClassVar

from nicegui import background_tasks, ui
from nicegui.events import KeyEventArguments
from starlette.requests import Request

from remodel_console.console import Console
from remodel_console.core.access import Actor, Role
from remodel_console.core.answer import DONE, REFUSED, CommandResult
from remodel_console.core.commands import Command, Verb
from remodel_console.core.inbox import Card, Kind, Option, cards
from remodel_console.core.world import Part, World
from remodel_console.session import Session
from remodel_console.web.arrangement import Arrangement
from remodel_console.web.bar import Bar
from remodel_console.web.broadcast import Broadcast
from remodel_console.web.guard import user_of
from remodel_console.web.inbox import Inbox
from remodel_console.web.own_thread import on_own_thread
from remodel_console.web.status_line import StatusLine

_ACCENT = "#0f5ea8"  # as in console.css
_CONFIRM = ("Alt+C", "confirm the engine's request")


class Page:
    """One open page.

    Attributes:
        KEYS: what keys do on it.
        PARTS: what it needs to be running.
        NEEDS: the role that its commands need; to answer what waits, an operator is enough.
    """

    KEYS: ClassVar[tuple[tuple[str, str], ...]] = ()
    PARTS: ClassVar[tuple[Part, ...]] = (Part.ENGINE, Part.MIRROR, Part.CELL)
    NEEDS: ClassVar[Role] = Role.OPERATOR

    def __init__(
        self, console: Console, broadcast: Broadcast, request: Request, title: str
    ) -> None:
        """Build the page, and have it shown again after each change."""
        self.console = console
        self._user = user_of(request.scope)
        self.query = request.query_params
        self._address = request.client.host if request.client else "?"
        self._is_hidden = False
        self._cards: tuple[Card, ...] = ()
        ui.page_title(f"{title} · REMODEL")
        ui.run_javascript("watchConnection()")
        ui.colors(primary=_ACCENT)
        self._arrangement = Arrangement(
            title, request.cookies, self.dialog, lambda: self.set_in_view(not self._is_hidden)
        )
        self._bar = Bar(
            title,
            request.cookies,
            (*self.KEYS, _CONFIRM),
            self.dialog,
            self._set_hidden,
            self._arrangement.ask,
            user=self._user,
            signs_in=not console.door.user_header,
            is_operator=self.is_operator,
        )
        self._inbox = Inbox(partial(self.button, needs=Role.OPERATOR), self._answer, self._enter)
        ui.skip_link("To what waits for you", target=self._inbox.area)
        self._status_line = StatusLine(self.PARTS, lambda: console.shown_database, self.dialog)
        self._dialogs = ui.element("div")  # what is asked stays, whatever the page shows next
        with ui.element("h1").classes("hidden-heading"):  # there, too, where cards hide the page
            ui.label(title)
        with ui.element("div").classes("page"):
            self.build()
        self._bar.offer_layout(is_offered=bool(self._arrangement))
        typed_in = ["input", "select", "textarea"]
        ui.keyboard(on_key=self._on_key, repeating=False, ignore=typed_in)
        broadcast.add(ui.context.client, self._show)
        self._show()

    @property
    def actor(self) -> Actor:
        """Return who uses the page, for the record."""
        name = self._user.name or self._bar.name or Role.OPERATOR.value
        return Actor(name, self._address, self.role)

    @property
    def role(self) -> Role:
        """Return what the user of the page may do now; a removed user only watches."""
        return self.console.role_of(self._user)

    @property
    def is_operator(self) -> bool:
        """Return whether the user may give the page's commands."""
        return self.role.may(self.NEEDS)

    @property
    def is_dark(self) -> bool:
        """Return whether the dark theme is shown."""
        return self._bar.is_dark

    def build(self) -> None:
        """Build what this page has of its own."""
        raise NotImplementedError

    def show(self, world: World) -> None:
        """Show what has changed."""
        raise NotImplementedError

    def set_in_view(self, is_in_view: bool) -> None:
        """Stop what costs something while the page is in the background, and go on."""

    def press(self, key: str, *, ctrl: bool) -> None:
        """Do what a key without Alt means on this page; it commands no robot."""

    def press_with_alt(self, key: str) -> None:
        """Do what Alt and a key mean on this page, such as a command to the robot."""

    async def give(
        self,
        command: str,
        deed: Callable[[], str | None],
        *,
        needs: Role | None = None,
        shows_error: bool = True,
    ) -> CommandResult:
        """Execute a command, show its error if it fails, and return the answer.

        Its sender may have closed the dialog, or the page, before the answer comes.

        Args:
            command: what it is, for the record.
            deed: does it, and returns the answer in words.
            needs: the role that it needs; None for that of the page's commands.
            shows_error: false if the page itself shows why the command failed.
        """
        actor = self.actor
        role = needs or self.NEEDS
        answer = await on_own_thread(lambda: self.console.desk.give(actor, command, deed, role))
        is_shown = shows_error or answer.state == REFUSED
        if answer.state != DONE and is_shown:
            self.show_error(answer.words)
        return answer

    def show_error(self, words: str) -> None:
        """Show why a command failed, until it is closed."""
        if not self._dialogs.is_deleted:
            with self._dialogs:
                ui.notify(words, type="negative", multi_line=True, close_button="OK", timeout=0)

    def go_to(self, address: str) -> None:
        """Show another page, also when what was pressed for it is gone by now."""
        if not self._dialogs.is_deleted:
            with self._dialogs:
                ui.navigate.to(address)

    def button(
        self,
        text: str,
        deed: Callable[[], object],
        *,
        icon: str | None = None,
        look: str = "main",
        needs: Role | None = None,
    ) -> ui.button:
        """Return a button, which cannot be pressed by a user who may not give its command.

        Args:
            text: what is on it.
            deed: what it does.
            icon: name of an icon of Google's Material set.
            look: "main", "quiet" or "stop".
            needs: the role that its command needs; None for that of the page's commands.
        """
        color = "primary" if look == "main" else None
        made = ui.button(text, on_click=deed, icon=icon, color=color).classes(look)
        made.props("no-caps unelevated").set_enabled(self.role.may(needs or self.NEEDS))
        return made

    @contextmanager
    def dialog(self, name: str = "Question") -> Iterator[ui.dialog]:
        """Open a dialog; what is added inside is in it. It is gone once it is closed."""
        with self._dialogs, ui.dialog(value=True) as dialog, ui.card().classes("card"):
            dialog.props(f'aria-label="{name}"')
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

        if session.is_kept or session.chart is None:
            await do()
        else:
            question = f"'{session.chart.name}' has unsaved changes."
            self.ask(question, "Discard and load", do)

    def _show(self) -> None:
        """Show what has changed; a page in the background only draws attention to what waits."""
        world = self.console.live.world
        self._cards = cards(world)
        self._bar.show_waiting(self._cards)
        if self._is_hidden:
            return
        self._inbox.show(self._cards, world)
        self._status_line.show(world)
        self.show(world)

    def _set_hidden(self, is_hidden: bool) -> None:
        self._is_hidden = is_hidden
        self.set_in_view(not is_hidden)
        self._show()

    async def _answer(self, card: Card, option: Option) -> None:
        by = self.actor.name
        await self.give(
            card.record(option),
            lambda: self.console.answer(card, option, by),
            needs=Role.OPERATOR,
        )

    async def _enter(self, card: Card, literal: str | None) -> None:
        what = "no value" if literal is None else literal
        number = int(card.about)
        await self.give(
            f"enter {what} for '{card.text}'",
            lambda: self.console.enter(number, literal),
            needs=Role.OPERATOR,
        )

    def _on_key(self, event: KeyEventArguments) -> None:
        if not event.action.keydown or event.modifiers.meta:
            return
        if event.modifiers.alt:
            self._on_alt(event.key.code.removeprefix("Key").lower())
        elif event.modifiers.ctrl or self._bar.has_single_keys:
            if event.key == "?":
                self._bar.show_keys()
            else:
                self.press(str(event.key), ctrl=event.modifiers.ctrl)

    def _on_alt(self, key: str) -> None:
        asked = (card for card in self._cards if card.kind is Kind.CONFIRMATION and card.options)
        card = next(asked, None)
        if key != "c":
            self.press_with_alt(key)
        elif card is not None and self.role.may(Role.OPERATOR):
            background_tasks.create(self._answer(card, card.options[0]))


def card(title: str, hint: str) -> ui.element:
    """Return a part of a page with a title and a hint, to be filled."""
    made = ui.element("section").classes("card matter")
    with made:
        ui.label(title).classes("title")
        ui.label(hint).classes("soft")
    return made


def scrollable(name: str) -> ui.element:
    """Return a frame for what may be too wide or too high, such as a table; keys scroll it, too."""
    frame = ui.element("div").classes("table-frame wide").props('tabindex="0" role="region"')
    frame.props["aria-label"] = name
    return frame


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
