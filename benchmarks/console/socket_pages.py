#!/usr/bin/env python3
"""Pages of Runtime control that paint nothing: which states arrive at their web sockets, and when.

    socket_pages.py ADDRESS PAGES SECONDS

Prints "ready", and after that time one line of JSON: for each page, [time [ms], path of the state]
of each arrival. A page confirms each one at once, as a browser does once it has painted it.
"""

from __future__ import annotations

import asyncio
import json
import re
import sys
import time
import uuid
from typing import Any

import aiohttp
import socketio

LIGHT = re.compile(r'runMethod\((\d+), "light", ')
PAINTED = re.compile(r'"listener_id":"([^"]+)","type":"painted"')
QUERY = re.compile(r"query: \{'client_id': '([^']+)', 'next_message_id': (\d+)")


class SocketPage:
    """A page as its server sees it.

    Attributes:
        seen: time [ms] and path of each state that arrived.
    """

    def __init__(self) -> None:
        self.seen: list[tuple[float, str]] = []
        self._is_open = True
        self._socket = socketio.AsyncClient()
        self._socket.on("run_javascript", self._take)

    async def open(self, address: str) -> None:
        """Fetch the page, and connect its socket."""
        async with aiohttp.ClientSession() as session, session.get(f"{address}/runtime") as page:
            text = await page.text()
        self._client, number = QUERY.search(text).groups()
        self._painted = PAINTED.search(text)[1]
        query = (
            f"client_id={self._client}&next_message_id={number}&implicit_handshake=true"
            f"&document_id={uuid.uuid4()}&tab_id={uuid.uuid4()}"
        )
        await self._socket.connect(
            f"{address}?{query}",
            headers={"Origin": address},
            transports=["websocket"],
            socketio_path="_nicegui_ws/socket.io",
        )

    async def close(self) -> None:
        """Confirm nothing more, and leave."""
        self._is_open = False
        await self._socket.disconnect()

    async def _take(self, message: dict[str, Any]) -> None:
        now_ms = 1000 * time.time()
        found = LIGHT.search(message["code"])
        if found is None or not self._is_open:
            return
        (active, *_), _ = json.JSONDecoder().raw_decode(message["code"], found.end())
        self.seen.append((now_ms, active))
        event = {
            "id": int(found[1]),
            "client_id": self._client,
            "listener_id": self._painted,
            "args": [],
        }
        await self._socket.emit("event", event)


async def main(address: str, count: int, duration_s: float) -> None:
    """Open the pages, listen, and print what arrived."""
    pages = [SocketPage() for _ in range(count)]
    for page in pages:
        await page.open(address)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    await asyncio.sleep(duration_s)
    sys.stdout.write(json.dumps([page.seen for page in pages]) + "\n")
    for page in pages:
        await page.close()


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3])))
