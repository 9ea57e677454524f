"""A command that takes minutes holds up nothing else."""

import asyncio
import threading

import pytest

from remodel_console.web.page import on_own_thread


def test_commands_that_wait_do_not_queue_another_one():
    standstill = threading.Event()

    async def give():
        waiting = [asyncio.create_task(on_own_thread(standstill.wait)) for _ in range(100)]
        assert await asyncio.wait_for(on_own_thread(lambda: "stopped"), 20.0) == "stopped"
        assert not any(task.done() for task in waiting)
        standstill.set()
        assert all(await asyncio.gather(*waiting))

    asyncio.run(give())


def test_an_error_is_raised_where_the_result_is_awaited():
    with pytest.raises(ZeroDivisionError):
        asyncio.run(on_own_thread(lambda: 1 // 0))


def test_a_console_that_ends_does_not_wait():
    standstill = threading.Event()

    async def give_up():
        with pytest.raises(asyncio.TimeoutError):
            await asyncio.wait_for(on_own_thread(standstill.wait), 0.01)

    asyncio.run(give_up())
    waiting = [thread for thread in threading.enumerate() if thread.name == "command"]
    standstill.set()
    assert waiting
    for thread in waiting:
        assert thread.daemon
        thread.join(20.0)
        assert not thread.is_alive()
