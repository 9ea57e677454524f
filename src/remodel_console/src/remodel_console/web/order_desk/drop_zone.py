"""A place to drop a file on."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui.element import Element
from nicegui.events import GenericEventArguments


class DropZone(Element, component="../static/drop_zone.js"):
    """Sends a file that is dropped or chosen to an address."""

    def __init__(
        self,
        address: str,
        words: str,
        sent: Callable[[str], Awaitable[object]],
        refused: Callable[[str], object],
        *,
        is_enabled: bool,
    ) -> None:
        """Build it.

        Args:
            address: that gets the content as the body of a POST, and the file's name as `name`.
            words: what a person reads on it.
            sent: gets the answer of the address.
            refused: gets why a file was not taken.
            is_enabled: files are taken.
        """
        super().__init__()
        self._props["address"] = address
        self._props["words"] = words
        self._props["enabled"] = is_enabled

        async def on_sent(event: GenericEventArguments) -> None:
            await sent(str(event.args))

        def on_refused(event: GenericEventArguments) -> None:
            refused(str(event.args))

        self.on("sent", on_sent)
        self.on("refused", on_refused)
