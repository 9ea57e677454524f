"""The bar of a page: navigation, what waits, the operator and settings."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager

from nicegui import ui
from nicegui.element import Element
from nicegui.events import GenericEventArguments

from remodel_console.core.access import User, tidy_name
from remodel_console.core.inbox import Card
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

        def changed(event: GenericEventArguments) -> None:
            on_hidden(bool(event.args))

        self.on("hidden", changed)

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
_DEEDS = {True: "dark", False: "light"}

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
                    _icon("logout", "Sign out", lambda: ui.navigate.to(LEAVE))
            _icon("notifications", "Notifications", self._ask_notifications)
            self._layout = _icon("dashboard_customize", "Layout", on_layout)
            _icon("contrast", "Dark or light", self._toggle_dark)
            _icon("keyboard", "Keys (?)", self.show_keys)

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
                    with ui.element("dt"):
                        ui.label(key)
                    with ui.element("dd"):
                        ui.label(meaning)

    def _set_single_keys(self, on: bool) -> None:
        self.has_single_keys = on
        set_cookie(KEYS_COOKIE, "on" if on else "off")

    def _toggle_dark(self) -> None:
        self._dark.value = not self._dark.value
        set_cookie(DARK_COOKIE, _DEEDS[bool(self._dark.value)])

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


def _icon(icon: str, title: str, deed: Callable[[], None]) -> ui.button:
    button = ui.button(icon=icon, on_click=deed, color=None)
    return button.props(f'flat dense round title="{title}" aria-label="{title}"')


def set_cookie(name: str, value: str) -> None:
    """Have the browser keep a setting for a year."""
    ui.run_javascript(
        f"document.cookie = '{name}=' + encodeURIComponent({json.dumps(value)}) "
        f"+ '; path=/; max-age={_YEAR_S}; SameSite=Strict'"
    )
