"""Where design files are dropped, and how they arrive."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from nicegui import run
from nicegui.element import Element
from nicegui.events import GenericEventArguments
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response

from remodel_console.core.access import Role
from remodel_console.edge.order_desk.order_drafts import OrderDrafts
from remodel_console.errors import CommandError
from remodel_console.web.guard import user_of


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


_MOST_BYTES = 100_000_000  # as much as the planner reads


async def take_design(drafts: OrderDrafts, request: Request) -> Response:
    """Write the body of a request to a new draft, and return the draft's key.

    Of a file that is too large, or whose sender has gone, nothing is kept.
    """
    if not user_of(request.scope).role.may(Role.OPERATOR):
        return PlainTextResponse("A watcher sends no design files; this needs an operator.", 403)
    try:
        draft = drafts.new(request.query_params.get("name", ""))
    except CommandError as error:
        return PlainTextResponse(str(error), 409)
    is_whole = False
    try:
        with draft.file.open("wb") as file:
            async for chunk in request.stream():
                if file.tell() + len(chunk) > _MOST_BYTES:
                    return PlainTextResponse(
                        f"{draft.file.name}: is larger than {_MOST_BYTES // 1_000_000} MB, the "
                        "most that is read: is it a design file?",
                        413,
                    )
                await run.io_bound(file.write, chunk)
        is_whole = True
    finally:
        if not is_whole:
            drafts.remove(draft.key)
    return PlainTextResponse(draft.key)
