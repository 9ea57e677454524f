"""PyBullet, without the lines that it prints itself: its build time, and "argv[0]="."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def _silenced() -> Iterator[None]:
    """Drop what C code prints on standard output."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        ctypes.CDLL(None).fflush(None)
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


with _silenced():
    import pybullet
    from pybullet_utils.bullet_client import BulletClient


def connect(*, gui: bool = False) -> BulletClient:
    """Return PyBullet's functions, bound to a new world; `gui` opens its window."""
    with _silenced():
        return BulletClient(pybullet.GUI if gui else pybullet.DIRECT)
