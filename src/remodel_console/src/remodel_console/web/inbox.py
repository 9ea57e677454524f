"""The inbox on a page: a card for each thing that waits for a person."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import partial
from typing import Protocol

from nicegui import ui

from remodel_console.core.inbox import Card, Kind, Option
from remodel_console.core.input_value import as_literal, value_words
from remodel_console.core.use_case.use_case import duration_words
from remodel_console.core.world import World
from remodel_console.web.bar import SHOW_TAB

_SHOW_PAGE = f"() => {{ document.body.classList.toggle('whole-page'); {SHOW_TAB}; }}"


class Button(Protocol):
    """Makes buttons that only operators can press."""

    def __call__(
        self, text: str, deed: Callable[[], object], *, icon: str | None = None, look: str = "main"
    ) -> ui.button:
        """Return a button."""


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
