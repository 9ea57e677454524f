"""Become a node while the rest of a program is still being imported."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import rosgraph
import rospy

# [s] Wall time between two looks for the master.
_LOOK_EVERY_S = 0.1


def begin_node(name: str, limit_s: float) -> Callable[[], bool]:
    """Become an anonymous node in the background, without handlers of signals.

    Registering takes about 0.1 s of talking to the master, which a short program can use.

    Args:
        name: of the node.
        limit_s: [s] how long to wait for a master.

    Returns:
        what waits until the process is a node and returns True, or False if there is no master;
        it raises what rospy.init_node raised.
    """
    errors: list[Exception] = []
    end = time.monotonic() + limit_s
    is_node = threading.Event()

    def begin() -> None:
        while not rosgraph.is_master_online():
            if time.monotonic() >= end:
                return
            time.sleep(_LOOK_EVERY_S)
        try:
            rospy.init_node(name, anonymous=True, disable_signals=True)
        except Exception as error:  # noqa: BLE001 - raised by whoever waits
            errors.append(error)
        is_node.set()

    thread = threading.Thread(target=begin, daemon=True)
    thread.start()

    def wait() -> bool:
        thread.join()
        for error in errors:
            raise error
        return is_node.is_set()

    return wait
