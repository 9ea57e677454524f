"""PyBullet, without the lines that it prints itself: its build time, and "argv[0]="."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def _silenced(descriptor: int) -> Iterator[None]:
    """Drop what C code prints on standard output (1) or standard error (2)."""
    sys.stdout.flush()
    kept, nowhere = os.dup(descriptor), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, descriptor)
    try:
        yield
    finally:
        ctypes.CDLL(None).fflush(None)
        os.dup2(kept, descriptor)
        os.close(kept)
        os.close(nowhere)


with _silenced(2):  # its build time
    import pybullet
    from pybullet_utils.bullet_client import BulletClient


def connect(*, gui: bool = False) -> BulletClient:
    """Return PyBullet's functions, bound to a new world; `gui` opens its window."""
    with _silenced(1):  # "argv[0]="
        return BulletClient(pybullet.GUI if gui else pybullet.DIRECT)
