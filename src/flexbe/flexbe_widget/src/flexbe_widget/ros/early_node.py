"""Become a node while the rest of a program is still being imported."""

from __future__ import annotations

import threading
from collections.abc import Callable

from flexbe_core.ros.master import join_interruptibly, require_master


def begin_node(name: str, limit_s: float) -> Callable[[], None]:
    """Become an anonymous node in the background, without handlers of signals.

    Registering takes about 0.1 s of talking to the master, which a short program can use.

    Args:
        name: of the node.
        limit_s: [s] how long to wait for a master.

    Returns:
        what waits until the process is a node; it raises NoMasterError if there is no master, and
        what rospy.init_node raised.
    """
    errors: list[Exception] = []

    def begin() -> None:
        try:
            require_master(limit_s)
            join_interruptibly(name)
        except Exception as error:  # noqa: BLE001 - raised in the thread that waits
            errors.append(error)

    thread = threading.Thread(target=begin, daemon=True)
    thread.start()

    def wait() -> None:
        thread.join()
        for error in errors:
            raise error

    return wait
