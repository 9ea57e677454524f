"""Wait for something slow without holding up a page, other commands or the end of the console."""

from __future__ import annotations

import asyncio
import contextlib
import threading
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")


async def on_own_thread(deed: Callable[[], T]) -> T:
    """Return what a function returns that may take minutes, such as to pause a run.

    A pool of threads would queue a protective stop behind the commands that wait, and would keep
    the console from ending before they are answered.
    """
    loop = asyncio.get_running_loop()
    done: asyncio.Future[T] = loop.create_future()

    def settle(result: T | None, error: Exception | None) -> None:
        if done.cancelled():
            return
        if error is not None:
            done.set_exception(error)
        else:
            done.set_result(result)  # type: ignore[arg-type]

    def work() -> None:
        result, error = None, None
        try:
            result = deed()
        except Exception as raised:  # noqa: BLE001 - the waiting thread gets it
            error = raised
        with contextlib.suppress(RuntimeError):  # the console has ended meanwhile
            loop.call_soon_threadsafe(settle, result, error)

    threading.Thread(target=work, name="command", daemon=True).start()
    return await done
