"""What all pages have: commands, keys, arrangement of their parts, updates, slow calls, plots."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from typing import ClassVar, TypeVar
from urllib.parse import unquote

from nicegui import Client, background_tasks, ui
from nicegui.events import KeyEventArguments
from starlette.requests import Request

from remodel_console.console import Console
from remodel_console.core.commands import DONE, REFUSED, Actor, Command, CommandResult, Role, Verb
from remodel_console.core.settings import PagePart, arranged, arrangement_text, moved, with_shown
from remodel_console.core.world import Card, Kind, Option, Part, World, cards
from remodel_console.session import Session
from remodel_console.web.bar import Bar, Inbox, StatusLine, set_cookie
from remodel_console.web.guard import user_of


class Arrangement:
    """Keeps the parts of one page; the browser remembers them in a cookie."""

    def __init__(
        self,
        page: str,
        cookies: Mapping[str, str],
        dialog: Callable[[str], AbstractContextManager[ui.dialog]],
        on_change: Callable[[], None],
    ) -> None:
        """Arrange a page as its cookie says.

        Args:
            page: its title.
            cookies: of the browser.
            dialog: opens a dialog of a name.
            on_change: is called when a part was shown or hidden.
        """
        self._page = page.lower().replace(" ", "_")
        self._cookie = f"remodel_layout_{self._page}"
        self._text = unquote(cookies.get(self._cookie, ""))
        self._dialog = dialog
        self._on_change = on_change
        self._defaults: tuple[PagePart, ...] = ()
        self._parts: tuple[PagePart, ...] = ()
        self._elements: dict[str, ui.element] = {}

    def __bool__(self) -> bool:
        return bool(self._parts)

    @contextmanager
    def part(self, title: str, area: str) -> Iterator[None]:
        """Add a part in a column of the page; what is built inside belongs to it."""
        with ui.element("div").classes("part") as element:
            yield
        self._elements[title] = element
        self._defaults = (*self._defaults, PagePart(title, area))
        self._take(arranged(self._defaults, self._text))

    def splitter(self, what: str, size: str, *, is_column: bool) -> None:
        """Add a line that is dragged to change a size.

        Args:
            what: the size, for a person who does not see it.
            size: its name, which the style of the page has as `--PAGE-SIZE`.
            is_column: it changes a width.
        """
        line = (
            ui.element("div")
            .classes(f"splitter of-{size}")
            .props(
                f'role="separator" tabindex="0" aria-valuenow="0" '
                f'aria-orientation="{"vertical" if is_column else "horizontal"}"'
            )
        )
        line.props["aria-label"] = what
        line.props["data-size"] = f"--{self._page}-{size}"

    def is_shown(self, title: str) -> bool:
        """Return whether a part is shown."""
        return next(part.is_shown for part in self._parts if part.title == title)

    def ask(self) -> None:
        """Open the dialog in which the parts are arranged."""
        with self._dialog("Layout"):
            ui.label("Layout of this page").classes("title")
            ui.label("Lines between the parts can be dragged. This browser keeps it.").classes(
                "soft"
            )
            rows = ui.element("div").classes("wide")
            self._list(rows)
            ui.button("As it was delivered", on_click=partial(self._reset, rows), color=None).props(
                "no-caps flat"
            )

    def _list(self, rows: ui.element) -> None:
        rows.clear()
        with rows:
            for part in self._parts:
                with ui.row().classes("layout-row"):
                    shown = ui.checkbox(part.title, value=part.is_shown)
                    shown.on_value_change(partial(self._show, part.title, shown))
                    ui.space()
                    for icon, word, step in (
                        ("arrow_upward", "up", -1),
                        ("arrow_downward", "down", 1),
                    ):
                        button = ui.button(
                            icon=icon,
                            on_click=partial(self._move, rows, part.title, step),
                            color=None,
                        )
                        button.props(f'flat dense round aria-label="{part.title} {word}"')

    def _show(self, title: str, shown: ui.checkbox) -> None:
        self._keep(with_shown(self._parts, title, is_shown=bool(shown.value)))

    def _move(self, rows: ui.element, title: str, step: int) -> None:
        self._keep(moved(self._parts, title, step))
        self._list(rows)

    def _reset(self, rows: ui.element) -> None:
        self._keep(self._defaults)
        ui.run_javascript(f"forgetSizes('--{self._page}-')")
        self._list(rows)

    def _keep(self, parts: tuple[PagePart, ...]) -> None:
        self._take(parts)
        set_cookie(self._cookie, arrangement_text(parts))
        self._on_change()

    def _take(self, parts: tuple[PagePart, ...]) -> None:
        self._parts = parts
        for place, part in enumerate(parts):
            element = self._elements[part.title]
            element.style(f"order: {place}")
            element.set_visibility(part.is_shown)


T = TypeVar("T")


async def on_own_thread(deed: Callable[[], T]) -> T:
    """Return what a function returns that may take minutes, such as to pause a run.

    A pool of threads would queue a protective stop behind the commands that wait, and would keep
    the console from ending before they are answered.
    """
    done: Future[T] = Future()
    done.set_running_or_notify_cancel()  # who waits may be cancelled, but not the command

    def work() -> None:
        try:
            done.set_result(deed())
        except Exception as error:  # noqa: BLE001 - the waiting thread gets it
            done.set_exception(error)

    threading.Thread(target=work, name="command", daemon=True).start()
    return await asyncio.wrap_future(done)


_EVERY_S = 0.04  # between two tellings; an operator is promised to see a transition within 100 ms


class Broadcast:
    """Calls a function of each open page on the event loop."""

    def __init__(self) -> None:
        self._shows: dict[str, Callable[[], None]] = {}
        self._loop: asyncio.AbstractEventLoop | None = None
        self._is_resting = False
        self._is_stale = False

    def bind(self) -> None:
        """Use the event loop that runs now."""
        self._loop = asyncio.get_running_loop()

    def add(self, client: Client, show: Callable[[], None]) -> None:
        """Call a function after each change, as long as the page is open."""
        self._shows[client.id] = show
        client.on_delete(lambda: self._shows.pop(client.id, None))

    def wake(self) -> None:
        """Have the pages updated soon; callable from any thread, and before there is a loop."""
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._update)

    def _update(self) -> None:
        if self._is_resting or self._loop is None:
            self._is_stale = True
            return
        self._is_resting, self._is_stale = True, False
        self._loop.call_later(_EVERY_S, self._rested)
        for show in tuple(self._shows.values()):
            show()

    def _rested(self) -> None:
        self._is_resting = False
        if self._is_stale:
            self._update()


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
        if session.is_kept or session.chart is None:
            await self.load_into(session, name)
        else:
            question = f"'{session.chart.name}' has unsaved changes."
            self.ask(question, "Discard and load", partial(self.load_into, session, name))

    async def load_into(self, session: Session, name: str) -> CommandResult:
        """Load a behavior into a session, whatever it has."""
        command = Command(f"load {name}", Verb.LOAD, {"name": name})
        return await self.give(command.text, lambda: session.carry_out(command))

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
