"""Update all open pages after changes: at once, and at most 25 times a second."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from nicegui import Client

_EVERY_S = 0.04  # between two tellings; an operator is promised to see a transition within 100 ms


class Broadcast:
    """Calls a function of each open page on the event loop."""

    def __init__(self) -> None:
        """Begin with no page."""
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
