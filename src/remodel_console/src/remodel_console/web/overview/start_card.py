"""What Overview offers where nothing runs: to start everything here, with a sample order."""

from __future__ import annotations

from collections.abc import Callable, Coroutine

from nicegui import ui

from remodel_console.core.answer import DONE
from remodel_console.core.world import Part, World
from remodel_console.web.page import Page

_CELLS = {
    False: ("Simulated cell", "physics and cameras; a wire takes about a minute"),
    True: ("Fake cell", "no physics and no pictures; abilities answer at once"),
}
_NEXT = "Orders of your own: drop a wire list or a design on the Order desk."


class StartCard:
    """Built once; shown while nothing runs, and while what was started here is starting."""

    def __init__(self, page: Page) -> None:
        """Build the card."""
        self._page = page
        self._everything = page.console.everything
        with ui.element("div").classes("start-card wide") as self._card:
            self._title = ui.label().classes("title")
            self._words = ui.label().classes("soft")
            self._trouble = ui.label().classes("code lines")
            with ui.column().classes("choices") as self._choices:
                for fake, (name, means) in _CELLS.items():
                    page.button(name, self._starting(fake), icon="play_arrow")
                    ui.label(means).classes("soft")
            self._stop = page.button("Stop what was started here", self._end, look="quiet")

    def show(self, world: World) -> bool:
        """Show what fits; return whether an order can be started."""
        runs = [part for part in (Part.ENGINE, Part.SUPERVISOR, Part.CELL) if world.has(part)]
        is_ours, trouble = self._everything.is_running, self._everything.trouble
        is_starting = is_ours and len(runs) < 3
        is_lost = world.has_lost_run and not self._everything.was_ended
        is_offered = not runs and not is_ours and not is_lost
        self._card.set_visibility(is_offered or is_ours)
        self._choices.set_visibility(is_offered)
        self._stop.set_visibility(is_ours)
        self._trouble.set_visibility(bool(trouble))
        self._trouble.text = trouble
        if is_offered:
            self._title.text = "Nothing runs here" if not trouble else "It has ended by itself"
            self._words.text = (
                "Start engine, supervisor and a cell on this computer, and wire the first wires of "
                "a sample order:"
            )
        elif is_starting:
            missing = {Part.ENGINE, Part.SUPERVISOR, Part.CELL} - set(runs)
            names = ", ".join(sorted(part.value for part in missing))
            self._title.text, self._words.text = "Starting", f"waiting for: {names}"
        else:
            self._title.text, self._words.text = "Started here", _NEXT
        return not is_offered and not is_starting

    def _starting(self, fake: bool) -> Callable[[], Coroutine[None, None, None]]:
        async def start() -> None:
            page, name = self._page, _CELLS[fake][0].lower()
            by = page.actor.name
            answer = await page.give(
                f"start everything with a {name}",
                lambda: page.console.start_everything(by, fake=fake),
            )
            if answer.state == DONE and not self._card.is_deleted:
                self.show(page.console.live.world)

        return start

    async def _end(self) -> None:
        page = self._page

        page.ask(
            "Stop engine, supervisor and cell? A run that is under way is interrupted.",
            "Stop them",
            lambda: page.give("stop what was started here", page.console.stop_everything),
        )
