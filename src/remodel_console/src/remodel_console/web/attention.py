"""Draws the attention of a person to what waits, also while the page is not in view."""

from __future__ import annotations

from collections.abc import Callable

from nicegui.element import Element
from nicegui.events import GenericEventArguments

from remodel_console.core.inbox import Card


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
