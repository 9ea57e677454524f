"""The bar of a page: navigation, operator and settings; the inbox, and the status line."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from functools import partial

from nicegui import ui
from nicegui.element import Element

from remodel_console.core.commands import User, as_literal, tidy_name, value_words
from remodel_console.core.use_case import duration_words
from remodel_console.core.world import Card, Kind, Notice, Option, Part, World, notices
from remodel_console.web.elements import icon_button, text_in
from remodel_console.web.guard import LEAVE


class Attention(Element, component="static/attention.js"):
    """A badge in the bar, a number in the title of the tab, a notification and a sound.

    A click on the badge goes to the first answer.
    """

    def __init__(
        self, title: str, on_hidden: Callable[[bool], None], *, notify: bool, sound: bool
    ) -> None:
        """Show that nothing waits.

        Args:
            title: of the tab, when nothing waits.
            on_hidden: gets whether the page is in the background, whenever that changes.
            notify: show notifications of the browser.
            sound: play a sound.
        """
        super().__init__()
        self._props["title"] = title
        self._props["notify"] = notify
        self._props["sound"] = sound
        self._props["waiting"] = []
        self._shown: tuple[Card, ...] = ()
        self.on("hidden", lambda event: on_hidden(bool(event.args)))

    def show(self, cards: tuple[Card, ...]) -> None:
        """Show what waits."""
        if cards != self._shown:
            self._shown = cards
            self._props["waiting"] = [f"{card.kind.value}: {card.text}" for card in cards]

    def configure(self, *, notify: bool, sound: bool) -> None:
        """Switch notifications and sound on or off; a browser asks its user once."""
        self._props["notify"] = notify
        self._props["sound"] = sound
        if notify:
            self.run_method("askPermission")


NAME_COOKIE = "remodel_name"
DARK_COOKIE = "remodel_dark"
NOTIFY_COOKIE = "remodel_notify"
SOUND_COOKIE = "remodel_sound"
KEYS_COOKIE = "remodel_keys"
_YEAR_S = 365 * 24 * 3600

PAGES = (
    ("Overview", "/overview"),
    ("Order desk", "/order_desk"),
    ("Runtime control", "/runtime"),
    ("Editor", "/editor"),
    ("Replay", "/replay"),
    ("Statistics", "/statistics"),
    ("Configuration", "/configuration"),
)
Keys = tuple[tuple[str, str], ...]
# On a phone, the tabs are wider than the page.
SHOW_TAB = (
    "document.querySelector('.bar .here')?.scrollIntoView({ inline: 'center', block: 'nearest' })"
)


class Bar:
    """Built once for each page.

    Attributes:
        name: of the operator, for the record of commands.
        is_dark: which of the two themes is shown.
        has_single_keys: keys without Ctrl or Alt do something on this page.
    """

    def __init__(
        self,
        title: str,
        cookies: Mapping[str, str],
        keys: Keys,
        dialog: Callable[[str], AbstractContextManager[ui.dialog]],
        on_hidden: Callable[[bool], None],
        on_layout: Callable[[], None],
        *,
        user: User,
        signs_in: bool,
        is_operator: bool,
    ) -> None:
        """Build the bar.

        Args:
            title: of the page.
            cookies: of the browser, which keep its settings.
            keys: those of the page, for the list.
            dialog: opens a dialog of a name.
            on_hidden: gets whether the page is in the background, whenever that changes.
            on_layout: opens what arranges the page.
            user: of the page; without a name, one can be typed.
            signs_in: a user who has a name has signed in here, and can sign out.
            is_operator: the user may give the page's commands.
        """
        self.name = user.name or tidy_name(cookies.get(NAME_COOKIE, ""))
        self.has_single_keys = cookies.get(KEYS_COOKIE) != "off"
        self._keys = keys
        self._dialog = dialog
        self._notify = cookies.get(NOTIFY_COOKIE) == "on"
        self._sound = cookies.get(SOUND_COOKIE) == "on"
        self._dark = ui.dark_mode(value=cookies.get(DARK_COOKIE) == "dark")
        with ui.header().classes("bar"):
            ui.label("REMODEL").classes("brand")
            with ui.element("nav").props('aria-label="Pages"'):
                for number, (name, address) in enumerate(PAGES, start=1):
                    link = ui.link(name, address).classes("tab")
                    link.props(f'title="Alt+{number}" accesskey="{number}"')
                    if name == title:
                        link.classes("here").props('aria-current="page"')
            ui.run_javascript(SHOW_TAB)
            ui.space()
            settings = {"notify": self._notify, "sound": self._sound}
            self._attention = Attention(f"{title} · REMODEL", on_hidden, **settings)
            if not is_operator:
                ui.label("read-only").classes("watching")
            if not user.name:
                self._who = ui.button(self.name or "Your name", on_click=self._ask_name, color=None)
                self._who.props('flat dense no-caps title="Your name, for the record of commands"')
                self._who.classes("who")
            else:
                ui.label(f"{user.name}, {user.role.value}").classes("user")
                if signs_in:
                    icon_button("logout", "Sign out", lambda: ui.navigate.to(LEAVE))
            icon_button("notifications", "Notifications", self._ask_notifications)
            self._layout = icon_button("dashboard_customize", "Layout", on_layout)
            icon_button("contrast", "Dark or light", self._toggle_dark)
            icon_button("keyboard", "Keys (?)", self.show_keys)

    @property
    def is_dark(self) -> bool:
        """Return whether the dark theme is shown."""
        return bool(self._dark.value)

    def offer_layout(self, *, is_offered: bool) -> None:
        """Show the button that arranges the page only where there is something to arrange."""
        self._layout.set_visibility(is_offered)

    def show_waiting(self, cards: tuple[Card, ...]) -> None:
        """Draw attention to what waits for a person."""
        self._attention.show(cards)

    def show_keys(self) -> None:
        """Show which keys do what, and whether single keys do anything."""
        pages = ((f"Alt+{n}", name) for n, (name, _) in enumerate(PAGES, start=1))
        canvas = (("+  -  0", "zoom in, zoom out, show all (after a click on the drawing)"),)
        with self._dialog("Keys"):
            ui.label("Keys").classes("title")
            single = ui.checkbox("Keys without Ctrl and Alt", value=self.has_single_keys)
            single.on_value_change(lambda: self._set_single_keys(bool(single.value)))
            with ui.element("dl").classes("keys"):
                for key, meaning in (*self._keys, *canvas, *pages, ("?", "this list")):
                    text_in("dt", key)
                    text_in("dd", meaning)

    def _set_single_keys(self, on: bool) -> None:
        self.has_single_keys = on
        set_cookie(KEYS_COOKIE, "on" if on else "off")

    def _toggle_dark(self) -> None:
        self._dark.value = not self._dark.value
        set_cookie(DARK_COOKIE, "dark" if self._dark.value else "light")

    def _ask_name(self) -> None:
        with self._dialog("Operator") as dialog:
            ui.label("Your name").classes("title")
            ui.label("The console records your commands under this name.").classes("soft")
            entry = ui.input("Name", value=self.name).props("outlined dense autofocus")

            def take() -> None:
                self.name = tidy_name(entry.value or "")
                self._who.text = self.name or "Your name"
                set_cookie(NAME_COOKIE, self.name)
                dialog.close()

            entry.on("keydown.enter", take)
            ui.button("Save", on_click=take).props("no-caps unelevated")

    def _ask_notifications(self) -> None:
        with self._dialog("Notifications"):
            ui.label("When the cell waits for a person").classes("title")
            notify = ui.checkbox("Show a notification of the browser", value=self._notify)
            sound = ui.checkbox("Play a sound", value=self._sound)

            def take() -> None:
                self._notify, self._sound = bool(notify.value), bool(sound.value)
                set_cookie(NOTIFY_COOKIE, "on" if self._notify else "off")
                set_cookie(SOUND_COOKIE, "on" if self._sound else "off")
                self._attention.configure(notify=self._notify, sound=self._sound)

            notify.on_value_change(take)
            sound.on_value_change(take)


def set_cookie(name: str, value: str) -> None:
    """Have the browser keep a setting for a year."""
    ui.run_javascript(
        f"document.cookie = '{name}=' + encodeURIComponent({json.dumps(value)}) "
        f"+ '; path=/; max-age={_YEAR_S}; SameSite=Strict'"
    )


_SHOW_PAGE = f"() => {{ document.body.classList.toggle('whole-page'); {SHOW_TAB}; }}"


# Makes buttons that only operators can press: (text, deed, icon=None, look="main").
Button = Callable[..., ui.button]
Give = Callable[[Card, Option], Awaitable[object]]
Enter = Callable[[Card, str | None], Awaitable[object]]


class Inbox:
    """Shows the cards; one that stays keeps its elements, so that no click and no text is lost."""

    def __init__(self, button: Button, give: Give, enter: Enter) -> None:
        """Begin empty.

        Args:
            button: makes buttons.
            give: sends the answer to a card.
            enter: sends the literal that a state asks for; None: no value.
        """
        self._button, self._give, self._enter = button, give, enter
        self._shown: dict[Card, _Shown] = {}
        self.area = ui.element("section").classes("inbox")
        self.area.props('aria-label="Waiting for you" tabindex="-1"')
        with self.area:
            self._cards = ui.element("div").classes("inbox-cards")
            show_page = ui.button("Show the page", color=None).classes("quiet show-page")
            show_page.props("no-caps unelevated").on("click", js_handler=_SHOW_PAGE)
        self.area.set_visibility(False)

    def show(self, cards: tuple[Card, ...], world: World) -> None:
        """Show cards, and how much time is left to answer them."""
        for card in self._shown.keys() - set(cards):
            self._shown.pop(card).element.delete()
        for card in cards:
            if card not in self._shown:
                with self._cards:
                    self._shown[card] = _Shown(card, self._button, self._give, self._enter)
            self._shown[card].show_time(world)
        self.area.set_visibility(bool(cards))


class _Shown:
    """The elements of a card."""

    def __init__(self, card: Card, button: Button, give: Give, enter: Enter) -> None:
        self._card = card
        with ui.element("div").classes("request").props('role="alert"') as self.element:
            with ui.element("div").classes("request-words"):
                ui.label(card.kind.value).classes("soft")
                ui.label(card.text).classes("question")
                if card.details:
                    ui.label(card.details).classes("soft")
                self._time = ui.label().classes("soft")
                self._time.set_visibility(False)
            with ui.element("div").classes("request-answers"):
                if card.kind is Kind.INPUT:
                    _add_entry(card, button, enter)
                for place, option in enumerate(card.options):
                    look = "main" if place == 0 else "quiet"
                    with button(option.words, partial(give, card, option), look=look) as made:
                        if option.meaning:
                            ui.label(option.meaning).classes("meaning")
                    made.classes("choice")

    def show_time(self, world: World) -> None:
        """Show how much time is left."""
        question, use_case = self._card.question, world.use_case
        left_s = question.left_s(use_case.stamp_s) if question and use_case else None
        if left_s is None:
            return
        self._time.text = (
            f"{duration_words(left_s)} left to answer; after that the question escalates, and the "
            "run goes on without an answer."
        )
        self._time.set_visibility(True)


def _add_entry(card: Card, button: Button, enter: Enter) -> None:
    """Add the field of a value, what its text means, and the buttons."""
    entry = ui.input("Value").props("outlined dense").classes("wide")
    meaning = ui.label(value_words("")).classes("soft")
    entry.on_value_change(lambda: meaning.set_text(value_words(entry.value or "")))

    async def send() -> None:
        if (entry.value or "").strip():
            await enter(card, as_literal(entry.value))

    entry.on("keydown.enter", send)
    with ui.row().classes("controls"):
        button("Send the value", send, icon="check")
        button("Enter no value", partial(enter, card, None), look="quiet")


_NO_DATABASE = "orders cannot be stored; start the console with database:=URL"
_NAMES = {Part.ENGINE: "Engine", Part.SUPERVISOR: "Supervisor", Part.CELL: "Cell"}


class StatusLine:
    """Built once for each page."""

    def __init__(
        self,
        parts: Sequence[Part],
        database: Callable[[], str],
        dialog: Callable[[str], AbstractContextManager[ui.dialog]],
    ) -> None:
        """Build the line.

        Args:
            parts: what the page needs to be running.
            database: returns that orders are stored in, as it is shown; empty without one.
            dialog: opens a dialog of a name.
        """
        self._parts = parts
        self._dialog = dialog
        self._database = database
        self._shown: object = None
        self._found: tuple[Notice, ...] = ()
        with ui.row().classes("status-line").props('role="status"'):
            self._ros = ui.label()
            self._chips = {part: ui.label() for part in _NAMES}
            self._database_chip = ui.label()
            self._more = ui.button("What to do", on_click=self._explain)
            self._more.props("flat dense no-caps color=primary")

    def show(self, world: World) -> None:
        """Show what runs."""
        self._found = tuple(notices(world, self._parts))
        runs = {part: world.has(part) for part in self._chips}
        database = self._database()
        shown = (self._found, world.has_master, world.servers, world.cell_kind, runs, database)
        if shown == self._shown:
            return
        self._shown = shown
        missing = {notice.part: notice.what for notice in self._found}
        _show(self._ros, "ROS", missing.get(None), runs=world.has_master)
        for part, chip in self._chips.items():
            what = missing.get(part)
            if part is Part.ENGINE:
                what = what or missing.get(Part.MIRROR)
            _show(chip, _words(part, world), what, runs=runs[part])
        _show(
            self._database_chip,
            "Database" if database else "No database",
            None,
            runs=bool(database),
        )
        self._database_chip.props["title"] = database or _NO_DATABASE
        self._more.set_visibility(bool(self._found))

    def _explain(self) -> None:
        with self._dialog("What to do"):
            for notice in self._found:
                ui.label(notice.what).classes("title")
                ui.label(f"{notice.meaning[:1].upper()}{notice.meaning[1:]}. In a terminal:")
                ui.label(notice.remedy).classes("code")


def _words(part: Part, world: World) -> str:
    if part is not Part.CELL or world.cell_kind is None:
        return _NAMES[part]
    ending = "y" if world.servers == 1 else "ies"
    return f"Cell: {world.cell_kind.value}, {world.servers} abilit{ending}"


def _show(chip: ui.label, words: str, missing: str | None, *, runs: bool) -> None:
    """Show a chip: green, red if the page misses it, hollow if it does not."""
    chip.text = missing or words
    look = "gone notice" if missing else "there" if runs else "absent"
    chip.classes(replace=f"presence {look}")
